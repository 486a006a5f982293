//! The identity of the slave: inquiries, and identify remote slave.

use super::configuration::configure_own;
use super::dialogue::{address, breach, exchange, in_configuration, inquire, observed, other, shown, tell};
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::expect_dialogue;
use crate::verdict::{Judged, Stop, demand};
use canvass_analyzer::wire::lmt::{Bound, Lmt, Part, Request, Response, Seven};
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;

/// The serial number consists of fourteen decimal digits, two in each byte.
#[case(id = "205/inquiry/serial-number", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtSerialNotBcd])]
fn serial_number(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        let Seven(bytes) = inquire(bench, Part::SerialNumber)?;
        let is_decimal = bytes.iter().all(|byte| byte >> 4 <= 9 && byte & 0x0F <= 9);
        bench.check(demand(is_decimal, || {
            let breach = breach("the serial number is BCD").expected("nibbles of 0 to 9");
            breach.found(Observation::Value(bytes.to_vec()))
        }))
    })
}

/// Manufacturer name and product name consist of printable characters, padded with 00h.
#[case(id = "205/inquiry/names", clause = "CiA DS-205", confidence = Unknown, level = Should,
       needs = [Alone, Lmt], catches = [LmtNameUnpadded])]
fn names(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        bench.each([Part::ManufacturerName, Part::ProductName], |bench, part| {
            let Seven(bytes) = inquire(bench, part)?;
            let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
            let (name, padding) = bytes.split_at(end);
            let is_name = !name.is_empty() && name.iter().all(|byte| (0x20..=0x7E).contains(byte));
            bench.check(demand(is_name && padding.iter().all(|&byte| byte == 0), || {
                let breach = breach(format!("the {} is text", part.name())).expected("20h to 7Eh, then 00h");
                breach.found(Observation::Value(bytes.to_vec()))
            }))
        })
    })
}

/// Asks for slaves with these names and a serial number between `low` and `high`; returns the first answer. A slave
/// outside these bounds must not answer.
fn identify(
    bench: &mut Bench<'_>,
    names: [Seven; 2],
    low: Seven,
    high: Seven,
    within: bool,
) -> Result<Option<Response>, Stop> {
    let [manufacturer, product] = names;
    let mut answer = None;
    for (bound, value) in Bound::ALL.into_iter().zip([manufacturer, product, low, high]) {
        let request = Request::IdentifyRemote { bound, value };
        let may_answer = within && bound == Bound::SerialHigh;
        answer = answer.or(if may_answer { exchange(bench, request)? } else { tell(bench, request)? });
    }
    Ok(answer)
}

/// A slave answers 09h if the request contains its names and its serial number lies between the two bounds, also in
/// operation.
#[case(id = "205/identify/own", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtIdentifySilent])]
fn identify_own(bench: &mut Bench<'_>) -> Judged {
    let [manufacturer, product, serial] = address(bench)?;
    bench.each([(serial, serial), (Seven([0; 7]), Seven([0x99; 7]))], |bench, (low, high)| {
        let answer = identify(bench, [manufacturer, product], low, high, true)?;
        bench.check(demand(answer == Some(Response::Identified), || {
            let breach = breach(format!("the slave is within {} and {}", Bytes(&low.0), Bytes(&high.0)));
            breach.expected(observed(Some(Response::Identified))).found(observed(answer)).told(shown(answer))
        }))
    })
}

/// A slave with other names, or with a serial number outside the bounds, does not answer.
#[case(id = "205/identify/other", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtIdentifyRangeIgnored])]
fn identify_other(bench: &mut Bench<'_>) -> Judged {
    let [manufacturer, product, serial] = address(bench)?;
    let beside = other(serial);
    let others = [([manufacturer, product], beside), ([manufacturer, other(product)], serial)];
    bench.each(others, |bench, (names, low)| {
        let answer = identify(bench, names, low, low, false)?;
        bench.check(demand(answer.is_none(), || {
            let breach = breach("the address of another slave is not answered");
            breach.expected(Observation::Silence).found(observed(answer)).told(shown(answer))
        }))
    })
}

/// Every request is answered once, by a response of eight bytes with the unused bytes 0.
#[case(id = "205/form", clause = "CiA DS-205", confidence = Unknown, level = Should,
       needs = [Alone, Lmt], touches = [NodeId], catches = [LmtShortResponse])]
fn form(bench: &mut Bench<'_>) -> Judged {
    // A slave may send only every second response in a wrong form.
    for _ in 0..2 {
        in_configuration(bench, |bench| {
            for part in Part::ALL {
                exchange(bench, Request::Inquire { part })?;
            }
            configure_own(bench)
        })?;
    }
    let identified = identified_twice(bench);
    expect_dialogue::<Lmt>(bench)?;
    identified
}

fn identified_twice(bench: &mut Bench<'_>) -> Judged {
    let [manufacturer, product, serial] = address(bench)?;
    for _ in 0..2 {
        identify(bench, [manufacturer, product], serial, serial, true)?;
    }
    Ok(())
}
