//! PDO mapping (1A00h).
//!
//! Stacks disagree on the abort code for a mapping that may not change now: CANopenNode sends 0601 0000h, lely-core
//! 0609 0030h. The standard fixes none, so all that fit the reason pass.

use crate::bench::Bench;
use crate::bench::objects::{TPDO_FIRST_ENTRY, TPDO_MAPPED};
use crate::bench::pdo::{Pdo, TPDO};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;

/// Codes for a mapping that may not be changed now.
const NOT_NOW: [AbortCode; 4] =
    [AbortCode::UNSUPPORTED_ACCESS, AbortCode::NOT_MAPPABLE, AbortCode::INVALID_VALUE, AbortCode::DEVICE_STATE];

/// Switches a PDO and its mapping off, so that entries can be written.
fn open_mapping(bench: &mut Bench<'_>, pdo: Pdo) -> Result<(), Stop> {
    bench.pdo_off(pdo)?;
    bench.write(Multiplexer::new(pdo.mapping, 0), &[0])
}

/// The mapping of a PDO that is valid can't be changed, and stays as it is.
#[case(id = "301/pdo/mapping/valid", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MappingChangeWhileValid], cct = "3.24")]
fn valid(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(TPDO_MAPPED)?;
    let attempt = bench.download(TPDO_MAPPED, &[0])?;
    bench.check(attempt.refused_with(&NOT_NOW, &[AbortCode::GENERAL]))?;
    bench.expect_unchanged(TPDO_MAPPED, &before)?;
    Ok(())
}

/// A mapping of more than 64 bits is refused with abort 0604 0042h: that of each of the first four TPDOs.
#[case(id = "301/pdo/mapping/too-long", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MappingTooLongAccepted], cct = "3.26")]
fn too_long(bench: &mut Bench<'_>) -> Judged {
    let entry = bench.read(TPDO_FIRST_ENTRY)?;
    let bits = u32::from(entry.first().copied().unwrap_or_default());
    let needed = (64_u32).checked_div(bits).and_then(|fits| u8::try_from(fits + 1).ok());
    let Some(needed) = needed.filter(|&needed| needed <= 64) else {
        let reason = Reason::new("1A00h:01 maps an object", "an entry with a length", format!("{bits} bits"));
        return Err(Stop::Inconclusive(reason));
    };
    map_too_much(bench, TPDO, &entry, needed)?;
    for number in 1..4 {
        let other = Pdo { communication: TPDO.communication + number, mapping: TPDO.mapping + number };
        // What can't be mapped in another one says nothing about the limit.
        if bench.can_write(Multiplexer::new(other.mapping, 1))? {
            match map_too_much(bench, other, &entry, needed) {
                Err(Stop::NotApplicable(_) | Stop::Inconclusive(_)) => {}
                judged => judged?,
            }
        }
    }
    Ok(())
}

/// Maps the same object so often.
fn map_too_much(bench: &mut Bench<'_>, pdo: Pdo, entry: &[u8], needed: u8) -> Judged {
    let mapped = Multiplexer::new(pdo.mapping, 0);
    open_mapping(bench, pdo)?;
    for sub in 1..=needed {
        let attempt = bench.download(Multiplexer::new(pdo.mapping, sub), entry)?;
        match attempt.abort() {
            None => {}
            // Some check the sum with every entry.
            Some(AbortCode::PDO_LENGTH) => return Ok(()),
            Some(AbortCode::NO_SUB_INDEX) => {
                let reason = Reason::new("so many objects can be mapped", format!("{needed}"), format!("{}", sub - 1));
                return Err(Stop::NotApplicable(reason));
            }
            Some(_) => attempt.expect_confirmation().or_inconclusive()?,
        }
    }
    let attempt = bench.download(mapped, &[needed])?;
    bench.check(attempt.refused(Situation::MappingRefused))
}

/// An object that is not for PDOs can't be mapped: abort 0604 0041h.
#[case(id = "301/pdo/mapping/unmappable", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [UnmappableObjectMapped], cct = "3.29")]
fn unmappable(bench: &mut Bench<'_>) -> Judged {
    open_mapping(bench, TPDO)?;
    // The device type, 32 bits.
    let attempt = bench.download(TPDO_FIRST_ENTRY, &0x1000_0020_u32.to_le_bytes())?;
    if attempt.abort().is_some() {
        return bench.check(attempt.refused(Situation::Unmappable));
    }
    // Some check the entries only when the mapping is switched on.
    let attempt = bench.download(TPDO_MAPPED, &[1])?;
    bench.check(attempt.refused(Situation::Unmappable))
}
