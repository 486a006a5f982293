//! RPDOs: their effect, its time, and forbidden effects (CiA 301, 7.2.2.2, 7.5.2.35 and 7.5.2.36).
//!
//! RPDO 1 carries an object that SDO can read, so that its effect can be seen.

use super::emcy::{code_of, emergencies, errors_of, expect_no_error, observed, patience, shown};
use super::pdo_parameters::{move_to, reads_back};
use crate::bench::Bench;
use crate::bench::pdo::{Mapped, RPDO};
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::Observation;
use canvass_traces::{CanId, Duration, Frame, Record};
use std::ops::RangeInclusive;

/// RPDO 1 with one object mapped, and the data for sending it.
pub(super) struct Subject {
    pub mapped: Mapped,
    pub can_id: u16,
    pub before: Vec<u8>,
    pub other: Vec<u8>,
}

/// Maps one object in RPDO 1 and sets its transmission type.
pub(super) fn subject(bench: &mut Bench<'_>, transmission_type: u8) -> Result<Subject, Stop> {
    let objects = bench.rpdo_objects();
    let of_bits = |bits: RangeInclusive<u8>| objects.iter().copied().find(|mapped| bits.contains(&mapped.bits));
    // An object that fits into an expedited SDO is preferred: a case with it depends on no other kind of transfer.
    carrying(bench, of_bits(16..=32).or_else(|| of_bits(8..=64)), transmission_type)
}

fn carrying(bench: &mut Bench<'_>, mapped: Option<Mapped>, transmission_type: u8) -> Result<Subject, Stop> {
    let Some(mapped) = mapped else {
        let reason = Reason::new("an RPDO can carry an object that SDOs read", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    };
    bench.uses(mapped.at, "mapped into RPDO 1");
    let before = bench.read(mapped.at)?;
    bench.write(mapped.at, &before)?;
    bench.set_mapping(RPDO, &[mapped])?;
    // Both event-driven types have the same effect.
    let is_set = transmission_type >= 254 && bench.read_number(RPDO.parameter(2))? >= 254;
    let parameters: &[(u8, &[u8])] = if is_set { &[] } else { &[(2, &[transmission_type])] };
    bench.set_pdo(RPDO, parameters)?;
    let can_id = (bench.pdo_cob_id(RPDO)?.can_id() & 0x7FF) as u16;
    let other = bench.other_value(mapped.at, &before);
    Ok(Subject { mapped, can_id, before, other })
}

pub(super) fn operational(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction).map(|_| ())
}

fn send(bench: &mut Bench<'_>, subject: &Subject, data: &[u8]) -> Result<(), Stop> {
    bench.send_bytes(subject.can_id, data)?;
    bench.listen(bench.shortly()).map(|_| ())
}

pub(super) fn expect_value(bench: &mut Bench<'_>, at: Multiplexer, right: &[u8], duty: &str) -> Judged {
    let now = bench.read(at)?;
    bench.check(has_value(at, right, now, duty))
}

fn has_value(at: Multiplexer, right: &[u8], now: Vec<u8>, duty: &str) -> crate::verdict::Check {
    demand(now == right, || {
        let breach = Breach::new(at, duty.to_owned()).expected(Observation::Value(right.to_vec()));
        breach.found(Observation::Value(now))
    })
}

/// Sends the RPDO correctly once: its effect proves that a missing effect in the case is significant.
pub(super) fn proven(bench: &mut Bench<'_>, subject: &Subject) -> Result<(), Stop> {
    send(bench, subject, &subject.other)?;
    let now = bench.read(subject.mapped.at)?;
    has_value(subject.mapped.at, &subject.other, now, "the RPDO takes effect").or_inconclusive()?;
    send(bench, subject, &subject.before)
}

/// An event-driven RPDO sets its mapped objects immediately.
#[case(id = "301/rpdo/event-driven", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RpdoIgnored])]
fn event_driven(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 255)?;
    operational(bench)?;
    send(bench, &subject, &subject.other)?;
    let duty = format!("{} has the value of the RPDO", subject.mapped.at);
    expect_value(bench, subject.mapped.at, &subject.other, &duty)
}

/// An RPDO with the length of its mapping is no error: the device sends no EMCY for a protocol error (82xxh).
#[case(id = "301/rpdo/no-error", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RightRpdoReported])]
fn no_error(bench: &mut Bench<'_>) -> Judged {
    expect_no_error(bench, "an RPDO of the right length is no error", |bench| {
        let subject = subject(bench, 255)?;
        operational(bench)?;
        Ok((subject.can_id, subject.before))
    })
}

/// An RPDO of a synchronous transmission type, 0 to 240, takes effect with the next SYNC, not before it.
///
/// The case tries the types 1, 0 and 240; each device decides whether it supports the last two.
#[case(id = "301/rpdo/synchronous", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Must,
       needs = [RpdoMapping, Sync], catches = [SynchronousRpdoActsAtOnce, OuterSynchronousRpdosActAtOnce])]
fn synchronous(bench: &mut Bench<'_>) -> Judged {
    bench.expect_plain_sync()?;
    bench.each([1_u8, 0, 240], |bench, transmission_type| {
        if transmission_type != 1 && !supports(bench, transmission_type)? {
            bench.note(format!("transmission type {transmission_type} is refused, and not tried"));
            return Ok(());
        }
        waits_for_sync(bench, transmission_type)?;
        // Some devices change a mapping only in pre-operational.
        bench.command(Command::ENTER_PRE_OPERATIONAL)?;
        bench.listen(bench.timing().reaction).map(|_| ())
    })
}

/// Whether RPDO 1 accepts this transmission type.
fn supports(bench: &mut Bench<'_>, transmission_type: u8) -> Result<bool, Stop> {
    let cob_id = bench.pdo_off(RPDO)?;
    let is_accepted = bench.download(RPDO.parameter(2), &[transmission_type])?.abort().is_none();
    bench.pdo_on(RPDO, cob_id)?;
    Ok(is_accepted)
}

fn waits_for_sync(bench: &mut Bench<'_>, transmission_type: u8) -> Judged {
    let subject = subject(bench, transmission_type)?;
    let sync_id = bench.sync_id()?;
    operational(bench)?;
    bench.send_bytes(sync_id, &[])?;
    send(bench, &subject, &subject.other)?;
    let at = subject.mapped.at;
    let waits = format!("{at} keeps its value until SYNC, with transmission type {transmission_type}");
    expect_value(bench, at, &subject.before, &waits)?;
    bench.send_bytes(sync_id, &[])?;
    bench.listen(bench.shortly())?;
    let acts = format!("{at} has the value of the RPDO after SYNC, with transmission type {transmission_type}");
    expect_value(bench, at, &subject.other, &acts)
}

/// An RPDO has no effect in pre-operational.
#[case(id = "301/state/pre-operational/rpdo", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RpdoInPreOperational])]
fn pre_operational(bench: &mut Bench<'_>) -> Judged {
    silent_after(bench, Command::ENTER_PRE_OPERATIONAL, "in pre-operational")
}

/// An RPDO has no effect in stopped.
#[case(id = "301/state/stopped/rpdo", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RpdoWhenStopped])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    silent_after(bench, Command::STOP, "in stopped")
}

fn silent_after(bench: &mut Bench<'_>, command: Command, state: &str) -> Judged {
    let subject = subject(bench, 255)?;
    operational(bench)?;
    proven(bench, &subject)?;
    bench.command(command)?;
    bench.listen(bench.timing().reaction)?;
    send(bench, &subject, &subject.other)?;
    // A stopped device answers no SDO.
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    let duty = format!("an RPDO has no effect {state}");
    expect_value(bench, subject.mapped.at, &subject.before, &duty)
}

/// An RPDO that is switched off (bit 31 of its COB-ID) has no effect.
#[case(id = "301/rpdo/invalid", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RpdoReceivedWhenInvalid])]
fn invalid(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 255)?;
    operational(bench)?;
    proven(bench, &subject)?;
    // Some devices accept PDO parameters in pre-operational only.
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    bench.pdo_off(RPDO)?;
    operational(bench)?;
    send(bench, &subject, &subject.other)?;
    expect_value(bench, subject.mapped.at, &subject.before, "an RPDO that is switched off has no effect")
}

/// An RPDO that is shorter than its mapping has no effect. A device that supports EMCY reports it by EMCY 8210h.
#[case(id = "301/rpdo/too-short", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RpdoLengthUnchecked, ShortRpdoUnreported], cct = "5.4")]
fn too_short(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 255)?;
    let has_emcy = has_emcy(bench)?;
    let patience = patience(bench)?;
    operational(bench)?;
    proven(bench, &subject)?;
    bench.expect_emergencies();
    let shorter = subject.other.get(..subject.other.len() - 1).unwrap_or_default().to_vec();
    bench.drain()?;
    bench.send_bytes(subject.can_id, &shorter)?;
    let heard: Vec<Record> = emergencies(bench, bench.shortly().max(if has_emcy { patience } else { Duration::ZERO }))?;
    // Only 0000h and 1000h are mandatory: a device may have no other code.
    let right = [EmcyCode::PDO_LENGTH, EmcyCode::GENERIC].map(Observation::Emcy);
    let is_told = heard.iter().any(|record| right.contains(&observed(std::slice::from_ref(record))));
    bench.check(demand(is_told || !has_emcy, || {
        let breach = Breach::new(RPDO.subject(), "an RPDO with too few bytes is reported by EMCY 8210h");
        breach.expected(Allowed::OneOf(right.to_vec())).found(observed(&heard)).told(shown(&heard))
    }))?;
    expect_value(bench, subject.mapped.at, &subject.before, "an RPDO that is too short has no effect")
}

/// Whether the device can send EMCYs now: 1014h exists, and its bit 31 is 0.
fn has_emcy(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    const EMCY_ID: Multiplexer = Multiplexer::new(object::COB_ID_EMCY, 0);
    Ok(bench.has(EMCY_ID)? && CobId(bench.read_number(EMCY_ID)?).is_valid())
}

/// The device uses the first bytes of an RPDO that is longer than its mapping. If it sends an EMCY for a protocol error
/// (82xxh), the error code is 8220h, 8210h or the general 8200h.
#[case(id = "301/rpdo/too-long", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [LongRpdoIgnored, LongRpdoCalledLate])]
fn too_long(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 255)?;
    operational(bench)?;
    bench.expect_emergencies();
    let mut longer = subject.other.clone();
    longer.push(0xA5);
    if longer.len() > 8 {
        let reason =
            Reason::new("RPDO 1 carries an object of fewer than eight bytes", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let begun = bench.now();
    send(bench, &subject, &longer)?;
    let since = bench.heard_since(begun);
    let heard = errors_of(bench, since);
    let is_other = |record: &&Record| {
        let code = code_of(record).map(|code| code.0.to_be_bytes());
        matches!(code, Some([0x82, other]) if !matches!(other, 0x00 | 0x10 | 0x20))
    };
    let wrong: Vec<Record> = heard.iter().filter(is_other).cloned().collect();
    bench.check(demand(wrong.is_empty(), || {
        let breach = Breach::new(RPDO.subject(), "an EMCY for an RPDO with too many bytes has an error code for that");
        breach.expected("EMCY 8220h, 8210h or 8200h, or none").found(observed(&wrong)).told(shown(&wrong))
    }))?;
    let duty = format!("{} has the first bytes of an RPDO that is too long", subject.mapped.at);
    expect_value(bench, subject.mapped.at, &subject.other, &duty)
}

/// An object that can be 0: devices often read zeros from the data of a remote frame.
fn object_for_zero(bench: &mut Bench<'_>) -> Result<Option<Mapped>, Stop> {
    const MOST_TRIED: usize = 8;
    let mut objects = bench.rpdo_objects();
    // Objects that fit into an expedited SDO come first.
    objects.sort_by_key(|mapped| mapped.bits > 32);
    let within_limits = objects.iter().copied().filter(|mapped| bench.is_within_limits(mapped.at, 0));
    for mapped in within_limits.take(MOST_TRIED).collect::<Vec<_>>() {
        // Not every limit is in the description.
        if bench.download(mapped.at, &vec![0; usize::from(mapped.bits / 8)])?.abort().is_none() {
            return Ok(Some(mapped));
        }
    }
    Ok(objects.first().copied())
}

/// A remote frame or 29-bit frame with the CAN-ID of an RPDO has no effect.
#[case(id = "301/rpdo/other-frames", clause = "CiA 301 7.2.2.5.1", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RemoteFrameTakenAsRpdo, ExtendedFrameObeyed])]
fn other_frames(bench: &mut Bench<'_>) -> Judged {
    let mapped = object_for_zero(bench)?;
    let subject = carrying(bench, mapped, 255)?;
    operational(bench)?;
    let value = if subject.before.iter().all(|&byte| byte == 0) { &subject.other } else { &subject.before };
    send(bench, &subject, value)?;
    let length = u8::try_from(value.len()).unwrap_or(8);
    let id = u32::from(subject.can_id);
    let inverted = if value == &subject.before { &subject.other } else { &subject.before };
    let frames = [
        ("a remote frame", Frame::remote(CanId::standard_masked(id), length)),
        ("a 29-bit frame", Frame::new(CanId::extended_masked(id), inverted)),
    ];
    bench.each(frames, |bench, (what, frame)| {
        if let Some(frame) = frame {
            bench.send(&frame)?;
        }
        bench.listen(bench.shortly())?;
        let duty = format!("{what} with the CAN-ID of an RPDO has no effect");
        expect_value(bench, subject.mapped.at, value, &duty)
    })
}

/// After many RPDOs without a pause the mapped object has the value of the last RPDO, and the device still works.
#[case(id = "301/rpdo/load", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [WatchdogResetUnderLoad, SdoSilentWhenOperational])]
fn load(bench: &mut Bench<'_>) -> Judged {
    const FRAMES: usize = 1_000;
    let subject = subject(bench, 255)?;
    operational(bench)?;
    bench.expect_emergencies();
    for n in 0..FRAMES {
        let value = if n % 2 == 0 { &subject.before } else { &subject.other };
        bench.send_bytes(subject.can_id, value)?;
    }
    bench.drain()?;
    // The frames wait for the bus: 130 µs each at 1 Mbit/s, 2.6 ms at 50 kbit/s.
    bench.listen(Duration::from_millis(3_000))?;
    let duty = format!("{} has the value of the last of {FRAMES} RPDOs", subject.mapped.at);
    bench.expect_value(subject.mapped.at, &subject.other, duty)
}

/// The case only records whether an RPDO sets an object to a value that an SDO download may not write.
///
/// CiA 301 does not say whether the device limits, ignores or accepts such a value.
#[case(id = "301/rpdo/out-of-range", clause = "CiA 301 7.2.2.2", confidence = Cited, level = Open,
       needs = [RpdoMapping], catches = [RpdoRangeUnchecked])]
fn out_of_range(bench: &mut Bench<'_>) -> Judged {
    let node = bench.node();
    let limited = bench.rpdo_objects().into_iter().find_map(|mapped| {
        let entry = bench.target().description.as_ref()?.dictionary.entry(mapped.at).ok()?;
        let limit = entry.high_limit.as_ref()?.resolve(entry.data_type, node).as_number()?;
        let beyond = u64::try_from(limit + 1).ok().filter(|beyond| mapped.bits == 64 || beyond >> mapped.bits == 0)?;
        Some((mapped, beyond))
    });
    let Some((mapped, beyond)) = limited else {
        let reason = Reason::new("an RPDO can carry an object with a limit", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let before = bench.read(mapped.at)?;
    bench.write(mapped.at, &before)?;
    bench.set_mapping(RPDO, &[mapped])?;
    bench.set_pdo(RPDO, &[(2, &[255])])?;
    operational(bench)?;
    bench.expect_emergencies();
    let can_id = (bench.pdo_cob_id(RPDO)?.can_id() & 0x7FF) as u16;
    let length = usize::from(mapped.bits / 8);
    let data: Vec<u8> = beyond.to_le_bytes().into_iter().take(length).collect();
    bench.send_bytes(can_id, &data)?;
    bench.listen(bench.shortly())?;
    let now = bench.read(mapped.at)?;
    bench.check(demand(now != data, || {
        let breach = Breach::new(mapped.at, "an RPDO does not set a value that an SDO download can't write");
        breach.expected("a value within its limits").found(Observation::Value(now))
    }))
}

/// The case only records whether the device reports an RPDO whose deadline (event timer) has passed by EMCY 8250h. CiA
/// 301 says that the timer may be used for this purpose, and leaves the report to the application.
#[case(id = "301/rpdo/deadline", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Open,
       needs = [RpdoMapping], catches = [RpdoDeadlineIgnored])]
fn deadline(bench: &mut Bench<'_>) -> Judged {
    const DEADLINE_MS: u16 = 100;
    let subject = subject(bench, 255)?;
    if !bench.can_write(RPDO.parameter(5))? {
        let reason = Reason::new("RPDO 1 has a deadline", "1400h:05", "the device has no 1400h:05 that can be written");
        return Err(Stop::NotApplicable(reason));
    }
    bench.set_pdo(RPDO, &[(5, &DEADLINE_MS.to_le_bytes())])?;
    operational(bench)?;
    bench.expect_emergencies();
    // Monitoring begins with the first RPDO.
    bench.send_bytes(subject.can_id, &subject.other)?;
    let heard = emergencies(bench, Duration::from_millis(u64::from(DEADLINE_MS) * 4))?;
    let right = Observation::Emcy(EmcyCode::RPDO_TIMEOUT);
    let is_told = heard.iter().any(|record| observed(std::slice::from_ref(record)) == right);
    bench.check(demand(is_told, || {
        let breach = Breach::new(RPDO.subject(), format!("an RPDO missing for {DEADLINE_MS} ms is reported"));
        breach.expected(right).found(observed(&heard)).told(shown(&heard))
    }))
}

/// The device refuses the transmission types 241 to 253, which are reserved for RPDOs, with abort 0609 0030h.
#[case(id = "301/rpdo/reserved-type", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Must,
       needs = [Rpdo], catches = [ReservedTransmissionTypeAccepted])]
fn reserved_type(bench: &mut Bench<'_>) -> Judged {
    if !bench.can_write(RPDO.parameter(2))? {
        let reason = Reason::new("the transmission type of RPDO 1 can be changed", "1400h:02", "not writable");
        return Err(Stop::NotApplicable(reason));
    }
    bench.pdo_off(RPDO)?;
    let before = bench.read(RPDO.parameter(2))?;
    bench.each([241_u8, 247, 251, 252, 253], |bench, reserved| {
        let attempt = bench.download(RPDO.parameter(2), &[reserved])?;
        bench.check(attempt.refused(Situation::TransmissionType))
    })?;
    bench.expect_unchanged(RPDO.parameter(2), &before)
}

/// The CAN-ID of a valid RPDO does not change: the device refuses the write, and the COB-ID keeps its value.
#[case(id = "301/rpdo/cob-id/valid", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [CobIdChangeWhileValid])]
fn cob_id_valid(bench: &mut Bench<'_>) -> Judged {
    /// A CAN-ID that no predefined object has and CiA 301 does not restrict.
    const FREE: u32 = 0x6A0;
    let subject = subject(bench, 255)?;
    let own = bench.read(RPDO.parameter(1))?;
    let other = number(&own) & !0x7FF | FREE;
    let attempt = bench.download(RPDO.parameter(1), &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
    bench.expect_unchanged(RPDO.parameter(1), &own)?;
    operational(bench)?;
    proven(bench, &subject)?;
    Ok(())
}

/// An RPDO whose CAN-ID is changed while it is switched off is received with the new CAN-ID.
#[case(id = "301/rpdo/cob-id/moved", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RpdoKeepsCanId])]
fn cob_id_moved(bench: &mut Bench<'_>) -> Judged {
    const FREE: u16 = 0x6A0;
    let mut subject = subject(bench, 255)?;
    let own = bench.pdo_off(RPDO)?;
    let moved = CobId(own.0 & !0x7FF | u32::from(FREE) | CobId::INVALID);
    move_to(bench, RPDO, moved)?;
    bench.pdo_on(RPDO, moved)?;
    reads_back(bench, RPDO, moved)?;
    operational(bench)?;
    subject.can_id = FREE;
    send(bench, &subject, &subject.other)?;
    let duty = format!("RPDO 1 is received with CAN-ID {FREE:03X}h");
    expect_value(bench, subject.mapped.at, &subject.other, &duty)
}

/// Two objects in one RPDO receive their values by their places in the mapping.
#[case(id = "301/rpdo/layout", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [RpdoBytesReversed, RpdoFirstObjectOnly])]
fn layout(bench: &mut Bench<'_>) -> Judged {
    let objects: Vec<Mapped> = bench.rpdo_objects().into_iter().filter(|mapped| mapped.bits <= 32).take(2).collect();
    let [first, second] = objects.as_slice() else {
        let reason = Reason::new("an RPDO can carry two objects", "two in the description", "fewer");
        return Err(Stop::NotApplicable(reason));
    };
    if !bench.can_write(RPDO.entry(2))? {
        let reason = Reason::new("RPDO 1 can carry two objects", format!("{}", RPDO.entry(2)), "absent or read-only");
        return Err(Stop::NotApplicable(reason));
    }
    let before = [bench.read(first.at)?, bench.read(second.at)?];
    for (mapped, value) in objects.iter().zip(&before) {
        bench.write(mapped.at, value)?;
    }
    bench.set_mapping(RPDO, &objects)?;
    bench.set_pdo(RPDO, &[(2, &[255])])?;
    let can_id = (bench.pdo_cob_id(RPDO)?.can_id() & 0x7FF) as u16;
    operational(bench)?;
    let others = [bench.other_value(first.at, &before[0]), bench.other_value(second.at, &before[1])];
    // First one value changes and the other stays, then both change.
    bench.each([[&others[0], &before[1]], [&others[0], &others[1]]], |bench, [one, two]| {
        let data: Vec<u8> = one.iter().chain(two).copied().collect();
        bench.send_bytes(can_id, &data)?;
        bench.listen(bench.shortly())?;
        expect_value(bench, first.at, one, "the first object of an RPDO has its first bytes")?;
        expect_value(bench, second.at, two, "the second object of an RPDO has the bytes after them")
    })
}

/// The case only records whether a device with SYNC accepts the synchronous transmission types 0, 1, 2 and 240 for an
/// RPDO, because each device decides which types it supports.
#[case(id = "301/rpdo/synchronous-types", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Open,
       needs = [Rpdo, Sync], catches = [SynchronousRpdoRefused])]
fn synchronous_types(bench: &mut Bench<'_>) -> Judged {
    if !bench.can_write(RPDO.parameter(2))? {
        let reason = Reason::new("the transmission type of RPDO 1 can be changed", "1400h:02", "not writable");
        return Err(Stop::NotApplicable(reason));
    }
    bench.pdo_off(RPDO)?;
    bench.each([0_u8, 1, 2, 240], |bench, kind| {
        let mut attempt = bench.download(RPDO.parameter(2), &[kind])?;
        attempt.what = format!("transmission type {kind} of RPDO 1");
        bench.check(attempt.expect_confirmation())
    })
}
