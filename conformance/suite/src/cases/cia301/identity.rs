//! Identity objects of the device (1000h, 1001h, 1008h to 100Ah, 1018h).

use crate::bench::Bench;
use crate::bench::sdo::{DEVICE_TYPE, number};
use crate::case;
use crate::verdict::{Breach, Judged, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;

const fn identity(sub: u8) -> Multiplexer {
    Multiplexer::new(object::IDENTITY, sub)
}

/// The vendor-ID in 1018h:01 is the number that CiA assigned to the manufacturer: it is not 0, and it equals the
/// vendor-ID of the description.
#[case(id = "301/identity/vendor-id", clause = "CiA 301 7.5.2.21", confidence = Cited, level = Must,
       catches = [VendorIdZero, EdsVendorNumberDiffers])]
fn vendor_id(bench: &mut Bench<'_>) -> Judged {
    let value = bench.upload(identity(1))?.value()?;
    bench.check(demand(number(&value) != 0, || {
        let breach = Breach::new(identity(1), "1018h:01 holds the vendor-ID");
        breach.expected("a number other than 0").found(Observation::Value(value.clone()))
    }))?;
    as_described(bench, identity(1), &value)
}

/// Product code and revision number, if 1018h has them, equal the values of the description. The case only records a
/// value of 0, which is reserved, in product code, revision number or serial number.
#[case(id = "301/identity/product", clause = "CiA 301 7.5.2.21", confidence = Cited, level = Must,
       needs = [Description], catches = [IdentityRevisionMissing])]
fn product(bench: &mut Bench<'_>) -> Judged {
    bench.each([2, 3, 4].map(identity), |bench, multiplexer| {
        if bench.described(multiplexer) != Some(true) {
            return Ok(());
        }
        let value = bench.upload(multiplexer)?.value()?;
        bench.check(demand(number(&value) != 0, || {
            // 0 is reserved here, but the standard does not call it invalid as it does for the vendor-ID.
            let breach = Breach::new(multiplexer, "0 is reserved in the identity of a device").open();
            breach.expected("a number other than 0").found(Observation::Value(value.clone()))
        }))?;
        if multiplexer == identity(4) { Ok(()) } else { as_described(bench, multiplexer, &value) }
    })
}

/// A device with LSS has all four parts of its LSS address: 1018h:01 to 1018h:04. CiA 301 requires only the first of
/// them.
#[case(id = "301/identity/lss-address", clause = "CiA 301 7.5.2.21", confidence = Cited, level = Open,
       needs = [Lss], catches = [IdentityRevisionMissing])]
fn lss_address(bench: &mut Bench<'_>) -> Judged {
    bench.expect_value(identity(0), &[4], "1018h:00 counts four entries")?;
    bench.each(1..=4, |bench, sub| Ok(bench.upload(identity(sub))?.value().map(|_| ())?))
}

/// The device type 1000h contains the device profile and equals the device type of the description. With profile 0 (no
/// profile) its additional information is 0 or FFFFh.
#[case(id = "301/identity/device-type", clause = "CiA 301 7.5.2.1", confidence = Cited, level = Must,
       needs = [Description], catches = [DeviceTypeProfileWrong, DeviceTypeTurnsWrong], cct = "2.1")]
fn device_type(bench: &mut Bench<'_>) -> Judged {
    let value = bench.upload(DEVICE_TYPE)?.value()?;
    let (profile, additional) = (number(&value) & 0xFFFF, number(&value) >> 16);
    let is_legal = value.len() == 4 && (profile != 0 || matches!(additional, 0 | 0xFFFF));
    bench.check(demand(is_legal, || {
        let breach =
            Breach::new(DEVICE_TYPE, "1000h is an UNSIGNED32, and without a profile its upper half is 0 or FFFFh");
        breach.expected("4 bytes in this form").found(Observation::Value(value.clone()))
    }))?;
    as_described(bench, DEVICE_TYPE, &value)
}

/// Every device has 1000h, 1001h and 1018h, the latter with at least the vendor-ID.
#[case(id = "301/identity/mandatory-objects", clause = "CiA 301 7.5.2.21", confidence = Cited, level = Must,
       catches = [ErrorRegisterMissing], cct = "1.0")]
fn mandatory_objects(bench: &mut Bench<'_>) -> Judged {
    let mandatory =
        [(DEVICE_TYPE, 4), (Multiplexer::new(object::ERROR_REGISTER, 0), 1), (identity(0), 1), (identity(1), 4)];
    bench.each(mandatory, |bench, (multiplexer, length)| {
        let value = bench.upload(multiplexer)?.value()?;
        bench.check(demand(value.len() == length, || {
            let breach = Breach::new(multiplexer, "a mandatory object has its standard length");
            let plural = if length == 1 { "" } else { "s" };
            breach.expected(format!("{length} byte{plural}")).found(Observation::Value(value))
        }))
    })
}

/// Device name, hardware version and software version are of type VISIBLE_STRING: each byte is 00h or 20h to 7Eh.
#[case(id = "301/identity/names", clause = "CiA 301 7.1.6.3", confidence = Cited, level = Must,
       needs = [Name], catches = [DeviceNameWithGarbage])]
fn names(bench: &mut Bench<'_>) -> Judged {
    let names = bench.names()?;
    bench.each(names, |bench, (multiplexer, value)| {
        let strange = value.iter().position(|byte| !matches!(byte, 0x00 | 0x20..=0x7E));
        bench.check(demand(strange.is_none(), || {
            let told = format!("{} (byte {})", Bytes(&value), strange.unwrap_or_default());
            let breach = Breach::new(multiplexer, "a name or version has characters of VISIBLE_STRING only");
            breach.expected("bytes 00h and 20h to 7Eh").found(Observation::Value(value)).told(told)
        }))
    })
}

/// Requires the value in the description, if the description has one.
fn as_described(bench: &mut Bench<'_>, multiplexer: Multiplexer, value: &[u8]) -> Judged {
    let node = bench.node();
    let Some(description) = &bench.target().description else { return Ok(()) };
    let entry = description.dictionary.entry(multiplexer).ok();
    let default = entry.and_then(|entry| entry.start_value(node)?.as_number());
    // Of the general data in a description only the vendor number is reliable: the product number is often the ordering
    // number, and the revision that of the file. Many files leave all of them at 0.
    let vendor = description.device.vendor_number.filter(|number| *number != 0 && multiplexer == identity(1));
    let general = vendor.map(i128::from);
    bench.each([default, general].into_iter().flatten(), |bench, described| {
        bench.check(demand(described == i128::from(number(value)), || {
            Breach::new(multiplexer, "the identity of the device equals that of its description")
                .expected(format!("{described:08X}h"))
                .found(Observation::Value(value.to_vec()))
        }))
    })
}
