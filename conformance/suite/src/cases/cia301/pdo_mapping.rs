//! PDO mapping (1A00h).

use crate::bench::Bench;
use crate::bench::objects::{TPDO_FIRST_ENTRY, TPDO_MAPPED};
use crate::bench::pdo::{Pdo, TPDO};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop};
use canvass_analyzer::wire::sdo::AbortCode;

/// The mapping of a valid PDO can't be changed, and keeps its value.
///
/// CiA 301 prescribes the order in which a PDO is remapped; the device decides which out-of-order step it refuses.
#[case(id = "301/pdo/mapping/valid", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Should,
       needs = [Tpdo, DynamicMapping], catches = [MappingChangeWhileValid], cct = "3.24")]
fn valid(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(TPDO_MAPPED)?;
    let attempt = bench.download(TPDO_MAPPED, &[0])?;
    bench.check(attempt.refused(Situation::MappingInUseChanged))?;
    bench.expect_unchanged(TPDO_MAPPED, &before)
}

/// The device refuses a mapping of more than 64 bits with abort 0602 0000h or 0604 0042h. The case tries the mappings
/// of the first four TPDOs.
#[case(id = "301/pdo/mapping/too-long", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MappingTooLongAccepted], cct = "3.26",
       answers = [MappingEntryTooLong, MappingRefused])]
fn too_long(bench: &mut Bench<'_>) -> Judged {
    let mut entry = bench.read(TPDO_FIRST_ENTRY)?;
    // A mapping may allow few entries: an object with more bits fills it sooner.
    let widest = bench.tpdo_objects().into_iter().max_by_key(|mapped| mapped.bits);
    if let Some(widest) = widest.filter(|_| entry.first().is_some_and(|&bits| bits < 16)) {
        entry = widest.entry().to_le_bytes().to_vec();
    }
    let bits = u32::from(entry.first().copied().unwrap_or_default());
    let needed = (64_u32).checked_div(bits).and_then(|fits| u8::try_from(fits + 1).ok());
    let Some(needed) = needed.filter(|&needed| needed <= 64) else {
        let reason = Reason::new("1A00h:01 maps an object", "an entry with a length", format!("{bits} bits"));
        return Err(Stop::Inconclusive(reason));
    };
    map_too_much(bench, TPDO, &entry, needed)?;
    bench.each(2..=4_u16, |bench, number| {
        let other = TPDO.numbered(number);
        // An object that can't be mapped in another PDO says nothing about the limit.
        if !bench.can_write(other.entry(1))? {
            return Ok(());
        }
        match map_too_much(bench, other, &entry, needed) {
            Err(Stop::NotApplicable(_) | Stop::Inconclusive(_)) => Ok(()),
            judged => judged,
        }
    })
}

/// Maps the same object `needed` times.
fn map_too_much(bench: &mut Bench<'_>, pdo: Pdo, entry: &[u8], needed: u8) -> Judged {
    bench.open_mapping(pdo)?;
    for sub in 1..=needed {
        let attempt = bench.download(pdo.entry(sub), entry)?;
        match attempt.abort() {
            None => {}
            Some(AbortCode::NO_SUB_INDEX) => {
                let reason =
                    Reason::new("the PDO can map this many objects", format!("{needed}"), format!("{}", sub - 1));
                return Err(Stop::NotApplicable(reason));
            }
            // Some devices check the sum with every entry.
            Some(_) if sub == needed => return bench.check(attempt.refused(Situation::MappingEntryTooLong)),
            Some(_) => attempt.expect_confirmation().or_inconclusive()?,
        }
    }
    let attempt = bench.download(pdo.entry(0), &[needed])?;
    bench.check(attempt.refused(Situation::MappingRefused))
}

/// An object that is not PDO-mappable can't be mapped: the device refuses its entry with abort 0602 0000h or 0604
/// 0041h, or refuses to enable the mapping with abort 0602 0000h or 0604 0042h.
#[case(id = "301/pdo/mapping/unmappable", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [UnmappableObjectMapped], cct = "3.29",
       answers = [MappingRefused])]
fn unmappable(bench: &mut Bench<'_>) -> Judged {
    // The device type has 32 bits.
    refused(bench, TPDO, 0x1000_0020, Situation::Unmappable)
}

/// Writes an entry into an open mapping and requires a refusal as in `situation`. Some devices check entries only when
/// the mapping is switched on; then that write must be refused.
pub(super) fn refused(bench: &mut Bench<'_>, pdo: Pdo, entry: u32, situation: Situation) -> Judged {
    bench.open_mapping(pdo)?;
    let attempt = bench.download(pdo.entry(1), &entry.to_le_bytes())?;
    if attempt.abort().is_some() {
        return bench.check(attempt.refused(situation));
    }
    let mut attempt = bench.download(pdo.entry(0), &[1])?;
    attempt.what = format!("mapping of {entry:08X}h");
    bench.check(attempt.refused(Situation::MappingRefused))
}
