//! EMCY, error register and error history. Nearly every device can report an error of its error control: the master
//! that guards it, or a node that it monitors, falls silent. The tester acts as both.

use super::heartbeat_consumer::entry;
use crate::bench::Bench;
use crate::bench::state::GUARD_TIME;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Check, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::Outcome;
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record};

const LIFE_TIME_FACTOR: Multiplexer = Multiplexer::new(object::LIFE_TIME_FACTOR, 0);
const WATCHED: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);
const ERROR_COUNT: Multiplexer = Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 0);
const INHIBIT_TIME: Multiplexer = Multiplexer::new(object::INHIBIT_TIME_EMCY, 0);
/// The guard time multiplied by the life time factor, or the consumer heartbeat time.
const GUARD_MS: u16 = 100;
const FACTOR: u8 = 2;
const CONSUMER_MS: u16 = 200;
/// Longer than `GUARD_MS` with its tolerance and an EMCY inhibit time together.
const UNTIL_LOST: Duration = Duration::from_millis(600);

/// The node that the device monitors, and that falls silent in the case.
#[derive(Clone, Copy)]
pub(super) enum Monitored {
    /// The master, which guards the device.
    Master,
    /// A node whose heartbeats the device monitors.
    Node(u8),
}

/// Sends one sign of life from the monitored node.
pub(super) fn sign_of_life(bench: &mut Bench<'_>, monitored: Monitored) -> Result<(), Stop> {
    match monitored {
        Monitored::Master => bench.guard().map(|_| ()),
        Monitored::Node(node) => {
            let message = ErrorControl::heartbeat(State::OPERATIONAL);
            bench.send(&message.to_frame(error_control::CAN_ID_BASE + u16::from(node))).map(|_| ())
        }
    }
}

/// Makes the device monitor a node that gives one sign of life, with which monitoring begins. Life guarding is
/// preferred, because some devices monitor heartbeats only after 1016h is stored.
pub(super) fn begin_monitoring(bench: &mut Bench<'_>) -> Result<Monitored, Stop> {
    bench.expect_emergencies();
    let monitored = if bench.can_be_guarded()? {
        // A device that sends heartbeats is not guarded.
        bench.prefer_guarding()?;
        bench.write(GUARD_TIME, &GUARD_MS.to_le_bytes())?;
        bench.write(LIFE_TIME_FACTOR, &[FACTOR])?;
        Monitored::Master
    } else {
        let Some(node) = bench.vacant_neighbour() else {
            let reason = Reason::new("a neighbouring node-ID is free", "one", "none");
            return Err(Stop::NotApplicable(reason));
        };
        bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
        Monitored::Node(node)
    };
    sign_of_life(bench, monitored)?;
    Ok(monitored)
}

pub(super) fn emergencies(bench: &mut Bench<'_>, span: Duration) -> Result<Vec<Record>, Stop> {
    let heard = bench.listen(span)?;
    Ok(of_device(bench, heard))
}

fn of_device(bench: &Bench<'_>, heard: Vec<Record>) -> Vec<Record> {
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    heard.into_iter().filter(|record| record.frame.cob_id() == Some(cob_id)).collect()
}

/// The EMCY messages that report an error.
pub(super) fn errors_of(bench: &Bench<'_>, heard: Vec<Record>) -> Vec<Record> {
    of_device(bench, heard).into_iter().filter(is_error).collect()
}

pub(super) fn shown(records: &[Record]) -> String {
    let shown: Vec<String> = records.iter().take(4).map(|record| Bytes(record.data()).to_string()).collect();
    if shown.is_empty() { "none".to_owned() } else { shown.join(", ") }
}

pub(super) fn code_of(record: &Record) -> Option<EmcyCode> {
    Emcy::read(record.frame.data()).ok().and_then(|emcy| emcy.code())
}

/// Whether an EMCY message reports an error, not only the end of an error.
pub(super) fn is_error(record: &Record) -> bool {
    !code_of(record).is_some_and(EmcyCode::is_reset)
}

/// Requires that no EMCY message reports a protocol error, 82xxh: the messages sent were correct.
fn no_protocol_error(duty: &'static str, heard: &[Record]) -> Check {
    let is_of_protocol = |record: &&Record| code_of(record).is_some_and(|code| code.0 >> 8 == 0x82);
    let reported = heard.iter().find(is_of_protocol);
    demand(reported.is_none(), || {
        let found = reported.and_then(code_of).map_or(Observation::Silence, Observation::Emcy);
        Breach::new(Service::Emcy, duty).expected("no EMCY 82xxh").found(found).told(shown(heard))
    })
}

/// Sends a correct message and requires that no EMCY message reports it as an error. Codes for protocol errors, 82xxh,
/// must not come at all. As some devices have generic codes only, a code 10xxh fails too if it comes with the message,
/// and again with the message after a reset, but not before. `prepare` returns the CAN-ID of the message and its data.
pub(super) fn expect_no_error<'b>(
    bench: &mut Bench<'b>,
    duty: &'static str,
    mut prepare: impl FnMut(&mut Bench<'b>) -> Result<(u16, Vec<u8>), Stop>,
) -> Judged {
    bench.expect_emergencies();
    let patience = patience(bench)?;
    for is_again in [false, true] {
        let (can_id, data) = prepare(bench)?;
        let before = emergencies(bench, patience)?;
        let mut heard = Vec::new();
        for _ in 0..3 {
            bench.send_bytes(can_id, &data)?;
            heard.extend(emergencies(bench, bench.shortly())?);
        }
        heard.extend(emergencies(bench, patience)?);
        bench.check(no_protocol_error(duty, &heard))?;
        let is_generic = |record: &Record| code_of(record).is_some_and(|code| code.0 >> 8 == 0x10);
        if before.iter().any(is_error) || !heard.iter().any(is_generic) {
            return Ok(());
        }
        if is_again {
            let breach = Breach::new(Service::Emcy, duty).expected("no EMCY").found(observed(&heard));
            return bench.check(Err(Box::new(breach.told(shown(&heard)))));
        }
        bench.reset(Command::RESET_COMMUNICATION)?;
    }
    Ok(())
}

/// The first EMCY message, or silence if there is none.
pub(super) fn observed(records: &[Record]) -> Observation {
    records.first().map_or(Observation::Silence, |record| {
        code_of(record).map_or(Observation::Frame(record.frame), Observation::Emcy)
    })
}

/// Whether an EMCY message can report a lost master or node: with the specific code (8130h, 8F00h + node), with a more
/// general code, as only 0000h and 1000h are mandatory, or with a code of the manufacturer.
pub(super) fn fits_loss(record: &Record, node: Option<u8>) -> bool {
    match code_of(record).map(|code| code.0.to_be_bytes()) {
        Some([0x80, 0x00] | [0x81, 0x00 | 0x30] | [0x10 | 0xFF, _]) => true,
        Some([0x8F, of]) => node == Some(of),
        _ => false,
    }
}

/// Maximum wait for an EMCY message whose cause has occurred: the inhibit time after the previous EMCY may still run.
pub(super) fn patience(bench: &mut Bench<'_>) -> Result<Duration, Stop> {
    let inhibit = match bench.upload(INHIBIT_TIME)?.outcome {
        Outcome::Uploaded(value) => crate::bench::sdo::number(&value).min(600_000),
        _ => 0,
    };
    Ok(bench.timing().silence + Duration::from_micros(100 * u64::from(inhibit)))
}

/// Makes the monitored node fall silent, and returns the following EMCY messages. If none reports an error, the case is
/// inconclusive: a device need not report this.
pub(super) fn reported_loss(bench: &mut Bench<'_>) -> Result<(Monitored, Vec<Record>), Stop> {
    let monitored = begin_monitoring(bench)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    if heard.iter().any(is_error) {
        return Ok((monitored, heard));
    }
    let found = shown(&heard);
    Err(Stop::Inconclusive(Reason::new("the loss of a master or node is reported", "an EMCY", found)))
}

/// The case only records whether the device reports the loss of its master or of a monitored node by EMCY 8130h or a
/// more general code: a device has to support no error codes except 0000h and 1000h.
#[case(id = "301/emcy/monitoring-lost", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Open,
       needs = [Monitoring], catches = [LifeGuardingUnreported, HeartbeatConsumerSilent], cct = "7.106")]
fn monitoring_lost(bench: &mut Bench<'_>) -> Judged {
    let monitored = begin_monitoring(bench)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    let node = match monitored {
        Monitored::Master => None,
        Monitored::Node(node) => Some(node),
    };
    bench.note(format!("the EMCY for a lost master or node: {}", shown(&heard)));
    bench.check(demand(heard.first().is_some_and(|first| fits_loss(first, node)), || {
        Breach::new(Service::Emcy, "the loss of a master or node is reported by a matching error code")
            .expected(Observation::Emcy(EmcyCode::HEARTBEAT))
            .found(observed(&heard))
            .told(shown(&heard))
    }))
}

/// The generic bit of the error register is set while an error is reported, however often the register is read.
#[case(id = "301/emcy/generic-bit", clause = "CiA 301 7.5.2.2", confidence = Cited, level = Must,
       needs = [Monitoring], catches = [ErrorRegisterGenericMissing])]
fn generic_bit(bench: &mut Bench<'_>) -> Judged {
    reported_loss(bench)?;
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    let bits = register.first().copied().unwrap_or_default();
    bench.check(demand(bits & ErrorRegister::GENERIC.0 != 0, || {
        let breach = Breach::new(ERROR_REGISTER, "the generic bit of 1001h is set in every error situation");
        breach.expected("bit 0").found(Observation::Value(register))
    }))
}

/// Reading the error register does not clear it: the second and third reading still show an error that persists.
#[case(id = "301/emcy/register-read", clause = "CiA 301 7.5.2.2", confidence = Cited, level = Must,
       needs = [Monitoring], catches = [ErrorRegisterReadClears])]
fn register_read(bench: &mut Bench<'_>) -> Judged {
    reported_loss(bench)?;
    tells_of_error(bench, "1001h shows the error").or_inconclusive()?;
    bench.each(["second", "third"], |bench, time| {
        tells_of_error(bench, &format!("1001h still shows a persistent error at the {time} reading"))
    })
}

fn tells_of_error(bench: &mut Bench<'_>, duty: &str) -> Judged {
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    bench.check(demand(register.iter().any(|&bits| bits != 0), || {
        let breach = Breach::new(ERROR_REGISTER, duty.to_owned());
        breach.expected("a bit that is set").found(Observation::Value(register))
    }))
}

/// When the lost master or node returns, the device sends EMCY 0000h, whose third byte is the error register with the
/// errors that remain.
#[case(id = "301/emcy/error-reset", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       needs = [Monitoring], catches = [EmcyResetMissing, EmcyResetRegisterWrong])]
fn error_reset(bench: &mut Bench<'_>) -> Judged {
    let patience = patience(bench)?;
    let before = bench.read_number(ERROR_REGISTER)?;
    let (monitored, _) = reported_loss(bench)?;
    match monitored {
        // EMCY and answer may come in any order.
        Monitored::Master => bench.ask_for_state()?,
        Monitored::Node(_) => sign_of_life(bench, monitored)?,
    }
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    let is_reset = |record: &Record| record.frame.cob_id() == Some(cob_id) && !is_error(record);
    let back = bench.wait_for(patience, |record| is_reset(record).then(|| record.clone()))?;
    let Some(back) = back else {
        return bench.check(Err(Box::new(
            Breach::new(Service::Emcy, "the end of a reported error is reported")
                .expected(Observation::Emcy(EmcyCode::NO_ERROR))
                .found(Observation::Silence),
        )));
    };
    // The register is read at once: a node that was heard only once is lost again. A device may keep a bit of the error
    // register until somebody acknowledges it.
    let register = bench.read_number(ERROR_REGISTER)?;
    let said = u32::from(back.data().get(2).copied().unwrap_or_default());
    bench.check(demand(said == register || said == before, || {
        Breach::new(Service::Emcy, "byte 2 of EMCY 0000h is 1001h")
            .expected(Observation::Number(u64::from(register)))
            .found(Observation::Number(u64::from(said)))
            .told(shown(&[back]))
    }))
}

/// A device in the NMT state stopped sends no EMCY: an EMCY that is triggered there stays pending. The device may send
/// the most recent one after it has left stopped.
#[case(id = "301/state/stopped/emcy", clause = "CiA 301 7.3.2.2.4", confidence = Cited, level = Must,
       needs = [Monitoring], catches = [EmcyWhenStopped])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    begin_monitoring(bench)?;
    bench.command(Command::STOP)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    bench.check(demand(heard.is_empty(), || {
        let breach = Breach::new(Service::Emcy, "no EMCY is sent in stopped").expected(Observation::Silence);
        breach.found(observed(&heard)).told(shown(&heard))
    }))?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    let afterwards = emergencies(bench, bench.timing().silence)?;
    let register = bench.read(ERROR_REGISTER)?;
    if heard.is_empty() && afterwards.is_empty() && register.iter().all(|&bits| bits == 0) {
        let reason =
            Reason::new("an error occurred in stopped", "an EMCY afterwards, or 1001h other than 0", "neither");
        return Err(Stop::Inconclusive(reason));
    }
    bench.note(format!("EMCY after stopped: {}", shown(&afterwards)));
    Ok(())
}

/// Writing another value than 0 to 1003h:00 is refused with abort 0609 0030h, whether the history has errors or not.
#[case(id = "301/error-history/not-zero", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Must,
       needs = [ErrorHistory], catches = [ErrorHistoryNonZeroAccepted], cct = "2.10")]
fn not_zero(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(ERROR_COUNT)?;
    bench.each([1_u8, 255], |bench, count| {
        let attempt = bench.download(ERROR_COUNT, &[count])?;
        bench.check(attempt.refused(Situation::HistoryNotZero))
    })?;
    bench.expect_unchanged(ERROR_COUNT, &before)
}

/// Writing 0 to 1003h:00 clears the error history.
#[case(id = "301/error-history/clear", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Must,
       needs = [Monitoring, ErrorHistory], catches = [ErrorHistoryNotCleared], cct = "2.10")]
fn clear(bench: &mut Bench<'_>) -> Judged {
    reported_loss(bench)?;
    let count = bench.read_number(ERROR_COUNT)?;
    demand(count > 0, || {
        let breach = Breach::new(ERROR_COUNT, "the reported error is in the history").expected("1 or more");
        breach.found(Observation::Number(u64::from(count)))
    })
    .or_inconclusive()?;
    bench.download(ERROR_COUNT, &[0])?.expect_confirmation()?;
    let count = bench.read_number(ERROR_COUNT)?;
    bench.check(demand(count == 0, || {
        let breach = Breach::new(ERROR_COUNT, "the history is empty after 0 was written");
        breach.expected(Observation::Number(0)).found(Observation::Number(u64::from(count)))
    }))
}
