//! Switch state: global and selective (CiA 305, 6.3).

use super::dialogue::{
    address, configure, expect_configuration, expect_heard, expect_silence, expect_waiting, parts, select, tell, wait,
};
use crate::bench::Bench;
use crate::case;
use crate::verdict::Judged;
use canvass_analyzer::wire::lss::{Part, Request, Response};
use canvass_analyzer::wire::nmt::Command;

/// The slave executes switch state global to configuration and back, and does not answer it.
#[case(id = "305/switch-global/both-ways", clause = "CiA 305 6.3.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSwitchGlobalIgnored])]
fn both_ways(bench: &mut Bench<'_>) -> Judged {
    let answer = tell(bench, Request::SwitchGlobal { mode: 1 })?;
    bench.check(expect_silence("switch state global", answer))?;
    expect_configuration(bench, "switch state global to configuration")?;
    let answer = tell(bench, Request::SwitchGlobal { mode: 0 })?;
    bench.check(expect_silence("switch state global", answer))?;
    expect_waiting(bench, "switch state global to waiting")
}

/// Reserved modes of switch state global have no effect.
#[case(id = "305/switch-global/reserved-mode", clause = "CiA 305 6.3.2", confidence = Attested, level = Should,
       needs = [Lss, Alone], catches = [LssReservedModeWaits])]
fn reserved_mode(bench: &mut Bench<'_>) -> Judged {
    for mode in [2, 127, 255] {
        configure(bench)?;
        tell(bench, Request::SwitchGlobal { mode })?;
        expect_configuration(bench, &format!("the reserved mode {mode}"))?;
    }
    wait(bench)?;
    for mode in [2, 255] {
        tell(bench, Request::SwitchGlobal { mode })?;
        expect_waiting(bench, &format!("the reserved mode {mode}"))?;
    }
    wait(bench)
}

/// The four parts of its LSS address, in order, switch the slave to configuration; the slave answers the last part with
/// 44h.
#[case(id = "305/switch-selective/right", clause = "CiA 305 6.3.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSelectiveUnanswered])]
fn right(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let heard = select(bench, &parts(address), bench.timing().lss)?;
    let duty = "only the last part of the address is answered".to_owned();
    bench.check(expect_heard(duty, Some(Response::Switched), &heard))?;
    expect_configuration(bench, "switch state selective")?;
    wait(bench)
}

/// Sends parts that must not switch the slave, and requires that it does not answer and stays in waiting.
fn unselected(bench: &mut Bench<'_>, parts: &[(Part, u32)], what: &str) -> Judged {
    let heard = select(bench, parts, bench.timing().silence)?;
    bench.check(expect_heard(format!("{what} is not answered"), None, &heard))?;
    expect_waiting(bench, what)?;
    wait(bench)
}

fn one_wrong(bench: &mut Bench<'_>, wrong: Part) -> Judged {
    let mut other = address(bench)?;
    if let Some(part) = other.get_mut(wrong as usize) {
        *part ^= 1;
    }
    unselected(bench, &parts(other), &format!("switch state selective with another {}", wrong.name()))
}

/// A slave with another vendor-ID is not switched.
#[case(id = "305/switch-selective/wrong-vendor", clause = "CiA 305 6.3.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSelectiveSerialOnly])]
fn wrong_vendor(bench: &mut Bench<'_>) -> Judged {
    one_wrong(bench, Part::VendorId)
}

/// A slave with another product code is not switched.
#[case(id = "305/switch-selective/wrong-product", clause = "CiA 305 6.3.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSelectiveSerialOnly])]
fn wrong_product(bench: &mut Bench<'_>) -> Judged {
    one_wrong(bench, Part::ProductCode)
}

/// A slave with another revision number is not switched.
#[case(id = "305/switch-selective/wrong-revision", clause = "CiA 305 6.3.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSelectiveSerialOnly])]
fn wrong_revision(bench: &mut Bench<'_>) -> Judged {
    one_wrong(bench, Part::RevisionNumber)
}

/// A slave with another serial number is not switched.
#[case(id = "305/switch-selective/wrong-serial", clause = "CiA 305 6.3.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSelectiveThreeParts])]
fn wrong_serial(bench: &mut Bench<'_>) -> Judged {
    one_wrong(bench, Part::SerialNumber)
}

/// The parts of the LSS address switch the slave only in their order.
///
/// CANopenNode and zencan accept them in any order if the serial number comes last.
#[case(id = "305/switch-selective/order", clause = "CiA 305 6.3.3", confidence = Attested, level = Should,
       needs = [Lss, Alone], catches = [LssSelectiveAnyOrder])]
fn order(bench: &mut Bench<'_>) -> Judged {
    let mut mixed = parts(address(bench)?);
    mixed.swap(0, 1);
    unselected(bench, &mixed, "an address in another order")
}

/// A slave stays in waiting if it receives parts of another LSS address between the parts of its own.
///
/// CANopenNode compares each part separately, so that it accepts two addresses whose parts are interleaved: the case
/// only records this behaviour.
#[case(id = "305/switch-selective/interleaved", clause = "CiA 305 6.3.3", confidence = Attested, level = Open,
       needs = [Lss, Alone], catches = [LssSelectiveMismatchIgnored])]
fn interleaved(bench: &mut Bench<'_>) -> Judged {
    let own = parts(address(bench)?);
    let mut mixed = Vec::new();
    for (part, value) in own {
        mixed.push((part, value));
        if part == Part::RevisionNumber {
            // The master addresses another device in between.
            mixed.push((Part::VendorId, value ^ 0x55));
        }
    }
    unselected(bench, &mixed, "an address interleaved with another address")
}

/// In configuration the slave does not answer switch state selective, which has no effect.
#[case(id = "305/switch-selective/in-configuration", clause = "CiA 305 6.3.3", confidence = Attested, level = Should,
       needs = [Lss, Alone], catches = [LssSelectiveInConfiguration])]
fn in_configuration(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    configure(bench)?;
    let heard = select(bench, &parts(address), bench.timing().silence)?;
    let duty = "in configuration switch state selective is not answered".to_owned();
    bench.check(expect_heard(duty, None, &heard))?;
    expect_configuration(bench, "switch state selective in configuration")?;
    wait(bench)
}

/// LSS works in the NMT state stopped as it does in pre-operational.
#[case(id = "305/state/stopped", clause = "CiA 305", confidence = Unknown, level = Should,
       needs = [Lss, Alone], catches = [LssSwitchGlobalIgnored])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    tell(bench, Request::SwitchGlobal { mode: 1 })?;
    expect_configuration(bench, "switch state global in stopped")?;
    wait(bench)?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    Ok(())
}
