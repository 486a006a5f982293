//! The COB-IDs of all services, bit by bit: a rule for an identifier applies to each of its bits (CiA 301, 7.5.2).

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::Observation;

/// Bit 30 of 1005h and 1012h: the device produces; bit 31 of 1012h: it consumes.
const PRODUCES: u32 = 1 << 30;
const CONSUMES: u32 = 1 << 31;
/// A CAN-ID that belongs to no predefined object and that CiA 301 does not restrict.
const FREE: u32 = 0x6A0;
/// CAN-IDs that CiA 301 does not restrict. Each of the eleven bits is 0 in some of them and 1 in others.
const PATTERNS: [u32; 6] = [0x2AA, 0x555, 0x333, 0x4CC, 0x38F, 0x470];

/// The COB-IDs that are writable according to the description, except those of the default SDO server 1200h: CiA 301
/// fixes them, and without them the device could not be reached any more.
fn writable(bench: &mut Bench<'_>) -> Result<Vec<Multiplexer>, Stop> {
    let is_cob_id = |at: Multiplexer| match at.index.0 {
        object::COB_ID_SYNC | object::COB_ID_TIME | object::COB_ID_EMCY => at.sub.0 == 0,
        object::EMERGENCY_CONSUMER => at.sub.0 > 0,
        0x1201..=0x127F => matches!(at.sub.0, 1 | 2),
        0x1400..=0x15FF | 0x1800..=0x19FF => at.sub.0 == 1,
        _ => false,
    };
    let entries = bench.target().description.iter().flat_map(|description| description.dictionary.entries());
    let found: Vec<Multiplexer> = entries
        .filter(|(at, entry)| is_cob_id(*at) && entry.access.is_writable() && entry.access.is_readable())
        .map(|(at, _)| at)
        .collect();
    if found.is_empty() {
        let reason = Reason::new("a COB-ID can be changed", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    }
    Ok(found)
}

/// The COB-ID with its service off: not valid, or neither produced nor consumed.
fn unused(at: Multiplexer, cob_id: u32) -> u32 {
    match at.index.0 {
        object::COB_ID_SYNC => cob_id & !PRODUCES,
        object::COB_ID_TIME => cob_id & !(PRODUCES | CONSUMES),
        _ => cob_id | CobId::INVALID,
    }
}

/// A COB-ID that is not in use accepts every CAN-ID that CiA 301 does not restrict, and reads back as written. A PDO
/// that is switched off can be switched on again with another CAN-ID.
///
/// For PDOs and further SDO channels, a device may support only switching them on and off.
#[case(id = "301/cob-id/patterns", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Description], catches = [CanIdsTakenForRestricted, TimeIdRefused, EmcyIdWrong, PdoIdNotPredefined, SyncIdWrong, TimeIdWrong,
                                           SdoMemoryLeak, SdoResponseLost])]
fn patterns(bench: &mut Bench<'_>) -> Judged {
    let objects = writable(bench)?;
    bench.each(objects, |bench, at| {
        let own = bench.read_number(at)?;
        let off = unused(at, own);
        // Another case judges whether a PDO can be switched off.
        if off != own {
            let attempt = bench.download(at, &off.to_le_bytes())?.under("to switch it off");
            match is_single(at) {
                true => attempt.refused(Situation::Confirmed)?,
                false if attempt.abort().is_some() => return Ok(()),
                false => {}
            }
        }
        let with = |can_id: u32| off & !0x7FF | can_id;
        let moved = bench.download(at, &with(FREE).to_le_bytes())?.under("with a CAN-ID that is not restricted");
        if is_single(at) {
            bench.check(moved.refused(Situation::Confirmed))?;
        }
        if moved.abort().is_none() {
            let node = u32::from(bench.node().raw());
            // A device may refuse the CAN-IDs that it uses itself.
            let patterns = PATTERNS.into_iter().filter(|pattern| pattern & 0x7F != node);
            bench.each(patterns, |bench, pattern| {
                takes(bench, at, with(pattern))?;
                if own != off {
                    for can_id in [pattern, FREE] {
                        takes(bench, at, own & !0x7FF | can_id)?;
                        takes(bench, at, with(can_id))?;
                    }
                }
                Ok(())
            })?;
        }
        bench.download(at, &off.to_le_bytes())?;
        bench.download(at, &own.to_le_bytes())?;
        Ok(())
    })
}

/// Whether the object contains nothing but a COB-ID. If such an object can't be changed, its description says const.
const fn is_single(at: Multiplexer) -> bool {
    matches!(at.index.0, object::COB_ID_TIME | object::COB_ID_EMCY)
}

/// Requires that the device accepts a COB-ID, and that a read returns it as it was written.
fn takes(bench: &mut Bench<'_>, at: Multiplexer, cob_id: u32) -> Judged {
    let value = &cob_id.to_le_bytes();
    bench.download(at, value)?.under("with a CAN-ID that is not restricted").refused(Situation::Confirmed)?;
    let found = bench.read(at)?;
    bench.check(demand(found == value, || {
        Breach::new(at, "a COB-ID reads back as written")
            .expected(Observation::Value(value.to_vec()))
            .found(Observation::Value(found))
    }))
}

/// Bits 0 to 28 of a COB-ID do not change while the COB-ID is valid, or while the device consumes or produces SYNC or
/// TIME with it: the device refuses each write that inverts one of these bits, and the COB-ID keeps its value.
#[case(id = "301/cob-id/each-bit-valid", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Description], catches = [CanIdLowBitsMovable, TimeIdChangeWhileValid, CobIdChangeWhileValid, EmcyIdChangeWhileValid, EmcyIdWrong,
                                           PdoIdNotPredefined, PdoRulesFirstOnly, TimeIdWrong, SdoResponseLost, SdoResponseSlow])]
fn each_bit_valid(bench: &mut Bench<'_>) -> Judged {
    let objects = writable(bench)?;
    bench.each(objects, |bench, at| {
        let own = bench.read(at)?;
        let number = crate::bench::sdo::number(&own);
        if unused(at, number) == number {
            return Ok(());
        }
        bench.each(0..=28, |bench, bit| {
            let attempt = bench.download(at, &(number ^ 1 << bit).to_le_bytes())?;
            attempt.under("while it is valid").refused(Situation::ValidCobIdChanged)?;
            bench.expect_unchanged(at, &own)
        })
    })
}

/// Bits 11 to 28 of a COB-ID are not part of an 11-bit CAN-ID: a value with one of these bits set and bit 29 cleared is
/// refused with abort 0609 0030h.
#[case(id = "301/cob-id/bits-beyond", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Should,
       needs = [Description], catches = [CobIdBitsUnchecked, CanIdTooHighAccepted, PdoRulesFirstOnly, SdoResponseLost])]
fn bits_beyond(bench: &mut Bench<'_>) -> Judged {
    let objects = writable(bench)?;
    bench.each(objects, |bench, at| {
        let own = bench.read_number(at)?;
        let off = unused(at, own);
        if off != own && bench.download(at, &off.to_le_bytes())?.abort().is_some() {
            return Ok(());
        }
        bench.each(11..=28, |bench, bit| {
            let attempt = bench.download(at, &(off | 1 << bit).to_le_bytes())?;
            // A device whose COB-IDs can only be switched on and off refuses this value with abort 0800 0000h.
            let only_switched = attempt.abort() == Some(AbortCode::GENERAL);
            if only_switched { Ok(()) } else { bench.check(attempt.refused(Situation::InvalidValue)) }
        })?;
        bench.download(at, &own.to_le_bytes())?;
        Ok(())
    })
}

/// A device that supports only 11-bit CAN-IDs refuses bit 29 of 1014h, 1028h and 1201h to 127Fh with abort 0609 0030h.
/// A device that accepts bit 29 also accepts a CAN-ID of 29 bits.
#[case(id = "301/cob-id/frame-bit", clause = "CiA 301 7.5.2.17", confidence = Cited, level = Must,
       needs = [Description], catches = [CobIdFrameBitTaken])]
fn frame_bit(bench: &mut Bench<'_>) -> Judged {
    const FRAME: u32 = 1 << 29;
    const LONG: u32 = 0x0012_3456;
    let mut objects = writable(bench)?;
    // PDOs have their own case; SYNC and TIME have other reserved bits.
    objects.retain(|at| matches!(at.index.0, object::COB_ID_EMCY | object::EMERGENCY_CONSUMER | 0x1201..=0x127F));
    bench.each(objects, |bench, at| {
        let own = bench.read_number(at)?;
        let off = unused(at, own);
        if off != own && bench.download(at, &off.to_le_bytes())?.abort().is_some() {
            return Ok(());
        }
        let attempt = bench.download(at, &(off & !0x7FF | FRAME | FREE).to_le_bytes())?.under("with bit 29");
        let only_switched = attempt.abort() == Some(AbortCode::GENERAL);
        if attempt.abort().is_some() {
            if !only_switched {
                bench.check(attempt.refused(Situation::InvalidValue))?;
            }
        } else {
            bench.expect_effect(at, &(off & !0x7FF | FRAME | FREE).to_le_bytes())?;
            let long = bench.download(at, &(off & !0x1FFF_FFFF | FRAME | LONG).to_le_bytes())?;
            bench.check(
                long.under("with a CAN-ID of 29 bits, after bit 29 was accepted").refused(Situation::Confirmed),
            )?;
        }
        bench.download(at, &off.to_le_bytes())?;
        bench.download(at, &own.to_le_bytes())?;
        Ok(())
    })
}
