//! The state of a PDO after the refusal of a new mapping, and mapping entries with a wrong length or without an object
//! (1600h, 1A00h).

use crate::bench::Bench;
use crate::bench::pdo::{Mapped, TPDO};
use crate::bench::sdo::Attempt;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// The first mapped object of TPDO 1, with its length.
fn first_mapped(bench: &mut Bench<'_>) -> Result<Mapped, Stop> {
    let mapping = bench.mapping(TPDO)?;
    mapping
        .into_iter()
        .find(|mapped| mapped.at.index.0 >= 0x20)
        .ok_or_else(|| Stop::NotApplicable(Reason::new("TPDO 1 maps an object as delivered", "one", "none")))
}

/// Maps one entry and switches the mapping on; returns the answer to the first message that the device refuses.
fn try_entry(bench: &mut Bench<'_>, entry: u32) -> Result<Attempt, Stop> {
    let mut attempt = try_entries(bench, &[entry])?;
    attempt.what = format!("mapping of {entry:08X}h");
    Ok(attempt)
}

/// Maps several entries and switches the mapping on; returns the answer to the first message that the device refuses.
fn try_entries(bench: &mut Bench<'_>, entries: &[u32]) -> Result<Attempt, Stop> {
    bench.open_mapping(TPDO)?;
    let count = u8::try_from(entries.len()).unwrap_or(u8::MAX);
    for (sub, entry) in (1..=count).zip(entries) {
        let attempt = bench.download(TPDO.entry(sub), &entry.to_le_bytes())?;
        if attempt.outcome != Outcome::Downloaded {
            return Ok(attempt);
        }
    }
    bench.download(TPDO.entry(0), &[count])
}

/// A mapping entry with more bits than its object has is refused. The case notes whether an entry with fewer bits is
/// accepted.
///
/// CiA 301 names a wrong length as a reason to refuse an entry, but says only that a device *may* use the length to
/// verify the mapping.
#[case(id = "301/pdo/mapping/other-length", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Should,
       needs = [EventTimer, DynamicMapping], catches = [MappingLengthUnchecked])]
fn other_length(bench: &mut Bench<'_>) -> Judged {
    let first = first_mapped(bench)?;
    let shorter = Mapped { bits: first.bits / 2, ..first };
    if shorter.bits >= 8 {
        let outcome = try_entry(bench, shorter.entry())?.outcome;
        bench.note(format!("{} mapped with {} of its {} bits: {outcome}", first.at, shorter.bits, first.bits));
    }
    let longer = Mapped { bits: first.bits.saturating_add(8).min(64), ..first };
    if longer.bits == first.bits {
        let reason =
            Reason::new("a mapped object can be mapped with more bits than it has", "fewer than 64 bits", "64 bits");
        return Err(Stop::NotApplicable(reason));
    }
    let attempt = try_entry(bench, longer.entry())?;
    bench.check(attempt.refused(Situation::UnsupportedMapping))
}

/// A mapping entry of 0 can't be counted by sub-index 0, whether it is the only entry, the first or the second: the
/// device refuses the entry or the count.
#[case(id = "301/pdo/mapping/empty-entry", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Should,
       needs = [EventTimer, DynamicMapping], catches = [EmptyEntryMapped, LaterEmptyEntryMapped])]
fn empty_entry(bench: &mut Bench<'_>) -> Judged {
    let first = first_mapped(bench)?.entry();
    let has_second = bench.has(TPDO.entry(2))?;
    let mappings: [(&str, &[u32]); 3] =
        [("alone", &[0]), ("after a valid entry", &[first, 0]), ("before a valid entry", &[0, first])];
    bench.each(mappings.into_iter().take(if has_second { 3 } else { 1 }), |bench, (place, entries)| {
        let mut attempt = try_entries(bench, entries)?;
        attempt.what = format!("mapping of an empty entry {place}");
        bench.check(attempt.refused(Situation::UnsupportedMapping))
    })
}

/// A device whose description gives a granularity of whole bytes refuses to map single bits of an object.
#[case(id = "301/pdo/mapping/granularity", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Should,
       needs = [EventTimer, DynamicMapping, Description], catches = [MappingLengthUnchecked])]
fn granularity(bench: &mut Bench<'_>) -> Judged {
    let granularity = bench.target().description.as_ref().map_or(0, |description| description.device.granularity);
    if granularity < 8 {
        let actual = format!("Granularity={granularity}");
        let reason =
            Reason::new("the description says that only whole bytes are mapped", "Granularity=8 or more", actual);
        return Err(Stop::NotApplicable(reason));
    }
    let first = first_mapped(bench)?;
    bench.each([1, 4, first.bits.saturating_sub(1)], |bench, bits| {
        let attempt = try_entry(bench, Mapped { bits, ..first }.entry())?;
        bench.check(attempt.refused(Situation::UnsupportedMapping))
    })
}

/// After the device has refused a new mapping, in whichever step, the old mapping can be written again, and the PDO is
/// sent as before.
#[case(id = "301/pdo/mapping/recovery", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [EventTimer, DynamicMapping], catches = [MappingFailureWedges])]
fn recovery(bench: &mut Bench<'_>) -> Judged {
    let before = bench.mapping(TPDO)?;
    let cob_id = bench.pdo_cob_id(TPDO)?;
    let Some(first) = before.first().copied() else {
        return Err(Stop::NotApplicable(Reason::new("TPDO 1 maps an object as delivered", "one", "none")));
    };
    let steps = [("the entry", 0xFFFF_0020_u32, 1_u8), ("the number of entries", first.entry(), 65)];
    bench.each(steps, |bench, (step, entry, count)| {
        bench.open_mapping(TPDO)?;
        // Some devices check an entry only when the mapping is switched on.
        let mut attempt = bench.download(TPDO.entry(1), &entry.to_le_bytes())?;
        if attempt.outcome == Outcome::Downloaded {
            attempt = bench.download(TPDO.entry(0), &[count])?;
        }
        attempt.refused(Situation::UnsupportedMapping).or_inconclusive()?;
        bench.remap(TPDO, &before, cob_id)?;
        sent_as_before(bench, step)
    })
}

fn sent_as_before(bench: &mut Bench<'_>, step: &str) -> Judged {
    let bits: u32 = bench.mapping(TPDO)?.iter().map(|mapped| u32::from(mapped.bits)).sum();
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    bench.set_pdo(TPDO, &[(2, &[255]), (3, &[0, 0]), (5, &50_u16.to_le_bytes())])?;
    bench.command(Command::START)?;
    let heard = bench.frames_of(can_id, Duration::from_millis(300))?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    let length = bits.div_ceil(8) as usize;
    let sent = heard.iter().filter(|record| record.data().len() >= length).count();
    bench.check(demand(sent > 0, || {
        let duty = format!("after {step} was refused and the old mapping written again, TPDO 1 is sent every 50 ms");
        Breach::new(TPDO.subject(), duty)
            .expected(Allowed::Count { least: 1, most: None })
            .found(Observation::Count(sent as u64))
            .told(format!("{sent} TPDOs of {length} bytes in 300 ms"))
    }))
}
