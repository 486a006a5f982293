//! The effect of resets on parameters that were not stored (CiA 301, 7.3.2.2.1).

use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;

/// Reset communication sets communication parameters that were changed but not stored to their power-on values.
#[case(id = "301/nmt/reset-communication/parameters", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [ScratchObject], catches = [NmtResetCommunicationKeepsParameters, ParameterDriftsAtReset])]
fn reset_communication(bench: &mut Bench<'_>) -> Judged {
    power_on_value(bench, Command::RESET_COMMUNICATION)
}

/// Reset node sets communication parameters that were changed but not stored to their power-on values.
#[case(id = "301/nmt/reset-node/parameters", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [ScratchObject], catches = [NmtResetNodeKeepsParameters, ParameterDriftsAtReset], cct = "9.1")]
fn reset_node(bench: &mut Bench<'_>) -> Judged {
    power_on_value(bench, Command::RESET_NODE)
}

fn power_on_value(bench: &mut Bench<'_>, command: Command) -> Judged {
    let mut parameters = bench.scratch_objects()?;
    parameters.retain(|scratch| scratch.multiplexer.index.0 < 0x2000);
    if parameters.is_empty() {
        let reason = Reason::new("a communication parameter can be written without consequence", "one", "none");
        return Err(Stop::NotApplicable(reason));
    }
    stores_on_command_only(bench)?;
    // After the reset of the preparation, the device has its power-on values. A parameter that it refuses to change
    // keeps its value.
    let mut changed = Vec::new();
    for scratch in parameters {
        if bench.download(scratch.multiplexer, &scratch.other)?.outcome == Outcome::Downloaded {
            match bench.expect_effect(scratch.multiplexer, &scratch.other) {
                // This parameter keeps its value; the others are still judged.
                Err(Stop::Inconclusive(_)) => {}
                effect => {
                    effect?;
                    changed.push(scratch);
                }
            }
        }
    }
    if changed.is_empty() {
        let reason = Reason::new("a communication parameter accepts another value", "a confirmation", "none");
        return Err(Stop::Inconclusive(reason));
    }
    bench.reset(command)?;
    bench.each(changed, |bench, scratch| {
        let now = bench.read(scratch.multiplexer)?;
        let duty = format!("{} has its power-on value after {command}", scratch.multiplexer);
        bench.check(has(&scratch, duty, &scratch.value, now))
    })
}

/// A value that a device stores autonomously becomes its power-on value as soon as it is written.
fn stores_on_command_only(bench: &mut Bench<'_>) -> Judged {
    if bench.stores_by_itself()? {
        let reason = Reason::new("parameters are stored on command only", "bit 1 of 1010h:01 is 0", "1");
        return Err(Stop::NotApplicable(reason));
    }
    Ok(())
}

/// Writes another value, resets the device, and reads the value.
fn changed_and_reset(bench: &mut Bench<'_>, scratch: &Scratch, command: Command) -> Result<Vec<u8>, Stop> {
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.reset(command)?;
    bench.read(scratch.multiplexer)
}

fn has(scratch: &Scratch, duty: String, right: &[u8], now: Vec<u8>) -> crate::verdict::Check {
    demand(now == right, || {
        let right = Observation::Value(right.to_vec());
        Breach::new(scratch.multiplexer, duty).expected(right).found(Observation::Value(now))
    })
}

/// Reset communication does not change the parameters of the application (2000h and above).
#[case(id = "301/nmt/reset-communication/application", clause = "CiA 301 7.3.2.2.1", confidence = Cited,
       level = Must, needs = [ApplicationParameter], catches = [NmtResetCommunicationRestoresAll])]
fn application(bench: &mut Bench<'_>) -> Judged {
    let Some(scratch) = bench.application_scratch()? else { return Ok(()) };
    let now = changed_and_reset(bench, &scratch, Command::RESET_COMMUNICATION)?;
    let duty = format!("{} keeps its value after reset communication", scratch.multiplexer);
    bench.check(has(&scratch, duty, &scratch.other, now))
}

/// Reset node sets application parameters that were changed but not stored to their power-on values.
///
/// The case only records the value after the reset of a manufacturer-specific variable that an RPDO can carry, because
/// such a variable is no parameter.
#[case(id = "301/nmt/reset-node/application", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [ApplicationParameter], catches = [NmtResetNodeKeepsParameters])]
fn application_power_on(bench: &mut Bench<'_>) -> Judged {
    let Some(scratch) = bench.application_scratch()? else { return Ok(()) };
    stores_on_command_only(bench)?;
    let now = changed_and_reset(bench, &scratch, Command::RESET_NODE)?;
    let duty = format!("{} has its power-on value after reset node", scratch.multiplexer);
    let checked = has(&scratch, duty, &scratch.value, now);
    let is_variable = bench.rpdo_objects().iter().any(|mapped| mapped.at == scratch.multiplexer)
        && matches!(scratch.multiplexer.index.0, 0x2000..0x6000);
    bench.check(if is_variable { checked.map_err(|breach| Box::new(breach.open())) } else { checked })
}
