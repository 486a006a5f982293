//! Switch state: global and selective (CiA 305, 6.3).

use super::dialogue::{
    address, configure, exchange, expect, expect_configuration, expect_silence, expect_waiting, parts, select, wait,
};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, demand};
use canvass_analyzer::wire::lss::{Part, Request, Response};
use canvass_analyzer::wire::nmt::Command;

/// Switch state global into configuration and back is not answered, and obeyed.
#[case(id = "305/switch-global/both-ways", clause = "CiA 305 6.3.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSwitchGlobalIgnored])]
fn both_ways(bench: &mut Bench<'_>) -> Judged {
    let answer = exchange(bench, Request::SwitchGlobal { mode: 1 })?;
    expect_silence("switch state global", answer)?;
    expect_configuration(bench, "switch state global to configuration")?;
    let answer = exchange(bench, Request::SwitchGlobal { mode: 0 })?;
    expect_silence("switch state global", answer)?;
    expect_waiting(bench, "switch state global to waiting")
}

/// Reserved modes of switch state global change nothing.
#[case(id = "305/switch-global/reserved-mode", clause = "CiA 305 6.3.2", confidence = Attested, level = Should,
       needs = [Lss, Alone], catches = [LssReservedModeWaits])]
fn reserved_mode(bench: &mut Bench<'_>) -> Judged {
    for mode in [2, 127, 255] {
        configure(bench)?;
        exchange(bench, Request::SwitchGlobal { mode })?;
        expect_configuration(bench, &format!("the reserved mode {mode}"))?;
    }
    wait(bench)?;
    for mode in [2, 255] {
        exchange(bench, Request::SwitchGlobal { mode })?;
        expect_waiting(bench, &format!("the reserved mode {mode}"))?;
    }
    Ok(())
}

/// The four parts of its address, in order, bring the slave into configuration; the last one is answered by 44h.
#[case(id = "305/switch-selective/right", clause = "CiA 305 6.3.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSelectiveUnanswered])]
fn right(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let heard = select(bench, &parts(address))?;
    demand(heard == [Response::Switched], || {
        Reason::new("the last part of the address is answered", "one 44h", format!("{heard:?}"))
    })?;
    expect_configuration(bench, "switch state selective")?;
    wait(bench)?;
    Ok(())
}

fn one_wrong(bench: &mut Bench<'_>, wrong: Part) -> Judged {
    let mut other = address(bench)?;
    if let Some(part) = other.get_mut(wrong as usize) {
        *part ^= 1;
    }
    let heard = select(bench, &parts(other))?;
    let waiting = expect_waiting(bench, &format!("switch state selective with another {}", wrong.name()));
    wait(bench)?;
    demand(heard.is_empty(), || {
        let duty = format!("an address with another {} is not answered", wrong.name());
        Reason::new(duty, "silence", format!("{heard:?}"))
    })?;
    waiting
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

/// The parts of the address count only in their order.
///
/// CANopenNode and zencan take them in any order as long as the serial number comes last.
#[case(id = "305/switch-selective/order", clause = "CiA 305 6.3.3", confidence = Attested, level = Should,
       needs = [Lss, Alone], catches = [LssSelectiveAnyOrder])]
fn order(bench: &mut Bench<'_>) -> Judged {
    let mut mixed = parts(address(bench)?);
    mixed.swap(0, 1);
    let heard = select(bench, &mixed)?;
    let waiting = expect_waiting(bench, "an address in another order");
    wait(bench)?;
    demand(heard.is_empty(), || {
        Reason::new("an address in another order is not answered", "silence", format!("{heard:?}"))
    })?;
    waiting
}

/// Parts of another address between those of its own keep the slave in waiting.
#[case(id = "305/switch-selective/interleaved", clause = "CiA 305 6.3.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssSelectiveMismatchIgnored])]
fn interleaved(bench: &mut Bench<'_>) -> Judged {
    let own = parts(address(bench)?);
    let mut mixed = Vec::new();
    for (part, value) in own {
        mixed.push((part, value));
        if part == Part::RevisionNumber {
            // Another device is addressed in between.
            mixed.push((Part::VendorId, value ^ 0x55));
        }
    }
    let heard = select(bench, &mixed)?;
    let waiting = expect_waiting(bench, "parts of another address in between");
    wait(bench)?;
    demand(heard.is_empty(), || {
        Reason::new("an address with another one in between is not answered", "silence", format!("{heard:?}"))
    })?;
    waiting
}

/// In configuration switch state selective is not answered and changes nothing.
#[case(id = "305/switch-selective/in-configuration", clause = "CiA 305 6.3.3", confidence = Attested, level = Should,
       needs = [Lss, Alone], catches = [LssSelectiveInConfiguration])]
fn in_configuration(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    configure(bench)?;
    let heard = select(bench, &parts(address))?;
    let stays = expect_configuration(bench, "switch state selective in configuration");
    wait(bench)?;
    demand(heard.is_empty(), || {
        Reason::new("in configuration switch state selective is not answered", "silence", format!("{heard:?}"))
    })?;
    stays
}

/// In configuration the four inquiries give the parts of the LSS address, which are 1018h:01 to 1018h:04.
#[case(id = "305/inquiry/address", clause = "CiA 305 6.5.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssInquirySwapped])]
fn inquiry(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    configure(bench)?;
    let mut wrong = None;
    for (part, right) in parts(address) {
        let answer = exchange(bench, Request::Inquire { part })?;
        if answer != Some(Response::Part { part, value: right }) {
            wrong = wrong.or(Some((part, right, answer)));
        }
    }
    wait(bench)?;
    match wrong {
        None => Ok(()),
        Some((part, right, answer)) => {
            let what = format!("the inquiry of the {}", part.name());
            bench.check(expect(&what, &format!("{right:08X}h, as 1018h has it"), answer, |_| false))
        }
    }
}

/// In configuration the inquiry of the node-ID gives the one in use.
#[case(id = "305/inquiry/node-id", clause = "CiA 305 6.5.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssNodeIdInquiredWrong])]
fn inquiry_node_id(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let answer = exchange(bench, Request::InquireNodeId)?;
    wait(bench)?;
    let own = bench.node().raw();
    bench
        .check(expect("the inquiry of the node-ID", &own.to_string(), answer, |answer| answer == Response::NodeId(own)))
}

/// LSS works in stopped as in pre-operational.
#[case(id = "305/state/stopped", clause = "CiA 305", confidence = Unknown, level = Should,
       needs = [Lss, Alone], catches = [LssSwitchGlobalIgnored])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    in_state(bench, Command::STOP, "stopped")
}

fn in_state(bench: &mut Bench<'_>, command: Command, state: &str) -> Judged {
    bench.command(command)?;
    bench.listen(bench.timing().reaction)?;
    exchange(bench, Request::SwitchGlobal { mode: 1 })?;
    let configured = expect_configuration(bench, &format!("switch state global in {state}"));
    wait(bench)?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    configured
}

/// Command specifiers that CiA 305 does not define are not answered.
#[case(id = "305/reserved-commands", clause = "CiA 305", confidence = Unknown, level = Should,
       needs = [Lss, Alone], catches = [LssUnknownAnswered])]
fn reserved_commands(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let mut wrong = None;
    for command in [0x00, 0x05, 0x10, 0x12, 0x14, 0x16, 0x18, 0x3F, 0x4D, 0x52, 0x5F, 0xFF] {
        let answer = exchange(bench, Request::Unknown { command, tail: [0; 7] })?;
        if answer.is_some() {
            wrong = wrong.or(Some((command, answer)));
        }
    }
    wait(bench)?;
    match wrong {
        None => Ok(()),
        Some((command, answer)) => bench.check(expect_silence(&format!("the reserved command {command:02X}h"), answer)),
    }
}
