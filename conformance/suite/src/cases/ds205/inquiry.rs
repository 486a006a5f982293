//! Who the slave is: inquiries, and identify remote slave.

use super::{address, exchange, in_configuration, inquire, other, shown};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::lmt::{Bound, Part, Request, Response, Seven};
use canvass_bus::client::sdo::Bytes;

/// The serial number is fourteen decimal digits, two in each byte.
#[case(id = "205/inquiry/serial-number", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtSerialNotBcd])]
fn serial_number(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        let Seven(bytes) = inquire(bench, Part::SerialNumber)?;
        let is_decimal = bytes.iter().all(|byte| byte >> 4 <= 9 && byte & 0x0F <= 9);
        bench.check(demand(is_decimal, || {
            Reason::new("the serial number is BCD", "nibbles of 0 to 9", Bytes(&bytes).to_string())
        }))
    })
}

/// Manufacturer and product name are printable characters, filled up with 00h.
#[case(id = "205/inquiry/names", clause = "CiA DS-205", confidence = Unknown, level = Should,
       needs = [Alone, Lmt], catches = [LmtNameUnpadded])]
fn names(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        for part in [Part::ManufacturerName, Part::ProductName] {
            let Seven(bytes) = inquire(bench, part)?;
            let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
            let (name, padding) = bytes.split_at(end);
            let is_name = !name.is_empty() && name.iter().all(|byte| (0x20..=0x7E).contains(byte));
            demand(is_name && padding.iter().all(|&byte| byte == 0), || {
                let duty = format!("the {} is text", part.name());
                Reason::new(duty, "20h to 7Eh, then 00h", Bytes(&bytes).to_string())
            })?;
        }
        Ok(())
    })
}

/// Asks for slaves with these names and a serial number between `low` and `high`; the first answer.
fn identify(bench: &mut Bench<'_>, names: [Seven; 2], low: Seven, high: Seven) -> Result<Option<Response>, Stop> {
    let [manufacturer, product] = names;
    let mut answer = None;
    for (bound, value) in Bound::ALL.into_iter().zip([manufacturer, product, low, high]) {
        answer = answer.or(exchange(bench, Request::IdentifyRemote { bound, value })?);
    }
    Ok(answer)
}

/// A slave whose names are given and whose serial number lies between the two bounds answers 09h, in operation too.
#[case(id = "205/identify/own", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtIdentifySilent])]
fn identify_own(bench: &mut Bench<'_>) -> Judged {
    let [manufacturer, product, serial] = address(bench)?;
    for (low, high) in [(serial, serial), (Seven([0; 7]), Seven([0x99; 7]))] {
        let answer = identify(bench, [manufacturer, product], low, high)?;
        demand(answer == Some(Response::Identified), || {
            let duty = format!("the slave is within {} and {}", Bytes(&low.0), Bytes(&high.0));
            Reason::new(duty, "\"slave identified\"", shown(answer))
        })?;
    }
    Ok(())
}

/// A slave whose serial number is outside the bounds, or whose names are others, does not answer.
#[case(id = "205/identify/other", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], catches = [LmtIdentifyRangeIgnored])]
fn identify_other(bench: &mut Bench<'_>) -> Judged {
    let [manufacturer, product, serial] = address(bench)?;
    let beside = other(serial);
    for (names, low) in [([manufacturer, product], beside), ([manufacturer, other(product)], serial)] {
        let answer = identify(bench, names, low, low)?;
        demand(answer.is_none(), || {
            Reason::new("the address of another slave is not answered", "silence", shown(answer))
        })?;
    }
    Ok(())
}
