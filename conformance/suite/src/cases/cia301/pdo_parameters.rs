//! The communication parameters of all PDOs in the description (1400h, 1800h).

use crate::bench::Bench;
use crate::bench::pdo::{Pdo, RPDO, TPDO};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::CobId;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::observation::Observation;
use canvass_traces::{CanId, Duration, Frame};

/// A CAN-ID that no predefined object has and CiA 301 does not restrict.
const FREE: u32 = 0x6A0;

/// The first four PDOs of either direction that the device has, with the bases of their predefined CAN-IDs.
fn predefined(bench: &mut Bench<'_>) -> Result<Vec<(Pdo, u32)>, Stop> {
    let mut found = Vec::new();
    for (first, base) in [(TPDO, 0x180), (RPDO, 0x200)] {
        for number in 1..=4_u16 {
            let pdo = first.numbered(number);
            if bench.has(pdo.parameter(1))? {
                found.push((pdo, base + u32::from(number - 1) * 0x100));
            }
        }
    }
    if found.is_empty() {
        return Err(Stop::NotApplicable(Reason::new(
            "the device has PDOs",
            "1400h or 1800h, or one after them",
            "none",
        )));
    }
    Ok(found)
}

/// The breach of a wrong number of TPDOs: fewer than `least`, or more than `most`.
fn counted(duty: impl Into<String>, least: u64, most: Option<u64>, found: u64) -> Breach {
    let expected = Allowed::Count { least, most };
    Breach::new(TPDO.subject(), duty.into()).expected(expected).found(Observation::Count(found))
}

/// Sub-index 0 of a PDO communication parameter holds its highest sub-index, 2 to 6, and can't be written.
#[case(id = "301/pdo/parameter-count", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       catches = [SdoReadOnlyWritable, SdoReadOnlyWrongCode], cct = "3.1")]
fn parameter_count(bench: &mut Bench<'_>) -> Judged {
    let pdos = predefined(bench)?;
    bench.each(pdos, |bench, (pdo, _)| {
        let value = bench.upload(pdo.parameter(0))?.value()?;
        bench.check(demand(matches!(value.as_slice(), [2..=6]), || {
            let breach = Breach::new(pdo.parameter(0), "sub-index 0 holds the highest sub-index");
            breach.expected("one byte, 2 to 6").found(Observation::Value(value.clone()))
        }))?;
        let attempt = bench.download(pdo.parameter(0), &value)?;
        bench.check(attempt.refused(Situation::ReadOnly))
    })
}

/// The first four RPDOs and the first four TPDOs have their predefined CAN-IDs as delivered, or are switched off.
#[case(id = "301/pdo/cob-id/predefined", clause = "CiA 301 7.3.3", confidence = Cited, level = Must,
       catches = [PdoIdNotPredefined], cct = "3.1")]
fn cob_id_predefined(bench: &mut Bench<'_>) -> Judged {
    let node = u32::from(bench.node().raw());
    let pdos = predefined(bench)?;
    bench.each(pdos, |bench, (pdo, base)| {
        let cob_id = bench.pdo_cob_id(pdo)?;
        let described = bench.target().description.as_ref().and_then(|description| {
            let entry = description.dictionary.entry(pdo.parameter(1)).ok()?;
            u32::try_from(entry.start_value(bench.node())?.as_number()?).ok()
        });
        let is_right = !cob_id.is_valid() || cob_id.can_id() == base + node || described == Some(cob_id.0);
        bench.check(demand(is_right, || {
            let breach = Breach::new(pdo.parameter(1), "the COB-ID of a PDO is predefined, or the PDO is switched off");
            let breach = breach.expected(format!("{:03X}h, or bit 31", base + node));
            breach.found(Observation::Value(cob_id.0.to_le_bytes().to_vec()))
        }))
    })
}

/// A TPDO whose CAN-ID is changed while it is switched off is sent with the new CAN-ID, and no longer with the old one.
/// After reset communication it is sent with the CAN-ID that 1800h:01 then holds.
#[case(id = "301/pdo/cob-id/moved", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer, DynamicMapping], catches = [TpdoKeepsCanId, TpdoIdOutlivesReset])]
fn cob_id_moved(bench: &mut Bench<'_>) -> Judged {
    bench.set_pdo(TPDO, &[(2, &[255]), (3, &[0, 0]), (5, &100_u16.to_le_bytes())])?;
    let own = bench.pdo_off(TPDO)?;
    let moved = CobId(own.0 & !0x7FF | FREE | CobId::INVALID);
    move_to(bench, TPDO, moved)?;
    bench.pdo_on(TPDO, moved)?;
    reads_back(bench, TPDO, moved)?;
    let [new, old] = sent_with(bench, [FREE, own.can_id()])?;
    bench.check(demand(new > 0, || {
        counted(format!("TPDO 1 is sent with its new CAN-ID {FREE:03X}h every 100 ms, in 500 ms"), 1, None, new)
    }))?;
    bench.check(demand(old == 0, || counted("TPDO 1 is no longer sent with its old CAN-ID", 0, Some(0), old)))?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    let now = bench.pdo_cob_id(TPDO)?;
    if now.can_id() == FREE {
        return Ok(());
    }
    bench.set_event_timer(TPDO, 100)?;
    let [moved] = sent_with(bench, [FREE])?;
    bench.check(demand(moved == 0, || {
        let duty = format!("after reset communication TPDO 1 is sent with {:03X}h, as 1800h:01 reads", now.can_id());
        counted(format!("{duty}, and not with {FREE:03X}h"), 0, Some(0), moved)
    }))
}

/// Number of frames with each of these CAN-IDs in the first 500 ms of operational.
fn sent_with<const N: usize>(bench: &mut Bench<'_>, can_ids: [u32; N]) -> Result<[u64; N], Stop> {
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let mut counts = [0; N];
    bench.wait_for(Duration::from_millis(500), |record| {
        let cob_id = record.frame.cob_id().map(u32::from);
        for (count, can_id) in counts.iter_mut().zip(can_ids) {
            *count += u64::from(cob_id == Some(can_id & 0x7FF));
        }
        None::<()>
    })?;
    Ok(counts)
}

/// Requires that the COB-ID of a PDO that was switched on returns the written value when it is read.
pub(super) fn reads_back(bench: &mut Bench<'_>, pdo: Pdo, written: CobId) -> Judged {
    let right = Observation::Value((written.0 & !CobId::INVALID).to_le_bytes().to_vec());
    let found = Observation::Value(bench.read(pdo.parameter(1))?);
    bench.check(demand(found == right, || {
        Breach::new(pdo.parameter(1), "a COB-ID reads back as written").expected(right).found(found)
    }))
}

/// Sets another CAN-ID of a PDO that is off; not applicable if the device can only switch its PDOs on and off.
pub(super) fn move_to(bench: &mut Bench<'_>, pdo: Pdo, moved: CobId) -> Judged {
    let attempt = bench.download(pdo.parameter(1), &moved.0.to_le_bytes())?;
    if let Some(code @ (AbortCode::INVALID_VALUE | AbortCode::GENERAL)) = attempt.abort() {
        let actual = format!("abort {code}: it can only be switched on and off");
        return Err(Stop::NotApplicable(Reason::new("the CAN-ID of the PDO can be changed", "confirmation", actual)));
    }
    attempt.expect_confirmation()?;
    Ok(())
}

/// The case only records whether the device confirms a write of the COB-ID that a valid PDO already has. CiA 301
/// forbids changes of its bits, and such a write changes none.
#[case(id = "301/pdo/cob-id/same", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Open,
       needs = [Tpdo, DynamicMapping], catches = [SameCobIdRefused])]
fn cob_id_same(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read(TPDO.parameter(1))?;
    let attempt = bench.download(TPDO.parameter(1), &own)?;
    bench.check(attempt.expect_confirmation())?;
    bench.expect_unchanged(TPDO.parameter(1), &own)
}

/// An 11-bit CAN-ID is 7FFh at most: a COB-ID with a higher CAN-ID is refused with abort 0609 0030h.
#[case(id = "301/pdo/cob-id/too-high", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Should,
       needs = [Tpdo, DynamicMapping], catches = [CanIdTooHighAccepted])]
fn cob_id_too_high(bench: &mut Bench<'_>) -> Judged {
    let own = bench.pdo_off(TPDO)?;
    let wrong = own.0 & 0x4000_0000 | 0x0000_0812;
    let attempt = bench.download(TPDO.parameter(1), &wrong.to_le_bytes())?;
    bench.check(attempt.refused(Situation::InvalidValue))
}

/// A device that supports only 11-bit CAN-IDs refuses bit 29 of a COB-ID with abort 0609 0030h. A device that accepts
/// bit 29 sends 29-bit frames.
#[case(id = "301/pdo/cob-id/extended", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer, DynamicMapping], catches = [ExtendedBitAccepted])]
fn cob_id_extended(bench: &mut Bench<'_>) -> Judged {
    bench.set_pdo(TPDO, &[(2, &[255]), (3, &[0, 0]), (5, &100_u16.to_le_bytes())])?;
    let own = bench.pdo_off(TPDO)?;
    let extended = own.0 & 0x4000_0000 | 1 << 29 | 0x0012_3456;
    let attempt = bench.download(TPDO.parameter(1), &extended.to_le_bytes())?;
    if attempt.abort().is_some() {
        return bench.check(attempt.refused(Situation::InvalidValue));
    }
    bench.command(Command::START)?;
    let sent = bench.wait_for(Duration::from_millis(500), |record| {
        let id = record.frame.id();
        (id.is_extended() && id.raw() == 0x0012_3456).then_some(())
    })?;
    bench.check(demand(sent.is_some(), || {
        Breach::new(TPDO.subject(), "a device that accepts a 29-bit COB-ID uses it")
            .expected("TPDOs with 00123456h, or abort 0609 0030h")
            .found(Observation::Silence)
            .told("confirmation, but no such frame")
    }))
}

/// A device that does not support remote frames refuses to clear bit 30 of the COB-ID of a TPDO with abort 0609 0030h.
#[case(id = "301/pdo/cob-id/remote", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Should,
       needs = [EventTimer, DynamicMapping], catches = [RtrBitClearable])]
fn cob_id_remote(bench: &mut Bench<'_>) -> Judged {
    bench.set_pdo(TPDO, &[(2, &[255]), (5, &0_u16.to_le_bytes())])?;
    let own = bench.pdo_off(TPDO)?;
    let with_remote = own.0 & !(CobId::NO_RTR | CobId::INVALID);
    let attempt = bench.download(TPDO.parameter(1), &with_remote.to_le_bytes())?;
    if attempt.abort().is_some() {
        return bench.check(attempt.refused(Situation::InvalidValue));
    }
    bench.command(Command::START)?;
    bench.listen(Duration::from_millis(200))?;
    let can_id = own.can_id() & 0x7FF;
    if let Some(request) = Frame::remote(CanId::standard_masked(can_id), 8) {
        bench.send(&request)?;
    }
    let answers = bench.frames_of((can_id & 0x7FF) as u16, bench.timing().silence)?;
    bench.check(demand(answers.iter().any(|record| !record.frame.is_remote()), || {
        Breach::new(TPDO.subject(), "a device that accepts a COB-ID without bit 30 answers remote frames")
            .expected("a TPDO, or abort 0609 0030h")
            .found(Observation::Silence)
            .told("confirmation, but no answer")
    }))
}

/// The transmission types 252 and 253, which need remote frames, are refused with abort 0609 0030h for a PDO without
/// remote frames.
///
/// A device that supports remote frames may accept them, because bit 30 can still be cleared before the PDO becomes
/// valid.
#[case(id = "301/pdo/transmission-type/remote", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Should,
       needs = [Tpdo, DynamicMapping], catches = [RtrTypeWithoutRtrAccepted])]
fn remote_type(bench: &mut Bench<'_>) -> Judged {
    let own = bench.pdo_off(TPDO)?;
    let without = own.0 | CobId::NO_RTR | CobId::INVALID;
    bench.write(TPDO.parameter(1), &without.to_le_bytes())?;
    let with = own.0 & !(CobId::NO_RTR | CobId::INVALID);
    let knows_remote = bench.download(TPDO.parameter(1), &with.to_le_bytes())?.abort().is_none();
    bench.write(TPDO.parameter(1), &without.to_le_bytes())?;
    bench.each([252_u8, 253], |bench, transmission_type| {
        let attempt = bench.download(TPDO.parameter(2), &[transmission_type])?;
        let may_follow = knows_remote && attempt.abort().is_none();
        if may_follow { Ok(()) } else { bench.check(attempt.refused(Situation::TransmissionType)) }
    })
}

/// The inhibit time of a valid PDO does not change: the device refuses the write.
///
/// V4.0 of CiA 301 introduced this rule together with the event timer.
#[case(id = "301/pdo/inhibit-time/valid", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer], catches = [InhibitTimeChangeWhileValid],
       answers = [ValidPdoChanged])]
fn inhibit_time_valid(bench: &mut Bench<'_>) -> Judged {
    while_valid(bench, 3, 500, 600)
}

/// The SYNC start value of a valid PDO does not change: the device refuses the write.
#[case(id = "301/pdo/sync-start/valid", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer], catches = [SyncStartValueChangeWhileValid],
       answers = [ValidPdoChanged])]
fn sync_start_valid(bench: &mut Bench<'_>) -> Judged {
    while_valid(bench, 6, 3, 4)
}

/// Writes a new value of the parameter while the PDO is valid.
fn while_valid(bench: &mut Bench<'_>, sub: u8, usual: u16, otherwise: u16) -> Judged {
    let multiplexer = TPDO.parameter(sub);
    if !bench.can_write(multiplexer)? {
        let reason = Reason::new("the parameter can be written", multiplexer.to_string(), "absent or read-only");
        return Err(Stop::NotApplicable(reason));
    }
    let before = bench.read(multiplexer)?;
    let bytes = |number: u16| number.to_le_bytes().into_iter().take(before.len()).collect::<Vec<u8>>();
    let other = if bytes(usual) == before { bytes(otherwise) } else { bytes(usual) };
    let attempt = bench.download(multiplexer, &other)?;
    bench.check(attempt.refused(Situation::ValidPdoChanged))?;
    bench.expect_unchanged(multiplexer, &before)
}

/// Sub-index 4 of a communication parameter is reserved: reading and writing it are refused with abort 0609 0011h.
#[case(id = "301/pdo/reserved-entry", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       catches = [SdoRefusalAlternates, SdoWrongCodeForNoSubIndex, SdoUnknownAbortCode])]
fn reserved_entry(bench: &mut Bench<'_>) -> Judged {
    let pdos = predefined(bench)?;
    bench.each(pdos, |bench, (pdo, _)| {
        let answer = bench.upload(pdo.parameter(4))?;
        bench.check(answer.refused(Situation::ReservedEntry))?;
        let answer = bench.download(pdo.parameter(4), &[0])?;
        bench.check(answer.refused(Situation::ReservedEntry))
    })
}

/// The case only records whether a PDO without mapped objects can be made valid and then sends empty frames.
#[case(id = "301/pdo/empty", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Open,
       needs = [EventTimer, DynamicMapping], catches = [EmptyPdoValidated])]
fn empty(bench: &mut Bench<'_>) -> Judged {
    bench.set_pdo(TPDO, &[(2, &[255]), (5, &100_u16.to_le_bytes())])?;
    let own = bench.open_mapping(TPDO)?;
    let attempt = bench.download(TPDO.parameter(1), &(own.0 & !CobId::INVALID).to_le_bytes())?;
    if attempt.abort().is_some() {
        return Ok(());
    }
    bench.command(Command::START)?;
    let sent = bench.frames_of((own.can_id() & 0x7FF) as u16, Duration::from_millis(500))?;
    bench.check(demand(sent.is_empty(), || {
        counted("a PDO without mapped objects is not sent, in 500 ms", 0, Some(0), sent.len() as u64)
    }))
}
