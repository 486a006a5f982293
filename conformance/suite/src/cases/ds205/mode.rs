//! Operation and configuration: switch mode global, switch mode selective.

use super::{address, exchange, expect_silence, is_configuring, other};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::lmt::{Part, Request, Seven};

/// Switch mode global leads into configuration and back without an answer; only in configuration the slave answers
/// inquiries and takes configurations.
#[case(id = "205/switch-global/modes", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtAnsweredInOperation])]
fn modes(bench: &mut Bench<'_>) -> Judged {
    for part in Part::ALL {
        expect_silence(bench, Request::Inquire { part }, "in operation")?;
    }
    expect_silence(bench, Request::SwitchGlobal { mode: 1 }, "in operation")?;
    let configuring = is_configuring(bench)?;
    expect_silence(bench, Request::SwitchGlobal { mode: 0 }, "in configuration")?;
    demand(configuring, || Reason::new("mode 1 leads into configuration", "answers to inquiries", "silence"))?;
    let left = !is_configuring(bench)?;
    bench.check(demand(left, || Reason::new("mode 0 leads back to operation", "no answers to inquiries", "answers")))
}

/// Modes other than 0 and 1 are reserved and change nothing.
#[case(id = "205/switch-global/reserved", clause = "CiA DS-205", confidence = Unknown, level = Should,
       needs = [Alone, Lmt], catches = [LmtReservedModeObeyed])]
fn reserved(bench: &mut Bench<'_>) -> Judged {
    let mut obeyed = None;
    for mode in [2, 3, 0x7F, 0xFF] {
        exchange(bench, Request::SwitchGlobal { mode })?;
        if is_configuring(bench)? {
            obeyed = obeyed.or(Some(mode));
            exchange(bench, Request::SwitchGlobal { mode: 0 })?;
        }
    }
    bench.check(demand(obeyed.is_none(), || {
        let actual = format!("mode {} leads into configuration", obeyed.unwrap_or_default());
        Reason::new("reserved modes change nothing", "operation", actual)
    }))
}

/// Gives an address part by part; says whether the slave is in configuration then, and leads it back.
fn select(bench: &mut Bench<'_>, address: [Seven; 3]) -> Result<bool, Stop> {
    for (part, value) in Part::ALL.into_iter().zip(address) {
        exchange(bench, Request::SwitchSelective { part, value })?;
    }
    let selected = is_configuring(bench)?;
    exchange(bench, Request::SwitchGlobal { mode: 0 })?;
    Ok(selected)
}

/// The slave whose manufacturer name, product name and serial number are given goes into configuration without an
/// answer: the 44h of LSS does not exist in LMT.
#[case(id = "205/switch-selective/silent", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtSwitchSelectiveAnswered])]
fn silent(bench: &mut Bench<'_>) -> Judged {
    let own = address(bench)?;
    demand(select(bench, own)?, || {
        Reason::new("the own address leads into configuration", "answers to inquiries", "silence")
    })?;
    for (part, value) in Part::ALL.into_iter().zip(own) {
        let judged = expect_silence(bench, Request::SwitchSelective { part, value }, "even where it fits");
        if judged.is_err() {
            exchange(bench, Request::SwitchGlobal { mode: 0 })?;
        }
        judged?;
    }
    exchange(bench, Request::SwitchGlobal { mode: 0 })?;
    Ok(())
}

fn unselected(bench: &mut Bench<'_>, parts: &[Part]) -> Judged {
    let own = address(bench)?;
    for &part in parts {
        let mut wrong = own;
        if let Some(value) = wrong.get_mut(part as usize) {
            *value = other(*value);
        }
        demand(!select(bench, wrong)?, || {
            let duty = format!("the address of a slave with another {} leads nobody into configuration", part.name());
            Reason::new(duty, "operation", "answers to inquiries")
        })?;
    }
    // Silence means something only if the own address is heard.
    demand(select(bench, own)?, || {
        Reason::new("the own address leads into configuration", "answers to inquiries", "silence")
    })
    .or_inconclusive()
}

/// Switch mode selective with another serial number leaves the slave in operation.
#[case(id = "205/switch-selective/other-serial-number", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtSerialNotCompared, LmtAnsweredInOperation])]
fn other_serial_number(bench: &mut Bench<'_>) -> Judged {
    unselected(bench, &[Part::SerialNumber])
}

/// Switch mode selective with another manufacturer or product name leaves the slave in operation.
#[case(id = "205/switch-selective/other-name", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtNamesNotCompared, LmtAnsweredInOperation])]
fn other_name(bench: &mut Bench<'_>) -> Judged {
    unselected(bench, &[Part::ManufacturerName, Part::ProductName])
}
