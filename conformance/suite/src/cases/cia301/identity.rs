//! Identity: who the device says it is (1000h, 1001h, 1008h to 100Ah, 1018h).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, demand};
use canvass_analyzer::Multiplexer;
use canvass_bus::client::sdo::Bytes;

const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);

const fn identity(sub: u8) -> Multiplexer {
    Multiplexer::new(0x1018, sub)
}

/// The vendor-ID 1018h:01 is the one that CiA gave the manufacturer, so never 0, and that of the description.
#[case(id = "301/identity/vendor-id", clause = "CiA 301 7.5.2.21", confidence = Derived, level = Must,
       catches = [VendorIdZero])]
fn vendor_id(bench: &mut Bench<'_>) -> Judged {
    let vendor = crate::bench::sdo::number(&bench.upload(identity(1))?.value()?);
    demand(vendor != 0, || Reason::new("1018h:01 holds the vendor-ID", "a number other than 0", "0"))?;
    as_described(bench, identity(1), vendor)
}

/// Product code and revision number, where 1018h has them, are those of the description.
#[case(id = "301/identity/product", clause = "CiA 301 7.5.2.21", confidence = Derived, level = Should,
       needs = [Description], catches = [IdentityRevisionMissing])]
fn product(bench: &mut Bench<'_>) -> Judged {
    for multiplexer in [identity(2), identity(3)] {
        if bench.described(multiplexer) == Some(true) {
            let value = crate::bench::sdo::number(&bench.upload(multiplexer)?.value()?);
            as_described(bench, multiplexer, value)?;
        }
    }
    Ok(())
}

/// A device with LSS has all four parts of its LSS address: 1018h:01 to 1018h:04.
#[case(id = "301/identity/lss-address", clause = "CiA 301 7.5.2.21", confidence = Derived, level = Must,
       needs = [Lss], catches = [IdentityRevisionMissing])]
fn lss_address(bench: &mut Bench<'_>) -> Judged {
    let highest = bench.upload(identity(0))?.value()?;
    demand(highest == [4], || Reason::new("1018h:00 counts four entries", "04", Bytes(&highest).to_string()))?;
    for sub in 1..=4 {
        bench.upload(identity(sub))?.value()?;
    }
    Ok(())
}

/// The device type 1000h names the device profile and is that of the description.
#[case(id = "301/identity/device-type", clause = "CiA 301 7.5.2.1", confidence = Derived, level = Must,
       needs = [Description], catches = [DeviceTypeProfileWrong, DeviceTypeTurnsWrong], cct = "2.1")]
fn device_type(bench: &mut Bench<'_>) -> Judged {
    let value = bench.upload(DEVICE_TYPE)?.value()?;
    demand(value.len() == 4, || Reason::new("1000h is an UNSIGNED32", "4 bytes", Bytes(&value).to_string()))?;
    as_described(bench, DEVICE_TYPE, crate::bench::sdo::number(&value))
}

/// Every device has 1000h, 1001h and 1018h with at least the vendor-ID.
#[case(id = "301/identity/mandatory-objects", clause = "CiA 301 7.5", confidence = Known, level = Must,
       catches = [ErrorRegisterMissing], cct = "1.0")]
fn mandatory_objects(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, length) in
        [(DEVICE_TYPE, 4), (Multiplexer::new(0x1001, 0), 1), (identity(0), 1), (identity(1), 4)]
    {
        let value = bench.upload(multiplexer)?.value()?;
        demand(value.len() == length, || {
            let expected = format!("{length} byte{}", if length == 1 { "" } else { "s" });
            Reason::new(format!("{multiplexer} has its standard length"), expected, Bytes(&value).to_string())
        })?;
    }
    Ok(())
}

/// Device name, hardware version and software version are VISIBLE_STRINGs: printable characters and nothing after.
#[case(id = "301/identity/names", clause = "CiA 301 7.5.2.8", confidence = Derived, level = Should,
       needs = [Name], catches = [DeviceNameWithGarbage])]
fn names(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, value) in bench.names()? {
        // CiA 301 defines VISIBLE_STRING as 00h and 20h to 7Eh; a 00h in a value is padding that does not belong.
        let strange = value.iter().position(|byte| !(0x20..=0x7E).contains(byte));
        demand(strange.is_none(), || {
            let actual = format!("{} (byte {})", Bytes(&value), strange.unwrap_or_default());
            Reason::new(format!("{multiplexer} is printable"), "bytes 20h to 7Eh", actual)
        })?;
    }
    Ok(())
}

/// Demands the value that the description gives, where it gives one.
fn as_described(bench: &mut Bench<'_>, multiplexer: Multiplexer, value: u32) -> Judged {
    let node = bench.node();
    let described = bench.target().description.as_ref().and_then(|description| {
        let entry = description.dictionary.entry(multiplexer).ok()?;
        entry.start_value(node)?.as_number()
    });
    bench.check(demand(described.is_none_or(|described| described == i128::from(value)), || {
        let expected = format!("{:08X}h", described.unwrap_or_default());
        Reason::new(format!("{multiplexer} is as described"), expected, format!("{value:08X}h"))
    }))
}
