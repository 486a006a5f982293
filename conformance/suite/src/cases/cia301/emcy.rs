//! EMCY, error register and error history. The error that nearly every device can be given is that of its error
//! control: the master that guards it, or a node that it watches, falls silent. The tester acts as both.

use super::heartbeat_consumer::entry;
use crate::bench::Bench;
use crate::bench::state::GUARD_TIME;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::Bytes;
use canvass_traces::{Duration, Record};

const LIFE_TIME_FACTOR: Multiplexer = Multiplexer::new(0x100D, 0);
const WATCHED: Multiplexer = Multiplexer::new(0x1016, 1);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(0x1001, 0);
const ERROR_COUNT: Multiplexer = Multiplexer::new(0x1003, 0);
/// Guard time times life time factor, or consumer time.
const GUARD_MS: u16 = 100;
const FACTOR: u8 = 2;
const CONSUMER_MS: u16 = 200;
/// Long enough for either of the two, its tolerance and an EMCY inhibit time.
const UNTIL_LOST: Duration = Duration::from_millis(600);

/// Who falls silent.
#[derive(Clone, Copy)]
pub(super) enum Monitored {
    /// The master, which guards the device.
    Master,
    /// A node whose heartbeats the device watches.
    Node(u8),
}

/// A sign of life from the one who is monitored.
pub(super) fn sign_of_life(bench: &mut Bench<'_>, monitored: Monitored) -> Result<(), Stop> {
    match monitored {
        Monitored::Master => bench.guard().map(|_| ()),
        Monitored::Node(node) => {
            let message = ErrorControl::heartbeat(State::OPERATIONAL);
            bench.send(&message.to_frame(error_control::CAN_ID_BASE + u16::from(node))).map(|_| ())
        }
    }
}

/// Lets the device monitor someone who gives one sign of life: monitoring begins with it. Life guarding is preferred:
/// some devices watch nodes only once that is stored.
pub(super) fn begin_monitoring(bench: &mut Bench<'_>) -> Result<Monitored, Stop> {
    bench.expect_emergencies();
    let monitored = if bench.can_be_guarded()? {
        bench.write(GUARD_TIME, &GUARD_MS.to_le_bytes())?;
        bench.write(LIFE_TIME_FACTOR, &[FACTOR])?;
        Monitored::Master
    } else {
        let Some(node) = bench.vacant_neighbour() else {
            let reason = Reason::new("a node-ID beside that of the device is free", "one", "none");
            return Err(Stop::NotApplicable(reason));
        };
        bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
        Monitored::Node(node)
    };
    sign_of_life(bench, monitored)?;
    Ok(monitored)
}

pub(super) fn emergencies(bench: &mut Bench<'_>, span: Duration) -> Result<Vec<Record>, Stop> {
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    let heard = bench.listen(span)?;
    Ok(heard.into_iter().filter(|record| record.frame.cob_id() == Some(cob_id)).collect())
}

pub(super) fn shown(records: &[Record]) -> String {
    let shown: Vec<String> = records.iter().take(4).map(|record| Bytes(record.data()).to_string()).collect();
    if shown.is_empty() { "none".to_owned() } else { shown.join(", ") }
}

pub(super) fn code_of(record: &Record) -> Option<EmcyCode> {
    Emcy::read(record.frame.data()).ok().and_then(|emcy| emcy.code())
}

/// A master or watched node that falls silent is reported by exactly one EMCY 8130h of eight bytes, with the error
/// register as it is then.
#[case(id = "301/emcy/monitoring-lost", clause = "CiA 301 7.2.7", confidence = Attested, level = Must,
       needs = [Monitoring], catches = [EmcyRepeated, ErrorRegisterMissing, EmcyRegisterZero, LifeGuardingUnreported, HeartbeatConsumerSilent], cct = "7.106")]
fn monitoring_lost(bench: &mut Bench<'_>) -> Judged {
    begin_monitoring(bench)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    let expected = || "one, 30 81 and six bytes more".to_owned();
    demand(
        heard.len() == 1 && heard.iter().all(|r| code_of(r) == Some(EmcyCode::HEARTBEAT) && r.data().len() == 8),
        || Reason::new("the loss is reported by one EMCY", expected(), shown(&heard)),
    )?;
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    let sent = heard.first().and_then(|record| record.data().get(2).copied());
    bench.check(demand(register.first().copied() == sent, || {
        Reason::new("byte 2 of the EMCY is 1001h", Bytes(&register).to_string(), shown(&heard))
    }))
}

/// In the error register the generic bit is set together with every other bit.
#[case(id = "301/emcy/generic-bit", clause = "CiA 301 7.5.2.2", confidence = Attested, level = Must,
       needs = [Monitoring], catches = [ErrorRegisterGenericMissing])]
fn generic_bit(bench: &mut Bench<'_>) -> Judged {
    begin_monitoring(bench)?;
    bench.listen(UNTIL_LOST)?;
    let register = ErrorRegister(bench.upload(ERROR_REGISTER)?.value()?.first().copied().unwrap_or_default());
    demand(register.0 != 0, || Reason::new("the loss shows in 1001h", "bits 0 and 4", register.to_string()))?;
    bench.check(demand(register.0 & ErrorRegister::GENERIC.0 != 0, || {
        Reason::new("the generic bit of 1001h is set with every other", "bit 0", register.to_string())
    }))
}

/// When the one who fell silent is back, EMCY 0000h says so.
#[case(id = "301/emcy/error-reset", clause = "CiA 301 7.2.7", confidence = Attested, level = Must,
       needs = [Monitoring], catches = [EmcyResetMissing])]
fn error_reset(bench: &mut Bench<'_>) -> Judged {
    let monitored = begin_monitoring(bench)?;
    let lost = emergencies(bench, UNTIL_LOST)?;
    demand(!lost.is_empty(), || Reason::new("the loss is reported", "an EMCY", "none")).or_inconclusive()?;
    match monitored {
        // EMCY and answer come in any order.
        Monitored::Master => bench.ask_for_state()?,
        Monitored::Node(_) => sign_of_life(bench, monitored)?,
    }
    let back = emergencies(bench, Duration::from_millis(100))?;
    bench.check(demand(back.iter().any(|record| code_of(record).is_some_and(EmcyCode::is_reset)), || {
        Reason::new("the end of an error is reported", "EMCY 0000h", shown(&back))
    }))
}

/// In stopped no EMCY is sent; the error history has the error all the same.
#[case(id = "301/state/stopped/emcy", clause = "CiA 301 7.3.2.2.5", confidence = Known, level = Must,
       needs = [Monitoring], catches = [EmcyWhenStopped])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    begin_monitoring(bench)?;
    bench.command(Command::STOP)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    demand(heard.is_empty(), || Reason::new("no EMCY is sent in stopped", "silence", shown(&heard)))?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    let register = bench.read(ERROR_REGISTER)?;
    demand(register.iter().any(|&bits| bits != 0), || {
        Reason::new("the error shows in 1001h after stopped", "bits 0 and 4", Bytes(&register).to_string())
    })
    .or_inconclusive()
}

/// Writing 0 to 1003h:00 clears the error history; any other value is refused with abort 0609 0030h.
#[case(id = "301/error-history/clear", clause = "CiA 301 7.5.2.4", confidence = Derived, level = Must,
       needs = [Monitoring, ErrorHistory], catches = [ErrorHistoryNotCleared, ErrorHistoryNonZeroAccepted], cct = "2.10")]
fn clear(bench: &mut Bench<'_>) -> Judged {
    begin_monitoring(bench)?;
    bench.listen(UNTIL_LOST)?;
    let count = bench.read_number(ERROR_COUNT)?;
    demand(count > 0, || Reason::new("the error is in the history", "1003h:00 of 1 or more", format!("{count}")))
        .or_inconclusive()?;
    let attempt = bench.download(ERROR_COUNT, &[1])?;
    let _verdict = bench.check(attempt.refused(Situation::InvalidValue))?;
    bench.download(ERROR_COUNT, &[0])?.expect_confirmation()?;
    let count = bench.read_number(ERROR_COUNT)?;
    demand(count == 0, || Reason::new("the history is empty after 0 was written", "0", format!("{count}")))?;
    Ok(())
}
