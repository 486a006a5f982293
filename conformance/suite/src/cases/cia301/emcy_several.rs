//! Several errors, simultaneous or successive (CiA 301, 7.2.7.1 and 7.5.2.4), and EMCY with another CAN-ID.

use super::emcy::{
    Monitored, begin_monitoring, code_of, emergencies, is_error, observed, patience, reported_loss, shown, sign_of_life,
};
use super::heartbeat_consumer::entry;
use crate::bench::Bench;
use crate::bench::pdo::RPDO;
use crate::bench::sdo::number;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{CobId, Multiplexer, Service};
use canvass_bus::observation::Observation;
use canvass_traces::{Direction, Duration, Record, Timestamp};

const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);
const HISTORY: u16 = object::PREDEFINED_ERROR_FIELD;
const COB_ID: Multiplexer = Multiplexer::new(object::COB_ID_EMCY, 0);
const CONSUMER: u16 = object::CONSUMER_HEARTBEAT_TIME;
const CONSUMER_MS: u16 = 200;
/// Period of the heartbeats of the monitored node.
const BEAT: Duration = Duration::from_millis(50);
/// Number of heartbeat periods until the device reports a silent node, with a tolerance.
const UNTIL_LOST: usize = 10;
/// A CAN-ID that belongs to no predefined object and that CiA 301 does not restrict.
const FREE: u32 = 0x6B0;

/// The frames with this CAN-ID since `from`, whatever the tester was waiting for.
fn since(bench: &Bench<'_>, from: Timestamp, can_id: u16) -> Vec<Record> {
    let heard = bench.evidence().frames().map(|exhibit| &exhibit.record);
    let is_it = |record: &&Record| record.direction != Direction::Tx && record.frame.cob_id() == Some(can_id);
    heard.filter(|record| record.timestamp > from).filter(is_it).cloned().collect()
}

/// The EMCYs since `from`.
fn emergencies_since(bench: &Bench<'_>, from: Timestamp) -> Vec<Record> {
    since(bench, from, emcy::CAN_ID_BASE + u16::from(bench.node().raw()))
}

/// Makes the device monitor two node-IDs that nobody uses, and returns them.
fn watch_two(bench: &mut Bench<'_>) -> Result<[u8; 2], Stop> {
    bench.expect_emergencies();
    let own = bench.node().raw();
    let mut vacant = (1..=127).filter(|&node| node != own && bench.is_vacant(node));
    let (Some(first), Some(second)) = (vacant.next(), vacant.next()) else {
        return Err(Stop::NotApplicable(Reason::new("two node-IDs are free", "two", "fewer")));
    };
    if !bench.has(Multiplexer::new(CONSUMER, 2))? {
        let reason = Reason::new("two nodes can be monitored", "1016h:02", "the device has one entry");
        return Err(Stop::NotApplicable(reason));
    }
    for (sub, node) in [(1, first), (2, second)] {
        bench.write(Multiplexer::new(CONSUMER, sub), &entry(node, CONSUMER_MS))?;
    }
    Ok([first, second])
}

/// Sends heartbeats of these nodes until the device misses the others; returns the EMCYs meanwhile.
fn beats(bench: &mut Bench<'_>, nodes: &[u8]) -> Result<Vec<Record>, Stop> {
    let mut heard = Vec::new();
    for _ in 0..UNTIL_LOST {
        for &node in nodes {
            let message = ErrorControl::heartbeat(State::OPERATIONAL);
            bench.send(&message.to_frame(error_control::CAN_ID_BASE + u16::from(node)))?;
        }
        heard.extend(emergencies(bench, BEAT)?);
    }
    Ok(heard)
}

/// A device with two errors remains in error when the first of them is gone: 1001h keeps its generic bit, and so does
/// an EMCY 0000h that reports the end of the first error. When both errors are gone, the device sends EMCY 0000h.
#[case(id = "301/emcy/one-of-two", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [ErrorsClearedTogether, EmcyResetMissing, HeartbeatConsumerFirstOnly,
       HeartbeatConsumerNotRearmed])]
fn one_of_two(bench: &mut Bench<'_>) -> Judged {
    let nodes = watch_two(bench)?;
    let patience = patience(bench)?;
    let before = bench.read_number(ERROR_REGISTER)?;
    beats(bench, &nodes)?;
    let mut lost = beats(bench, &nodes[1..])?;
    lost.extend(emergencies(bench, Duration::from_millis(u64::from(CONSUMER_MS)) + patience)?);
    let generic = u32::from(ErrorRegister::GENERIC.0);
    if !lost.iter().any(is_error) || bench.read_number(ERROR_REGISTER)? & generic == 0 {
        let reason = Reason::new("the loss of two nodes is an error", "EMCY, and bit 0 of 1001h", shown(&lost));
        return Err(Stop::NotApplicable(reason));
    }
    let back = beats(bench, &nodes[..1])?;
    let register = bench.read(ERROR_REGISTER)?;
    bench.check(demand(number(&register) & generic != 0, || {
        let breach = Breach::new(ERROR_REGISTER, "1001h still shows an error when one of two errors is gone");
        breach.expected("bit 0 set").found(Observation::Value(register))
    }))?;
    let empty = back.iter().find(|record| !is_error(record) && !has_generic_bit(record));
    bench.check(demand(empty.is_none(), || {
        let breach = Breach::new(
            Service::Emcy,
            "the error register in EMCY 0000h still shows an error when one of two errors is gone",
        );
        breach.expected("bit 0 of byte 2 set").found(observed(&back)).told(shown(&back))
    }))?;
    let mut gone = beats(bench, &nodes)?;
    gone.extend(emergencies(bench, patience)?);
    let register = bench.read_number(ERROR_REGISTER)?;
    bench.check(demand(gone.iter().any(|record| !is_error(record)), || {
        let breach = Breach::new(Service::Emcy, "the end of the last of two errors is reported");
        breach
            .expected("EMCY 0000h")
            .found(observed(&gone))
            .told(format!("1001h is {before:02X}h before, {register:02X}h now"))
    }))
}

fn has_generic_bit(record: &Record) -> bool {
    record.data().get(2).is_some_and(|bits| bits & ErrorRegister::GENERIC.0 != 0)
}

/// The error history lists all errors that the device has signalled by EMCY, up to its number of entries: the newest at
/// 1003h:01, the oldest at the highest sub-index.
#[case(id = "301/error-history/all", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Must,
       needs = [ErrorHistory, Monitoring, Description], catches = [ErrorHistoryMovesTwo, ErrorHistoryReversed, ErrorHistoryNotKept])]
fn all(bench: &mut Bench<'_>) -> Judged {
    bench.write(Multiplexer::new(HISTORY, 0), &[0])?;
    let codes = several_errors(bench)?;
    let entries = (1..=0xFE).take_while(|&sub| bench.described(Multiplexer::new(HISTORY, sub)) == Some(true)).count();
    let (least, most) = (codes.len().min(entries) as u64, codes.len() as u64);
    let at = Multiplexer::new(HISTORY, 0);
    let count = u64::from(bench.read_number(at)?);
    let is_right = (least..=most).contains(&count);
    let signalled: Vec<String> = codes.iter().map(|code| format!("{code:04X}h")).collect();
    let listed = if is_right { String::new() } else { listed(bench, entries.min(count as usize)) };
    bench.check(demand(is_right, || {
        Breach::new(at, "1003h:00 counts the errors that were signalled, up to the number of entries")
            .expected(Allowed::Count { least, most: Some(most) })
            .found(Observation::Number(count))
            .told(format!("{count} ({listed}); signalled: {}", signalled.join(", ")))
    }))?;
    if codes.iter().all(|code| codes.first() == Some(code)) {
        let actual = codes.first().map_or_else(String::new, |code| format!("{code:04X}h only"));
        return Err(Stop::NotApplicable(Reason::new("errors differ in their codes", "two codes", actual)));
    }
    let right: Vec<(u8, u16)> = (1..).zip(codes.into_iter().rev()).take(entries.min(count as usize)).collect();
    bench.each(right, |bench, (sub, code)| {
        let at = Multiplexer::new(HISTORY, sub);
        let value = bench.upload(at)?.value()?;
        bench.check(demand(number(&value) & 0xFFFF == u32::from(code), || {
            let breach = Breach::new(at, "1003h lists the errors that were signalled, the newest first");
            breach.expected(format!("error code {code:04X}h in the lower word")).found(Observation::Value(value))
        }))
    })
}

/// The codes of the newest `count` entries of the error history, in words.
fn listed(bench: &mut Bench<'_>, count: usize) -> String {
    let read = |sub| match bench.unjudged(|bench| bench.read_number(Multiplexer::new(HISTORY, sub))) {
        Ok(entry) => format!("{:04X}h", entry & 0xFFFF),
        Err(_) => "an unreadable entry".to_owned(),
    };
    let codes: Vec<String> = (1..=0xFE).take(count).map(read).collect();
    codes.join(", ")
}

/// Causes several errors and returns their codes in order: losses of the monitored node or master and, after the first
/// loss, an RPDO that is too short, if the device has an RPDO for which this is an error. So the list differs from its
/// reverse.
fn several_errors(bench: &mut Bench<'_>) -> Result<Vec<u16>, Stop> {
    let until_lost = patience(bench)? + Duration::from_millis(600);
    let short = too_short(bench)?;
    let monitored = begin_monitoring(bench)?;
    let mut heard = emergencies(bench, until_lost)?;
    if let Some((can_id, right)) = short {
        bench.command(Command::START)?;
        bench.listen(bench.timing().reaction)?;
        for data in [&[], right.as_slice()] {
            bench.send_bytes(can_id, data)?;
            heard.extend(emergencies(bench, until_lost)?);
        }
    }
    for _ in 0..3 {
        sign_of_life(bench, monitored)?;
        heard.extend(emergencies(bench, until_lost)?);
    }
    let codes: Vec<u16> = heard.iter().filter_map(code_of).map(|code| code.0).filter(|&code| code != 0).collect();
    if codes.is_empty() {
        return Err(Stop::Inconclusive(Reason::new(
            "the loss of the monitored node or master is reported",
            "an EMCY",
            shown(&heard),
        )));
    }
    Ok(codes)
}

/// The CAN-ID of an RPDO for which an empty frame is too short, and a payload of the right length; `None` if there is
/// no such RPDO.
fn too_short(bench: &mut Bench<'_>) -> Result<Option<(u16, Vec<u8>)>, Stop> {
    if !bench.has(RPDO.parameter(1))? || !bench.has(RPDO.entry(1))? {
        return Ok(None);
    }
    let (cob_id, mapping) = (bench.pdo_cob_id(RPDO)?, bench.mapping(RPDO)?);
    let bits: usize = mapping.iter().map(|mapped| usize::from(mapped.bits)).sum();
    let can_id = u16::try_from(cob_id.can_id()).ok().filter(|_| cob_id.is_valid() && bits > 0);
    Ok(can_id.map(|can_id| (can_id, vec![0; bits.div_ceil(8).min(8)])))
}

/// A device with another CAN-ID in 1014h sends EMCY with that CAN-ID, in a data frame of eight bytes, and no longer
/// with the old CAN-ID. Reset communication restores the old CAN-ID.
#[case(id = "301/emcy/moved", clause = "CiA 301 7.5.2.17", confidence = Cited, level = Must,
       needs = [EmcyId, Monitoring],
       catches = [EmcyKeepsCanId, EmcyMovedIsRemote, NmtResetCommunicationKeepsParameters])]
fn moved(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    reported_loss(bench)?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    for value in [own | CobId::INVALID, own & !0x7FF | CobId::INVALID | FREE, own & !0x7FF & !CobId::INVALID | FREE] {
        bench.write(COB_ID, &value.to_le_bytes())?;
    }
    let [new, old] = lost_on(bench, [FREE as u16, CobId(own).can_id() as u16])?;
    let is_whole = |record: &&Record| !record.frame.is_remote() && record.data().len() == 8;
    bench.check(demand(new.iter().any(is_error) && new.iter().all(|record| is_whole(&record)), || {
        let breach =
            Breach::new(COB_ID, "EMCY is sent with the CAN-ID in 1014h").expected("EMCY of eight bytes on 6B0h");
        breach.found(observed(&new)).told(shown(&new))
    }))?;
    bench.check(demand(old.is_empty(), || {
        let breach = Breach::new(COB_ID, "no EMCY is sent with the CAN-ID that 1014h had before");
        breach.expected(Observation::Silence).found(observed(&old)).told(shown(&old))
    }))?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    let now = bench.read_number(COB_ID)?;
    let keeps = bench.stores_by_itself()?;
    bench.check(demand(keeps || now & 0x7FF == own & 0x7FF, || {
        let breach = Breach::new(COB_ID, "1014h:00 has its power-on value after reset communication");
        breach
            .expected(Observation::Value(own.to_le_bytes().into()))
            .found(Observation::Value(now.to_le_bytes().into()))
    }))?;
    let [new, _] = lost_on(bench, [FREE as u16, CobId(now).can_id() as u16])?;
    bench.check(demand(new.is_empty() || now & 0x7FF == FREE, || {
        let breach = Breach::new(COB_ID, "after reset communication no EMCY is sent with the CAN-ID from before it");
        breach.expected(Observation::Silence).found(observed(&new)).told(shown(&new))
    }))
}

/// Makes the monitored node or master fall silent, and returns the frames with each of two CAN-IDs.
fn lost_on(bench: &mut Bench<'_>, can_ids: [u16; 2]) -> Result<[Vec<Record>; 2], Stop> {
    let from = bench.now();
    begin_monitoring(bench)?;
    bench.listen(Duration::from_millis(600))?;
    Ok(can_ids.map(|can_id| since(bench, from, can_id)))
}

/// Reset communication discards an EMCY that waits for the inhibit time: after the reset the device does not report an
/// error that no longer exists. Because it then monitors neither a master nor a node, no EMCY reports their loss.
#[case(id = "301/emcy/after-reset", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Should,
       needs = [EmcyInhibit, Monitoring], catches = [EmcySurvivesReset])]
fn after_reset(bench: &mut Bench<'_>) -> Judged {
    const INHIBIT_TIME: Multiplexer = Multiplexer::new(object::INHIBIT_TIME_EMCY, 0);
    bench.expect_emergencies();
    // A device may find an error at each start.
    let usual = error_codes_after_reset(bench)?;
    let len = bench.read(INHIBIT_TIME)?.len();
    let mut value = 40_000_u32.to_le_bytes().to_vec();
    value.truncate(len);
    bench.write(INHIBIT_TIME, &value)?;
    let (monitored, _) = reported_loss(bench)?;
    // The end of this error and the next error wait for the inhibit time.
    sign_of_life(bench, monitored)?;
    let waiting = emergencies(bench, Duration::from_millis(600))?;
    if waiting.iter().any(is_error) {
        let reason = Reason::new("an EMCY waits for 4 s of inhibit time", "none", shown(&waiting));
        return Err(Stop::NotApplicable(reason));
    }
    let codes = error_codes_after_reset(bench)?;
    let late = codes.into_iter().find(|code| !usual.contains(code));
    bench.check(demand(late.is_none(), || {
        let breach = Breach::new(Service::Emcy, "an error from before reset communication is not reported after it");
        breach
            .expected("only errors that are reported after each reset")
            .found(late.map_or(Observation::Silence, Observation::Emcy))
    }))
}

fn error_codes_after_reset(bench: &mut Bench<'_>) -> Result<Vec<EmcyCode>, Stop> {
    let from = bench.now();
    bench.reset(Command::RESET_COMMUNICATION)?;
    let mut heard = emergencies_since(bench, from);
    heard.extend(emergencies(bench, Duration::from_secs(5))?);
    Ok(heard.iter().filter(|record| is_error(record)).filter_map(code_of).collect())
}

/// If 1001h shows no error, the last EMCY 0000h that the device sent reports no remaining error.
#[case(id = "301/emcy/last-word", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       needs = [Monitoring], catches = [EmcyResetRegisterWrong])]
fn last_word(bench: &mut Bench<'_>) -> Judged {
    let patience = patience(bench)?;
    let from = bench.now();
    let (monitored, _) = reported_loss(bench)?;
    match monitored {
        Monitored::Master => bench.ask_for_state()?,
        Monitored::Node(_) => sign_of_life(bench, monitored)?,
    }
    // Monitoring ends, so that no further loss occurs meanwhile.
    match monitored {
        Monitored::Master => bench.write(Multiplexer::new(object::LIFE_TIME_FACTOR, 0), &[0])?,
        Monitored::Node(node) => bench.write(Multiplexer::new(CONSUMER, 1), &entry(node, 0))?,
    }
    // Some devices clear their errors when they are read.
    let mut register = bench.read_number(ERROR_REGISTER)?;
    bench.listen(patience)?;
    if register != 0 {
        register = bench.read_number(ERROR_REGISTER)?;
    }
    let heard = emergencies_since(bench, from);
    let Some(last) = heard.last().filter(|last| !is_error(last) && register == 0) else { return Ok(()) };
    let said = last.data().get(2).copied().unwrap_or_default();
    bench.check(demand(said == 0, || {
        let breach = Breach::new(Service::Emcy, "the last EMCY 0000h reports no remaining error, like 1001h");
        breach.expected(Observation::Number(0)).found(Observation::Number(u64::from(said))).told(shown(&heard))
    }))
}

/// EMCY 0000h reports the end of an error: a device that has reported no error sends none, whatever object is read.
#[case(id = "301/emcy/no-error-no-reset", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       catches = [EmcyResetUnasked])]
fn no_error_no_reset(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    if bench.read_number(ERROR_REGISTER)? != 0 {
        let reason = Reason::new("the device is free of errors", "1001h = 0", "set bits");
        return Err(Stop::NotApplicable(reason));
    }
    // The device sends the EMCYs of its start first.
    bench.listen(Duration::from_millis(500))?;
    let from = bench.now();
    for _ in 0..3 {
        bench.upload(ERROR_REGISTER)?;
        bench.upload(Multiplexer::new(HISTORY, 0))?;
        bench.listen(bench.timing().reaction)?;
    }
    let heard = emergencies_since(bench, from);
    let first_is_reset = heard.first().is_some_and(|first| !is_error(first));
    // The end of an error reported at the start may have waited.
    let had_error = emergencies_since(bench, Timestamp::ZERO).iter().any(is_error);
    bench.check(demand(!first_is_reset || had_error, || {
        let breach = Breach::new(Service::Emcy, "EMCY 0000h comes only after an error was reported");
        breach.expected(Observation::Silence).found(observed(&heard)).told(shown(&heard))
    }))
}

/// The case only records whether 1001h and 1003h show no error after a plain start, because only the device can know
/// its errors.
#[case(id = "301/emcy/error-free", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Open,
       catches = [ErrorRegisterNeverClear])]
fn error_free(bench: &mut Bench<'_>) -> Judged {
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    bench.check(demand(register.iter().all(|&bits| bits == 0), || {
        let breach = Breach::new(ERROR_REGISTER, "1001h shows no error after the start");
        breach.expected(Observation::Value(vec![0])).found(Observation::Value(register))
    }))
}

/// Clearing the error history does not end an error: 1001h still shows an error that persists, and the device sends no
/// EMCY 0000h.
#[case(id = "301/error-history/clear-keeps-error", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Should,
       needs = [ErrorHistory, Monitoring], catches = [HistoryClearsRegister])]
fn clear_keeps_error(bench: &mut Bench<'_>) -> Judged {
    let patience = patience(bench)?;
    reported_loss(bench)?;
    if bench.read_number(ERROR_REGISTER)? == 0 {
        let reason = Reason::new("1001h shows the error", "a bit that is set", "0");
        return Err(Stop::NotApplicable(reason));
    }
    bench.listen(patience)?;
    let from = bench.now();
    bench.write(Multiplexer::new(HISTORY, 0), &[0])?;
    bench.listen(patience)?;
    let heard = emergencies_since(bench, from);
    bench.check(demand(heard.iter().all(is_error), || {
        let breach = Breach::new(Service::Emcy, "clearing the error history does not end an error");
        breach.expected("no EMCY 0000h").found(observed(&heard)).told(shown(&heard))
    }))?;
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    bench.check(demand(register.iter().any(|&bits| bits != 0), || {
        let breach = Breach::new(ERROR_REGISTER, "1001h shows a persistent error, whatever the error history contains");
        breach.expected("a bit that is set").found(Observation::Value(register))
    }))
}
