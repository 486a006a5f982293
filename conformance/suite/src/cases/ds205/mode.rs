//! The modes operation and configuration: switch mode global, switch mode selective.

use super::dialogue::{address, breach, expect_configuring, expect_silence, is_configuring, other, tell};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Check, Judged, Precondition, Stop, demand};
use canvass_analyzer::wire::lmt::{Part, Request, Seven};
use canvass_bus::observation::Observation;

/// Switch mode global switches the slave to configuration and back without an answer. The slave answers inquiries and
/// accepts configurations in configuration only.
#[case(id = "205/switch-global/modes", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtAnsweredInOperation])]
fn modes(bench: &mut Bench<'_>) -> Judged {
    for part in Part::ALL {
        expect_silence(bench, Request::Inquire { part }, "in operation")?;
    }
    expect_silence(bench, Request::SwitchGlobal { mode: 1 }, "in operation")?;
    expect_configuring(bench, true, "mode 1 switches to configuration")?;
    expect_silence(bench, Request::SwitchGlobal { mode: 0 }, "in configuration")?;
    expect_configuring(bench, false, "mode 0 switches back to operation")
}

/// Modes other than 0 and 1 are reserved and have no effect.
#[case(id = "205/switch-global/reserved", clause = "CiA DS-205", confidence = Unknown, level = Should,
       needs = [Alone, Lmt], catches = [LmtReservedModeObeyed])]
fn reserved(bench: &mut Bench<'_>) -> Judged {
    bench.each([2, 3, 0x7F, 0xFF], |bench, mode| {
        tell(bench, Request::SwitchGlobal { mode })?;
        expect_configuring(bench, false, format!("the reserved mode {mode} has no effect"))?;
        tell(bench, Request::SwitchGlobal { mode: 0 }).map(|_| ())
    })
}

/// Sends an address part by part; returns whether the slave is then in configuration, and switches it back.
fn select(bench: &mut Bench<'_>, address: [Seven; 3]) -> Result<bool, Stop> {
    for (part, value) in Part::ALL.into_iter().zip(address) {
        tell(bench, Request::SwitchSelective { part, value })?;
    }
    let selected = is_configuring(bench)?;
    tell(bench, Request::SwitchGlobal { mode: 0 })?;
    Ok(selected)
}

/// Requires that the slave is in configuration after its own address.
fn expect_selected(selected: bool) -> Check {
    demand(selected, || {
        let breach = breach("its own address switches the slave to configuration");
        breach.expected("an answer to an inquiry").found(Observation::Silence)
    })
}

/// The slave with the given manufacturer name, product name and serial number enters configuration without an answer:
/// LMT does not have the 44h of LSS.
#[case(id = "205/switch-selective/silent", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtSwitchSelectiveAnswered])]
fn silent(bench: &mut Bench<'_>) -> Judged {
    let own = address(bench)?;
    let selected = select(bench, own)?;
    bench.check(expect_selected(selected))?;
    bench.each(Part::ALL.into_iter().zip(own), |bench, (part, value)| {
        expect_silence(bench, Request::SwitchSelective { part, value }, "even where it fits")
    })?;
    tell(bench, Request::SwitchGlobal { mode: 0 }).map(|_| ())
}

fn unselected(bench: &mut Bench<'_>, parts: &[Part]) -> Judged {
    let own = address(bench)?;
    bench.each(parts.iter().copied(), |bench, part| {
        let mut wrong = own;
        if let Some(value) = wrong.get_mut(part as usize) {
            *value = other(*value);
        }
        let selected = select(bench, wrong)?;
        bench.check(demand(!selected, || {
            let duty =
                format!("the address of a slave with another {} switches no slave to configuration", part.name());
            breach(duty).expected(Observation::Silence).found(Observation::named("an answer to an inquiry"))
        }))
    })?;
    // Silence proves something only if the slave reacts to its own address.
    expect_selected(select(bench, own)?).or_inconclusive()
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
