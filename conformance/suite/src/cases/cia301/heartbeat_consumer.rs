//! Heartbeat consumer (1016h).
//!
//! The loss of a node shows in the NMT state of the device: by default the device leaves operational (CiA 301,
//! 7.5.2.32). An EMCY is optional, as only the error codes 0000h and 1000h are mandatory (7.2.7.1).

use super::emcy::{emergencies, errors_of, fits_loss, is_error, observed, patience, shown};
use super::error_behaviour::after_a_loss;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Check, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{EmcyCode, ErrorRegister};
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record, Timestamp};

/// The object that stores all parameters.
const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
const WATCHED: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);
const CONSUMER_MS: u16 = 200;
pub(super) const CONSUMER_TIME: Duration = Duration::from_millis(200);
/// Period of the device's heartbeats, which show its state.
const SHOWN_EVERY: Duration = Duration::from_millis(50);

/// The value of an entry that monitors a node with this consumer time.
pub const fn entry(node: u8, milliseconds: u16) -> [u8; 4] {
    ((node as u32) << 16 | milliseconds as u32).to_le_bytes()
}

/// A second entry for a node that another entry already monitors is refused with abort 0604 0043h.
#[case(id = "301/heartbeat-consumer/duplicate", clause = "CiA 301 7.5.2.19", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerDoubleAccepted], cct = "7.104")]
fn duplicate(bench: &mut Bench<'_>) -> Judged {
    const SECOND: Multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 2);
    let node = neighbour(bench)?;
    if !bench.has(SECOND)? {
        let reason = Reason::new("two nodes can be monitored", "1016h:02", "the device has one entry");
        return Err(Stop::NotApplicable(reason));
    }
    bench.write(WATCHED, &entry(node, 500))?;
    let attempt = bench.download(SECOND, &entry(node, 1_000))?;
    bench.check(attempt.refused(Situation::DuplicateConsumer))
}

/// A node-ID that nobody uses, with which the tester sends heartbeats.
pub(super) fn neighbour(bench: &Bench<'_>) -> Result<u8, Stop> {
    bench
        .vacant_neighbour()
        .ok_or_else(|| Stop::NotApplicable(Reason::new("a neighbouring node-ID is free", "one", "none")))
}

/// A node that the operational device monitors, and the sign of its loss.
pub(super) struct Watch {
    pub node: u8,
    /// The state that the device enters after the loss; `None` if it does not show its state, or keeps it.
    enters: Option<State>,
}

/// The signs by which a device shows the loss of a node.
pub(super) struct Signs {
    /// EMCYs that report an error.
    errors: Vec<Record>,
    /// The first state other than operational, with its time.
    left: Option<(Timestamp, State)>,
}

impl Signs {
    fn any(&self) -> bool {
        !self.errors.is_empty() || self.left.is_some()
    }

    fn observation(&self) -> Observation {
        match self.left {
            Some((_, state)) if self.errors.is_empty() => Observation::State(state),
            _ => observed(&self.errors),
        }
    }

    /// Number of signs, for breaches that pauses of the tester itself may have caused.
    fn count(&self) -> Observation {
        Observation::Count(self.errors.len().max(usize::from(self.left.is_some())) as u64)
    }

    pub(super) fn text(&self) -> String {
        let state = self.left.map_or("operational".to_owned(), |(_, state)| state.to_string());
        format!("{state}, EMCY: {}", shown(&self.errors))
    }
}

/// Makes the device monitor a node-ID that nobody uses, and makes the device operational.
pub(super) fn watch(bench: &mut Bench<'_>) -> Result<Watch, Stop> {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    let enters = consequence(bench)?;
    bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
    operational(bench)?;
    Ok(Watch { node, enters })
}

pub(super) fn operational(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction).map(|_| ())
}

/// The state after the loss of a node; `None` if the device does not show it by heartbeats.
pub(super) fn consequence(bench: &mut Bench<'_>) -> Result<Option<State>, Stop> {
    if !bench.heartbeats()?.is_settable() {
        return Ok(None);
    }
    bench.show_state()?;
    after_a_loss(bench)
}

pub(super) fn beat(bench: &mut Bench<'_>, node: u8) -> Result<(), Stop> {
    let message = ErrorControl::heartbeat(State::OPERATIONAL);
    bench.send(&message.to_frame(error_control::CAN_ID_BASE + u16::from(node))).map(|_| ())
}

/// The signs within `span`.
pub(super) fn signs(bench: &mut Bench<'_>, span: Duration) -> Result<Signs, Stop> {
    let heard = bench.listen(span)?;
    Ok(signs_in(bench, heard))
}

/// The signs since `begun`, and within `span` from now on.
pub(super) fn signs_since(bench: &mut Bench<'_>, begun: Timestamp, span: Duration) -> Result<Signs, Stop> {
    bench.listen(span)?;
    let heard = bench.heard_since(begun);
    Ok(signs_in(bench, heard))
}

fn signs_in(bench: &Bench<'_>, heard: Vec<Record>) -> Signs {
    let states = heard.iter().filter(|record| bench.is_error_control(&record.frame));
    let states = states.filter_map(|record| Some((record.timestamp, ErrorControl::read(record.data()).ok()?.state)));
    let left = { states }.find(|(_, state)| *state != State::OPERATIONAL);
    Signs { errors: errors_of(bench, heard), left }
}

/// Requires a sign of the loss: the NMT state if the device shows it, otherwise an EMCY.
pub(super) fn noticed(at: Multiplexer, watch: &Watch, signs: &Signs) -> Judged {
    let Some(right) = watch.enters else {
        let reason = || {
            Reason::new(
                "the loss of a node is visible",
                "an EMCY, or heartbeats (1017h) that show the state",
                "neither",
            )
        };
        return if signs.errors.is_empty() { Err(Stop::Inconclusive(reason())) } else { Ok(()) };
    };
    let state = signs.left.map_or(State::OPERATIONAL, |(_, state)| state);
    demand(state == right, || {
        Breach::new(at, format!("an operational device that loses a monitored node becomes {right}"))
            .expected(Observation::State(right))
            .found(Observation::State(state))
            .told(signs.text())
    })?;
    Ok(())
}

/// Requires that there is no sign of a loss.
pub(super) fn unnoticed(at: Multiplexer, duty: impl Into<String>, signs: &Signs) -> Check {
    demand(!signs.any(), || {
        let breach =
            Breach::new(at, duty.into()).expected("no EMCY, and the state operational").found(signs.observation());
        breach.told(signs.text())
    })
}

/// Requires that there is no sign of a loss, like [`unnoticed`], in cases where a late tester would cause the loss
/// itself.
fn unnoticed_in_time(duty: &'static str, signs: &Signs) -> Check {
    demand(!signs.any(), || {
        let none = Allowed::Count { least: 0, most: Some(0) };
        Breach::new(WATCHED, duty).expected(none).found(signs.count()).told(signs.text())
    })
}

/// The device begins to monitor a node with its first heartbeat: it reports no loss before that heartbeat.
#[case(id = "301/heartbeat-consumer/first-heartbeat", clause = "CiA 301 7.5.2.19", confidence = Cited,
       level = Must, needs = [HeartbeatConsumer], catches = [HeartbeatConsumerStartsAtOnce])]
fn first_heartbeat(bench: &mut Bench<'_>) -> Judged {
    let begun = bench.now();
    watch(bench)?;
    // A slow device may have missed the node before it answered.
    let early = bench.heard_since(begun);
    let mut signs = signs(bench, CONSUMER_TIME.times(5))?;
    signs.errors.splice(0..0, errors_of(bench, early));
    bench.check(unnoticed(WATCHED, "a node that has sent no heartbeat is not reported as lost", &signs))
}

/// The device reports no loss of a monitored node whose heartbeats arrive in time.
#[case(id = "301/heartbeat-consumer/kept-alive", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited,
       level = Must, needs = [HeartbeatConsumer], catches = [HeartbeatConsumerNotRestarted], cct = "7.105")]
fn kept_alive(bench: &mut Bench<'_>) -> Judged {
    let Watch { node, .. } = watch(bench)?;
    let mut all = Signs { errors: Vec::new(), left: None };
    for _ in 0..20 {
        beat(bench, node)?;
        let Signs { errors, left } = signs(bench, Duration::from_millis(100))?;
        all.errors.extend(errors);
        all.left = all.left.or(left);
    }
    bench.check(unnoticed_in_time(
        "a node that sends a heartbeat every 100 ms is not reported as lost after 200 ms",
        &all,
    ))
}

/// The device detects the loss of a monitored node after the consumer heartbeat time, and leaves operational unless
/// 1029h:01 demands otherwise. If it reports the loss by EMCY, it sends one EMCY, and the error register shows an
/// error.
#[case(id = "301/heartbeat-consumer/lost", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerLate, EmcyRepeated, ErrorRegisterMissing, ErrorRegisterGenericMissing, ErrorBehaviourIgnored, ConsumerTimeRefused],
       cct = "7.106")]
fn lost(bench: &mut Bench<'_>) -> Judged {
    // Only this case judges whether the device accepts a valid entry; all other cases need a device that does.
    if bench.can_write(WATCHED)? {
        let node = neighbour(bench)?;
        bench.download(WATCHED, &entry(node, CONSUMER_MS))?.expect_confirmation()?;
    }
    let watch = watch(bench)?;
    beat(bench, watch.node)?;
    let sent = bench.now();
    let signs = signs(bench, CONSUMER_TIME.times(4))?;
    noticed(WATCHED, &watch, &signs)?;
    bench.check(in_time(&signs, sent))?;
    bench.check(reported_once(&watch, &signs))?;
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    let bits = register.first().copied().unwrap_or_default();
    let shows = signs.errors.is_empty() || bits & ErrorRegister::GENERIC.0 != 0;
    bench.check(demand(shows, || {
        let breach = Breach::new(ERROR_REGISTER, "the generic bit of 1001h is set while an error is reported");
        breach.expected("bit 0").found(Observation::Value(register))
    }))
}

/// A stored entry of 1016h monitors its node after the next start, in the same way as an entry that was just written.
#[case(id = "301/heartbeat-consumer/stored", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer, Store], touches = [Nvm], catches = [HeartbeatConsumerForgetsStored])]
fn stored(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    let before = bench.read(WATCHED)?;
    bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
    bench.write(STORE, b"save")?;
    bench.note("1010h was written twice: the device's non-volatile memory has done two more cycles");
    let judged = stored_is_watched(bench, node);
    // The device gets its old values back, whether the check passed or not.
    bench.download(WATCHED, &before)?;
    bench.write(STORE, b"save")?;
    judged
}

fn stored_is_watched(bench: &mut Bench<'_>, node: u8) -> Judged {
    bench.reset(Command::RESET_NODE)?;
    if bench.read(WATCHED)? != entry(node, CONSUMER_MS) {
        return Err(Stop::NotApplicable(Reason::new(
            "1010h stores 1016h",
            "the entry that was written",
            "another one",
        )));
    }
    let enters = consequence(bench)?;
    operational(bench)?;
    let watch = Watch { node, enters };
    beat(bench, node)?;
    let signs = signs(bench, CONSUMER_TIME.times(4))?;
    noticed(WATCHED, &watch, &signs)
}

fn in_time(signs: &Signs, sent: Timestamp) -> Check {
    let by_emcy = signs.errors.iter().map(|record| record.timestamp);
    let first = by_emcy.chain(signs.left.map(|(at, _)| at)).min();
    let after = first.map_or(Duration::ZERO, |first| first.since(sent));
    let least = Duration::from_nanos(CONSUMER_TIME.nanos() / 10 * 9);
    // A state shows only with the next heartbeat.
    let most = Duration::from_nanos(CONSUMER_TIME.nanos() / 2 * 3) + SHOWN_EVERY;
    demand((least..=most).contains(&after), || {
        Breach::new(WATCHED, format!("the loss of a node is detected after {CONSUMER_TIME}"))
            .expected(Allowed::Time { least, most })
            .found(Observation::Time(after))
    })
}

fn reported_once(watch: &Watch, signs: &Signs) -> Check {
    demand(signs.errors.len() < 2, || {
        let at_most_one = Allowed::Count { least: 0, most: Some(1) };
        let found = Observation::Count(signs.errors.len() as u64);
        Breach::new(WATCHED, "the loss of a node is reported once").expected(at_most_one).found(found)
    })?;
    let wrong = signs.errors.iter().find(|record| !fits_loss(record, Some(watch.node)));
    demand(wrong.is_none(), || {
        let expected =
            Allowed::OneOf(vec![Observation::Emcy(EmcyCode::HEARTBEAT), Observation::Emcy(EmcyCode::GENERIC)]);
        let breach = Breach::new(WATCHED, "the EMCY for a lost node has a matching error code").expected(expected);
        breach.found(observed(&signs.errors)).told(shown(&signs.errors))
    })
}

/// The device monitors a node again when it has returned. If the device reported the loss by EMCY, it reports the
/// return by EMCY 0000h.
#[case(id = "301/heartbeat-consumer/back", clause = "CiA 301 7.2.8.2.2.3", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerNotRearmed, EmcyResetMissing])]
fn back(bench: &mut Bench<'_>) -> Judged {
    let watch = watch(bench)?;
    let patience = patience(bench)?;
    for is_first in [true, false] {
        beat(bench, watch.node)?;
        let lost = signs(bench, CONSUMER_TIME.times(3))?;
        match noticed(WATCHED, &watch, &lost) {
            Err(Stop::Inconclusive(_)) if !is_first => {
                let breach = Breach::new(WATCHED, "a second loss of a node is reported like the first");
                return bench.check(Err(Box::new(breach.expected("an EMCY").found(Observation::Silence))));
            }
            judged => judged?,
        }
        beat(bench, watch.node)?;
        let heard = emergencies(bench, patience)?;
        let is_told = lost.errors.is_empty() || heard.iter().any(|record| !is_error(record));
        bench.check(demand(is_told, || {
            let expected = Observation::Emcy(EmcyCode::NO_ERROR);
            let breach = Breach::new(WATCHED, "the return of a node whose loss was reported is reported");
            breach.expected(expected).found(observed(&heard)).told(shown(&heard))
        }))?;
        operational(bench)?;
    }
    Ok(())
}

/// The return of a lost node is no error: a device that its master has started again stays operational.
#[case(id = "301/heartbeat-consumer/return", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [ConsumerReturnLeaves])]
fn return_is_no_error(bench: &mut Bench<'_>) -> Judged {
    let watch = watch(bench)?;
    let Some(lost_in) = watch.enters else {
        let reason =
            Reason::new("the device shows its state", "heartbeats, and a state that follows a loss", "neither");
        return Err(Stop::NotApplicable(reason));
    };
    beat(bench, watch.node)?;
    let lost = signs(bench, CONSUMER_TIME.times(3))?;
    if lost.left.is_none_or(|(_, state)| state != lost_in) {
        let reason = Reason::new("the loss of a node changes the NMT state", lost_in.to_string(), lost.text());
        return Err(Stop::NotApplicable(reason));
    }
    operational(bench)?;
    let before = signs(bench, SHOWN_EVERY.times(2))?;
    demand(before.left.is_none(), || {
        let breach = Breach::new(WATCHED, "a device that has lost a node can be made operational");
        breach.expected(Observation::State(State::OPERATIONAL)).found(Observation::State(lost_in))
    })
    .or_inconclusive()?;
    let mut left = None;
    for _ in 0..4 {
        beat(bench, watch.node)?;
        left = left.or(signs(bench, SHOWN_EVERY.times(2))?.left);
    }
    bench.check(demand(left.is_none(), || {
        let found = left.map_or(State::OPERATIONAL, |(_, state)| state);
        let breach = Breach::new(WATCHED, "an operational device stays operational when a lost node returns");
        breach.expected(Observation::State(State::OPERATIONAL)).found(Observation::State(found))
    }))
}

/// Every entry of 1016h monitors its node, including the lowest and the highest node-ID.
#[case(id = "301/heartbeat-consumer/all-entries", clause = "CiA 301 7.5.2.19", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerFirstOnly, HeartbeatConsumerDeafToNodeOne])]
fn all_entries(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let enters = consequence(bench)?;
    let entries =
        u8::try_from(bench.read_number(Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 0))?).unwrap_or(1).min(127);
    bench.each(1..=entries, |bench, sub| {
        let at = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, sub);
        let own = bench.node().raw();
        // Node-IDs from both ends in turn: 127, 1, 126, 2, and so on.
        let ends = (1..=64).flat_map(|n| [128 - n, n]).filter(|&node| node != own && bench.is_vacant(node));
        let Some(node) = { ends }.nth(usize::from(sub) - 1) else { return Ok(()) };
        let watch = Watch { node, enters };
        bench.write(at, &entry(node, CONSUMER_MS))?;
        operational(bench)?;
        beat(bench, node)?;
        let signs = signs(bench, CONSUMER_TIME.times(3))?;
        bench.command(Command::ENTER_PRE_OPERATIONAL)?;
        bench.listen(bench.timing().reaction)?;
        bench.write(at, &entry(0, 0))?;
        noticed(at, &watch, &signs)
    })
}

/// The entries of 1016h monitor several nodes at the same time, and the time of an entry in use can be changed: the
/// device confirms each write, and the entry reads back as written.
#[case(id = "301/heartbeat-consumer/several", clause = "CiA 301 7.5.2.19", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [ConsumerEntriesExclude])]
fn several(bench: &mut Bench<'_>) -> Judged {
    let entries =
        u8::try_from(bench.read_number(Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 0))?).unwrap_or(1).min(127);
    let own = bench.node().raw();
    let vacant: Vec<u8> = (1..=127).rev().filter(|&node| node != own && bench.is_vacant(node)).collect();
    // All entries are erased first: a delivered entry for one of these nodes would be a second entry for the same node.
    for sub in 1..=entries {
        bench.write(Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, sub), &entry(0, 0))?;
    }
    bench.each((1..=entries).zip(vacant), |bench, (sub, node)| {
        let at = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, sub);
        bench.each([5_000_u16, 60_000], |bench, time| {
            let value = entry(node, time);
            bench
                .download(at, &value)?
                .under("while other entries monitor other nodes")
                .refused(Situation::Confirmed)?;
            bench.expect_unchanged(at, &value)
        })
    })
}

/// An entry whose time is 0 monitors no node.
#[case(id = "301/heartbeat-consumer/off", clause = "CiA 301 7.5.2.19", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerNotStopped])]
fn off(bench: &mut Bench<'_>) -> Judged {
    /// Longer than a slow server takes to confirm the write.
    const LONG_MS: u16 = 2_500;
    let Watch { node, .. } = watch(bench)?;
    bench.write(WATCHED, &entry(node, LONG_MS))?;
    beat(bench, node)?;
    bench.write(WATCHED, &entry(node, 0))?;
    let signs = signs(bench, Duration::from_millis(u64::from(LONG_MS) * 3 / 2))?;
    bench.check(unnoticed_in_time("a node that is no longer monitored is not reported as lost", &signs))
}

/// Writing 1016h:00, the number of entries, is refused with abort 0601 0002h.
#[case(id = "301/heartbeat-consumer/count", clause = "CiA 301 7.5.2.19", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [SdoReadOnlyWritable, SdoReadOnlyWrongCode], cct = "4.3")]
fn count(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 0);
    let before = bench.upload(multiplexer)?.value()?;
    bench.check(demand(matches!(before.as_slice(), [1..=127]), || {
        let breach = Breach::new(multiplexer, "1016h:00 counts the entries").expected("one byte, 1 to 127");
        breach.found(Observation::Value(before.clone()))
    }))?;
    let attempt = bench.download(multiplexer, &[1])?;
    bench.check(attempt.refused(Situation::ReadOnly))?;
    bench.expect_unchanged(multiplexer, &before)
}

/// An entry for a node-ID that does not exist, 0 or 128 to 255, monitors no node. The standard names no abort code for a
/// device that refuses the entry.
#[case(id = "301/heartbeat-consumer/no-node", clause = "CiA 301 7.5.2.19", confidence = Cited, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerWatchesEveryone, HeartbeatConsumerHangs])]
fn no_node(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    let is_shown = consequence(bench)?.is_some();
    bench.each([0_u8, 128, 255], |bench, unused| {
        bench.command(Command::ENTER_PRE_OPERATIONAL)?;
        bench.listen(bench.timing().reaction)?;
        // Some devices accept another node only after the entry was erased.
        bench.write(WATCHED, &entry(0, 0))?;
        let attempt = bench.download(WATCHED, &entry(unused, CONSUMER_MS))?;
        if let Some(code) = attempt.abort() {
            bench.note(format!("an entry for node-ID {unused} is refused with abort {code}"));
            return Ok(());
        }
        attempt.expect_confirmation()?;
        operational(bench)?;
        if is_shown {
            // A heartbeat with the state before the start may come late.
            bench.require_state(State::OPERATIONAL)?;
        }
        beat(bench, node)?;
        let signs = signs(bench, CONSUMER_TIME.times(3))?;
        bench.check(unnoticed(WATCHED, format!("an entry for node-ID {unused} monitors no node"), &signs))
    })
}

/// Heartbeats of a monitored node that have a wrong length or bit 7 set do not disturb the device, and neither does the
/// boot-up message of that node. The case notes whether such messages count as a sign of life, because CiA 301 does not
/// say.
#[case(id = "301/heartbeat-consumer/malformed", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Should,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerCrashes])]
fn malformed(bench: &mut Bench<'_>) -> Judged {
    let Watch { node, .. } = watch(bench)?;
    let cob_id = error_control::CAN_ID_BASE + u16::from(node);
    let messages: [(&str, &[u8]); 4] =
        [("of no byte", &[]), ("of two bytes", &[5, 0]), ("with bit 7", &[0x85]), ("of a boot-up", &[0])];
    bench.each(messages, |bench, (what, data)| {
        beat(bench, node)?;
        let mut missed = false;
        for _ in 0..4 {
            missed |= signs(bench, Duration::from_millis(100))?.any();
            bench.send_bytes(cob_id, data)?;
        }
        bench.note(format!("a heartbeat {what} {}", if missed { "does not count" } else { "counts" }));
        let served = bench.upload(ERROR_REGISTER)?.value().map(|_| ());
        bench.check(served)?;
        operational(bench)
    })
}
