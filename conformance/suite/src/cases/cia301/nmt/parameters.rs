//! What resets do to parameters that were not stored (CiA 301, 7.3.2.1).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::Bytes;

/// Reset communication brings communication parameters that were changed but not stored back to their power-on values.
#[case(id = "301/nmt/reset-communication/parameters", clause = "CiA 301 7.3.2.1", confidence = Attested, level = Must,
       needs = [ScratchObject], catches = [NmtResetCommunicationKeepsParameters])]
fn reset_communication(bench: &mut Bench<'_>) -> Judged {
    power_on_value(bench, Command::RESET_COMMUNICATION)
}

/// Reset node brings communication parameters that were changed but not stored back to their power-on values.
#[case(id = "301/nmt/reset-node/parameters", clause = "CiA 301 7.3.2.1", confidence = Attested, level = Must,
       needs = [ScratchObject], catches = [NmtResetNodeKeepsParameters], cct = "9.1")]
fn reset_node(bench: &mut Bench<'_>) -> Judged {
    power_on_value(bench, Command::RESET_NODE)
}

fn power_on_value(bench: &mut Bench<'_>, command: Command) -> Judged {
    let found = bench.scratch_objects()?.into_iter().find(|scratch| scratch.multiplexer.index.0 < 0x2000);
    let Some(scratch) = found else {
        let reason = Reason::new("a communication parameter can be written without consequence", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    // Prepared by a reset, the device holds its power-on values now.
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.reset(command)?;
    let now = bench.read(scratch.multiplexer)?;
    bench.check(demand(now == scratch.value, || {
        let duty = format!("{} has its power-on value after {command}", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.value).to_string(), Bytes(&now).to_string())
    }))
}

/// Reset communication leaves the parameters of the application, 2000h and above, as they are.
#[case(id = "301/nmt/reset-communication/application", clause = "CiA 301 7.3.2.1", confidence = Attested,
       level = Must, needs = [ApplicationParameter], catches = [NmtResetCommunicationRestoresAll])]
fn application(bench: &mut Bench<'_>) -> Judged {
    let Some(scratch) = bench.application_scratch()? else { return Ok(()) };
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    let now = bench.read(scratch.multiplexer)?;
    bench.check(demand(now == scratch.other, || {
        let duty = format!("{} keeps its value over reset communication", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&now).to_string())
    }))
}

/// Reset node brings parameters of the application that were changed but not stored back to their power-on values.
#[case(id = "301/nmt/reset-node/application", clause = "CiA 301 7.3.2.1", confidence = Attested, level = Must,
       needs = [ApplicationParameter], catches = [NmtResetNodeKeepsParameters])]
fn application_power_on(bench: &mut Bench<'_>) -> Judged {
    let Some(scratch) = bench.application_scratch()? else { return Ok(()) };
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.reset(Command::RESET_NODE)?;
    let now = bench.read(scratch.multiplexer)?;
    bench.check(demand(now == scratch.value, || {
        let duty = format!("{} has its power-on value after reset node", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.value).to_string(), Bytes(&now).to_string())
    }))
}
