//! What becomes of a PDO whose new mapping was refused, and entries that are not quite right (1600h, 1A00h).

use crate::bench::Bench;
use crate::bench::pdo::{Mapped, TPDO};
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::Outcome;
use canvass_traces::Duration;

/// Codes for an entry with a length that can't be.
const LENGTH: [AbortCode; 2] = [AbortCode::NOT_MAPPABLE, AbortCode::PDO_LENGTH];

/// An object of TPDO 1 whose length is known: the first that is mapped.
fn first_mapped(bench: &mut Bench<'_>) -> Result<Mapped, Stop> {
    let mapping = bench.mapping(TPDO)?;
    mapping
        .into_iter()
        .find(|mapped| mapped.at.index.0 >= 0x20)
        .ok_or_else(|| Stop::NotApplicable(Reason::new("TPDO 1 maps an object as delivered", "one", "none")))
}

/// Maps one entry and switches the mapping on; what the device answers to the first message that it refuses.
fn try_entry(bench: &mut Bench<'_>, entry: u32) -> Result<Outcome, Stop> {
    bench.open_mapping(TPDO)?;
    let attempt = bench.download(TPDO.entry(1), &entry.to_le_bytes())?;
    if attempt.outcome != Outcome::Downloaded {
        return Ok(attempt.outcome);
    }
    Ok(bench.download(TPDO.entry(0), &[1])?.outcome)
}

/// An entry that takes more bits than its object has is refused with abort 0604 0041h or 0604 0042h. Whether one with
/// fewer bits is accepted is noted: CiA 301 does not say.
#[case(id = "301/pdo/mapping/other-length", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Should,
       needs = [EventTimer, DynamicMapping], catches = [MappingLengthUnchecked])]
fn other_length(bench: &mut Bench<'_>) -> Judged {
    let first = first_mapped(bench)?;
    let shorter = Mapped { bits: first.bits / 2, ..first };
    if shorter.bits >= 8 {
        let outcome = try_entry(bench, shorter.entry())?;
        bench.note(format!("{} mapped with {} of its {} bits: {outcome}", first.at, shorter.bits, first.bits));
    }
    let longer = Mapped { bits: first.bits.saturating_add(8).min(64), ..first };
    if longer.bits == first.bits {
        let reason = Reason::new("a mapped object can be mapped longer than it is", "fewer than 64 bits", "64 bits");
        return Err(Stop::NotApplicable(reason));
    }
    let outcome = try_entry(bench, longer.entry())?;
    let refused = matches!(&outcome, Outcome::Aborted(abort)
        if LENGTH.contains(&abort.code) || matches!(abort.code, AbortCode::INVALID_VALUE | AbortCode::GENERAL));
    bench.check(demand(refused, || {
        let duty = format!("{} can't be mapped with {} bits: it has {}", first.at, longer.bits, first.bits);
        Reason::new(duty, "abort 0604 0041h or 0604 0042h", outcome.to_string())
    }))
}

/// Sub-index 0 can't count an entry that is 0: abort 0602 0000h, 0604 0041h or 0609 0030h.
#[case(id = "301/pdo/mapping/empty-entry", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Should,
       needs = [EventTimer, DynamicMapping], catches = [EmptyEntryMapped])]
fn empty_entry(bench: &mut Bench<'_>) -> Judged {
    bench.open_mapping(TPDO)?;
    bench.write(TPDO.entry(1), &[0; 4])?;
    let mut attempt = bench.download(TPDO.entry(0), &[1])?;
    attempt.what = "switching on of a mapping with an empty entry".to_owned();
    let strict = [AbortCode::NO_OBJECT, AbortCode::NOT_MAPPABLE, AbortCode::INVALID_VALUE];
    bench.check(attempt.refused_with(&strict, &[AbortCode::PDO_LENGTH, AbortCode::GENERAL]))
}

/// A device whose description gives it a granularity of whole bytes refuses to map single bits of an object.
#[case(id = "301/pdo/mapping/granularity", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Should,
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
    for bits in [1, 4, first.bits.saturating_sub(1)] {
        let outcome = try_entry(bench, Mapped { bits, ..first }.entry())?;
        demand(matches!(outcome, Outcome::Aborted(_)), || {
            let duty = format!("{bits} bits of {} are not mapped", first.at);
            Reason::new(duty, "abort 0604 0041h", outcome.to_string())
        })?;
    }
    Ok(())
}

/// After a new mapping was refused, whatever the step, the old one can be written again and the PDO is sent as before.
#[case(id = "301/pdo/mapping/recovery", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [EventTimer, DynamicMapping], catches = [MappingFailureWedges])]
fn recovery(bench: &mut Bench<'_>) -> Judged {
    let before = bench.mapping(TPDO)?;
    let cob_id = bench.pdo_cob_id(TPDO)?;
    if before.is_empty() {
        return Err(Stop::NotApplicable(Reason::new("TPDO 1 maps an object as delivered", "one", "none")));
    }
    for (step, entry, count) in [("the entry", 0xFFFF_0020_u32, 1_u8), ("the number of entries", before[0].entry(), 65)]
    {
        bench.open_mapping(TPDO)?;
        let written = bench.download(TPDO.entry(1), &entry.to_le_bytes())?;
        // Some check an entry only when the mapping is switched on.
        let refused = match written.outcome {
            Outcome::Downloaded => bench.download(TPDO.entry(0), &[count])?.outcome,
            refused => refused,
        };
        demand(refused != Outcome::Downloaded, || {
            Reason::new(format!("{step} is refused"), "an abort", refused.to_string())
        })
        .or_inconclusive()?;
        bench.set_mapping(TPDO, &before).map_err(as_failure)?;
        bench.pdo_on(TPDO, cob_id).map_err(as_failure)?;
        sent_as_before(bench, step)?;
    }
    Ok(())
}

/// That the old mapping can't be written again is what the case is about.
fn as_failure(stop: Stop) -> Stop {
    match stop {
        Stop::Inconclusive(reason) => Stop::Breach(Box::new(reason.into())),
        other => other,
    }
}

fn sent_as_before(bench: &mut Bench<'_>, step: &str) -> Judged {
    let bits: u32 = bench.mapping(TPDO)?.iter().map(|mapped| u32::from(mapped.bits)).sum();
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    bench.set_pdo(TPDO, &[(2, &[255]), (5, &50_u16.to_le_bytes())])?;
    bench.command(Command::START)?;
    let heard = bench.frames_of(can_id, Duration::from_millis(300))?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    let length = bits.div_ceil(8) as usize;
    bench.check(demand(heard.iter().any(|record| record.data().len() >= length), || {
        let duty = format!("after {step} was refused and the old mapping written again, TPDO 1 is sent");
        Reason::new(duty, format!("{length} bytes every 50 ms"), format!("{} TPDOs in 300 ms", heard.len()))
    }))
}
