//! TPDOs: events, SYNC and remote frames (CiA 301, 7.2.2).

use crate::bench::objects::{TPDO_COB_ID, TPDO_FIRST_ENTRY, TPDO_MAPPED};
use crate::bench::pdo::TPDO;
use crate::bench::{Bench, percentile};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::Request;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::Observation;
use canvass_traces::{CanId, Duration, Frame, Record};

/// The highest SYNC counter.
const OVERFLOW: Multiplexer = Multiplexer::new(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0);
const SHORTLY: Duration = Duration::from_millis(100);
/// The objects with which the mapping of TPDO 1 is changed.
const MAPPING: [Multiplexer; 3] = [TPDO_COB_ID, TPDO_MAPPED, TPDO_FIRST_ENTRY];

/// TPDO 1 with one object that SDO can write.
pub(super) struct Subject {
    pub at: Multiplexer,
    pub can_id: u16,
    pub values: [Vec<u8>; 2],
}

/// Maps a changeable object in TPDO 1 and sets its transmission type, without event timer and inhibit time.
pub(super) fn subject(bench: &mut Bench<'_>, transmission_type: u8) -> Result<Subject, Stop> {
    let (mapped, other) = bench.changeable()?;
    let before = bench.read(mapped.at)?;
    bench.write(mapped.at, &before)?;
    if transmission_type <= 252 {
        bench.expect_plain_sync()?;
    }
    bench.set_mapping(TPDO, &[mapped])?;
    let none = 0_u16.to_le_bytes();
    bench.set_pdo(TPDO, &[(3, &none), (5, &none), (2, &[transmission_type])])?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    Ok(Subject { at: mapped.at, can_id, values: [before, other] })
}

/// Prepares TPDO 1 for counting: sets its transmission type, without event timer and inhibit time, and returns its
/// CAN-ID. TPDO 1 carries an object that changes only by SDO if there is one, else what it carries as delivered.
fn countable(bench: &mut Bench<'_>, transmission_type: u8) -> Result<u16, Stop> {
    if bench.can_write_all(&MAPPING)?.is_ok() && bench.changeable_object().is_some() {
        return Ok(subject(bench, transmission_type)?.can_id);
    }
    bench.require_mapped(TPDO)?;
    if let Err(why) = bench.can_write_all(&[TPDO_COB_ID, TPDO.parameter(2)])? {
        return Err(Stop::NotApplicable(Reason::new("the transmission type of TPDO 1 can be set", "1800h", why)));
    }
    if transmission_type <= 252 {
        bench.expect_plain_sync()?;
    }
    let none = 0_u16.to_le_bytes();
    bench.set_pdo(TPDO, &[(3, &none), (5, &none), (2, &[transmission_type])])?;
    Ok((bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16)
}

/// The breach of a wrong number of TPDOs: fewer than `least`, or more than `most`.
fn counted(duty: impl Into<String>, least: u64, most: Option<u64>, found: usize) -> Breach {
    let expected = Allowed::Count { least, most };
    Breach::new(TPDO.subject(), duty.into()).expected(expected).found(Observation::Count(found as u64))
}

pub(super) fn operational(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.command(Command::START)?;
    bench.listen(SHORTLY).map(|_| ())
}

fn sync(bench: &mut Bench<'_>, can_id: u16) -> Result<Vec<Record>, Stop> {
    let id = bench.sync_id()?;
    bench.drain()?;
    bench.send_bytes(id, &[])?;
    bench.frames_of(can_id, bench.shortly())
}

fn remote(bench: &mut Bench<'_>, can_id: u16) -> Result<Vec<Record>, Stop> {
    bench.drain()?;
    if let Some(request) = Frame::remote(CanId::standard_masked(u32::from(can_id)), 8) {
        bench.send(&request)?;
    }
    let heard = bench.frames_of(can_id, SHORTLY.max(bench.shortly()))?;
    Ok(heard.into_iter().filter(|record| !record.frame.is_remote()).collect())
}

/// The case only records whether the device sends a TPDO of transmission type 0 at the SYNC after an SDO download has
/// changed its value, and at no other SYNC. The application decides which events trigger a TPDO.
#[case(id = "301/tpdo/acyclic", clause = "CiA 301 7.2.2.2", confidence = Cited, level = Open,
       needs = [Changeable, Sync], catches = [AcyclicTpdoWithoutEvent], cct = "3.7")]
fn acyclic(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 0)?;
    operational(bench)?;
    // Entering operational may count as an event.
    sync(bench, subject.can_id)?;
    let without = sync(bench, subject.can_id)?.len() + sync(bench, subject.can_id)?.len();
    bench.check(demand(without == 0, || {
        counted("without a change SYNC causes no TPDO of type 0", 0, Some(0), without)
    }))?;
    bench.write(subject.at, &subject.values[1])?;
    let after = sync(bench, subject.can_id)?.len();
    let then = sync(bench, subject.can_id)?.len();
    bench.check(demand(after == 1, || {
        counted("a change causes one TPDO of type 0 with the next SYNC", 1, Some(1), after)
    }))?;
    bench.check(demand(then == 0, || {
        counted("a change causes no second TPDO of type 0 with the SYNC after that", 0, Some(0), then)
    }))
}

/// A TPDO of transmission type 1 follows each SYNC before the next SYNC. The case reports median and maximum of the
/// delay.
#[case(id = "301/tpdo/sync-latency", clause = "CiA 301 7.2.2.2", confidence = Cited, level = Must,
       needs = [Tpdo, Sync], catches = [SyncOverlooked], cct = "3.6")]
fn sync_latency(bench: &mut Bench<'_>) -> Judged {
    let mut delays = sync_delays(bench)?;
    for (name, percent) in [("median", 50), ("95 %", 95), ("maximum", 100)] {
        if let Some(delay) = percentile(&mut delays, percent) {
            bench.measure(format!("SYNC to TPDO, {name}"), delay);
        }
    }
    bench.check(demand(delays.len() == SYNCS, || {
        let duty = format!("each of {SYNCS} SYNCs, {SYNC_PATIENCE} apart at most, is followed by a TPDO of type 1");
        counted(duty, SYNCS as u64, Some(SYNCS as u64), delays.len())
    }))
}

/// The case only records whether a synchronous TPDO follows SYNC within 20 ms, or within the window of 1007h if it is
/// set. CiA 301 sets no limit without 1007h; with 1007h a device may discard a TPDO after the window, but does not have
/// to.
#[case(id = "301/tpdo/sync-delay", clause = "CiA 301 7.2.2.2", confidence = Cited, level = Open,
       needs = [Tpdo, Sync], catches = [SyncTpdoLate])]
fn sync_delay(bench: &mut Bench<'_>) -> Judged {
    const USUAL: Duration = Duration::from_millis(20);
    const WINDOW: Multiplexer = Multiplexer::new(object::SYNCHRONOUS_WINDOW_LENGTH, 0);
    let window = if bench.has(WINDOW)? { bench.read_number(WINDOW)? } else { 0 };
    let limit = if window == 0 { USUAL } else { Duration::from_micros(window.into()) };
    // SYNC itself, a frame on the wire, and the TPDO.
    let most = limit + bench.bus_delay() + bench.bus_delay();
    let latest = sync_delays(bench)?.into_iter().max().unwrap_or(Duration::ZERO);
    bench.check(demand(latest <= most, || {
        Breach::new(TPDO.subject(), "a TPDO of type 1 follows SYNC at once")
            .expected(Allowed::Time { least: Duration::ZERO, most })
            .found(Observation::Time(latest))
    }))
}

const SYNCS: usize = 50;
/// Maximum wait for a synchronous TPDO: the standard limits its delay only by the next SYNC.
const SYNC_PATIENCE: Duration = Duration::from_millis(500);

/// For several SYNC messages, the time from each to the following TPDO of type 1, if there is one.
fn sync_delays(bench: &mut Bench<'_>) -> Result<Vec<Duration>, Stop> {
    let can_id = countable(bench, 1)?;
    let id = bench.sync_id()?;
    operational(bench)?;
    let mut delays = Vec::with_capacity(SYNCS);
    for _ in 0..SYNCS {
        bench.drain()?;
        let handed_over = bench.now();
        bench.send_bytes(id, &[])?;
        let came = bench.wait_for(SYNC_PATIENCE, |record| {
            let is_it = record.frame.cob_id() == Some(can_id) && !record.frame.is_remote();
            is_it.then_some(record.timestamp)
        })?;
        // The delay of the tester's machine until SYNC is on the bus is not the device's.
        let sent = bench.evidence().sent(id).unwrap_or(handed_over);
        delays.extend(came.map(|came| came.since(sent)));
        // SYNC producers are rarely faster.
        bench.listen(Duration::from_millis(10))?;
    }
    Ok(delays)
}

/// A TPDO carries the number of objects in sub-index 0 of its mapping, even if further mapping entries are set.
#[case(id = "301/tpdo/mapping/beyond-count", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Changeable, Sync], catches = [TpdoBeyondCount])]
fn beyond_count(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 1)?;
    let mapped = bench.tpdo_objects().into_iter().find(|mapped| mapped.at != subject.at && mapped.bits % 8 == 0);
    let Some(further) = mapped else {
        return Err(Stop::NotApplicable(Reason::new("a second object can be mapped", "one", "none")));
    };
    let cob_id = bench.open_mapping(TPDO)?;
    bench.write(TPDO.entry(2), &further.entry().to_le_bytes())?;
    bench.write(TPDO.entry(0), &[1])?;
    bench.pdo_on(TPDO, cob_id)?;
    operational(bench)?;
    let heard = sync(bench, subject.can_id)?;
    let [first, ..] = &heard[..] else {
        return Err(Stop::Inconclusive(Reason::new("a TPDO of type 1 follows SYNC", "one", "none")));
    };
    let [right, found] = [subject.values[0].len(), first.data().len()].map(|bytes| bytes as u64);
    bench.check(demand(found == right, || {
        let duty =
            "a TPDO whose mapping counts one entry has the bytes of that entry only, although the second one is set";
        Breach::new(TPDO.subject(), duty).expected(Observation::Number(right)).found(Observation::Number(found))
    }))
}

/// The SYNC count of a TPDO of transmission type n starts again when the device becomes operational: each time the same
/// one of the first n SYNCs triggers the TPDO. The device decides which of them it is.
#[case(id = "301/tpdo/sync-count-restarts", clause = "CiA 301 7.3.2.2.3", confidence = Cited, level = Should,
       needs = [Tpdo, Sync], catches = [SyncCountNotReset, NmtEnterPreOperationalIgnored])]
fn sync_count_restarts(bench: &mut Bench<'_>) -> Judged {
    let can_id = countable(bench, 3)?;
    operational(bench)?;
    let first = cycle(bench, can_id)?;
    // Two SYNCs of the next cycle are sent.
    sync(bench, can_id)?;
    sync(bench, can_id)?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(SHORTLY)?;
    operational(bench)?;
    let second = cycle(bench, can_id)?;
    for heard in [first, second] {
        let found = heard.iter().sum();
        bench.check(demand(found == 1, || {
            let duty = "with type 3 one of the first three SYNCs after the start causes a TPDO";
            counted(duty, 1, Some(1), found).told(format!("{heard:?}"))
        }))?;
    }
    bench.check(demand(first == second, || {
        let place = |heard: [usize; 3]| heard.iter().position(|&found| found > 0).map_or(0, |at| at as u64 + 1);
        Breach::new(TPDO.subject(), "with type 3 the same SYNC causes the first TPDO after each start")
            .expected(Observation::Number(place(first)))
            .found(Observation::Number(place(second)))
            .told(format!("{second:?} after {first:?}"))
    }))
}

/// Number of TPDOs after each of three SYNCs.
fn cycle(bench: &mut Bench<'_>, can_id: u16) -> Result<[usize; 3], Stop> {
    Ok([sync(bench, can_id)?.len(), sync(bench, can_id)?.len(), sync(bench, can_id)?.len()])
}

/// The case only records whether an SDO download that changes the value of an event-driven TPDO triggers it at once.
/// The application decides which events trigger a TPDO.
#[case(id = "301/tpdo/change", clause = "CiA 301 7.2.2.3", confidence = Cited, level = Open,
       needs = [Changeable], catches = [TpdoLostAfterSdo], cct = "3.4")]
fn change(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 254)?;
    operational(bench)?;
    bench.drain()?;
    // The TPDO may be faster than the confirmation.
    bench.send_request(&Request::download(subject.at, &subject.values[1]))?;
    let heard = bench.frames_of(subject.can_id, SHORTLY)?;
    bench.check(demand(heard.iter().any(|record| record.data() == subject.values[1]), || {
        let found = heard.last().map_or(Observation::Silence, |record| Observation::Value(record.data().to_vec()));
        let breach = Breach::new(TPDO.subject(), format!("a change of {} sends TPDO 1 within {SHORTLY}", subject.at));
        breach.expected(Observation::Value(subject.values[1].clone())).found(found)
    }))
}

/// The case only records whether the device sends event-driven TPDOs once when it becomes operational. Annex A of CiA
/// 301 allows this.
#[case(id = "301/tpdo/at-start", clause = "CiA 301 annex A", confidence = Cited, level = Open,
       needs = [Changeable], catches = [TpdoNotSentAtStart])]
fn at_start(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 254)?;
    bench.drain()?;
    bench.command(Command::START)?;
    let heard = bench.frames_of(subject.can_id, SHORTLY)?;
    bench.check(demand(!heard.is_empty(), || {
        counted("an event-driven TPDO is sent when the device becomes operational", 1, None, 0)
    }))
}

/// The mean period of a TPDO with an event timer of 20 ms is 20 ms, or its inhibit time if that is longer: not one
/// timer tick more.
#[case(id = "301/tpdo/event-timer-mean", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer], catches = [EventTimerOffByOne, EventTimerDoubled])]
fn event_timer_mean(bench: &mut Bench<'_>) -> Judged {
    const TIMER: Duration = Duration::from_millis(20);
    const PERIODS: u64 = 50;
    bench.require_mapped(TPDO)?;
    let transmission_type = bench.read_number(TPDO.parameter(2))?;
    if transmission_type < 254 {
        bench.set_pdo(TPDO, &[(2, &[255])])?;
    }
    bench.set_event_timer(TPDO, 20)?;
    let period = TIMER.max(bench.pdo_inhibit_time(TPDO)?);
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    operational(bench)?;
    let heard = bench.frames_of(can_id, period.times(PERIODS))?;
    let span = heard.first().zip(heard.last()).map(|(first, last)| last.timestamp.since(first.timestamp));
    let gaps = u64::try_from(heard.len().saturating_sub(1)).unwrap_or(0);
    let duty = format!("with an event timer of 20 ms TPDO 1 comes every {period} on average");
    bench.check(demand(gaps > 0, || counted(duty.clone(), 2, None, heard.len())))?;
    let Some(span) = span.filter(|_| gaps > 0) else { return Ok(()) };
    let mean = Duration::from_nanos(span.nanos() / gaps);
    bench.measure("TPDO period with an event timer of 20 ms", mean);
    // Over this many periods the ticks of a timer average out; value changes make the mean shorter, never longer.
    let most = Duration::from_nanos(period.nanos() / 100 * 104 + bench.bus_delay().nanos() / PERIODS);
    bench.check(demand(mean <= most, || {
        Breach::new(TPDO.parameter(5), duty)
            .expected(Allowed::Time { least: Duration::ZERO, most })
            .found(Observation::Time(mean))
            .over(gaps)
    }))
}

/// The inhibit time has a unit of 100 microseconds: with a value of 1000 a TPDO may be sent every 100 ms.
#[case(id = "301/tpdo/inhibit-unit", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer, DynamicMapping], catches = [InhibitTimeInMilliseconds])]
fn inhibit_unit(bench: &mut Bench<'_>) -> Judged {
    bench.set_pdo(TPDO, &[(2, &[255]), (3, &1_000_u16.to_le_bytes()), (5, &50_u16.to_le_bytes())])?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    operational(bench)?;
    let heard = bench.frames_of(can_id, Duration::from_millis(1_050))?;
    bench.check(demand((8..=11).contains(&heard.len()), || {
        let duty =
            "with an inhibit time of 1000 (100 ms) and a shorter event timer TPDO 1 comes every 100 ms, in 1.05 s";
        counted(duty, 8, Some(11), heard.len())
    }))
}

/// A remote frame triggers a TPDO of transmission type 253.
#[case(id = "301/tpdo/remote-triggered", clause = "CiA 301 7.2.2.3", confidence = Cited, level = Should,
       needs = [Changeable], catches = [TpdoRemoteIgnored], cct = "3.3",
       answers = [InvalidValue])]
fn on_remote(bench: &mut Bench<'_>) -> Judged {
    let subject = remote_subject(bench, 253)?;
    operational(bench)?;
    let heard = remote(bench, subject.can_id)?;
    bench.check(demand(heard.len() == 1, || {
        counted("a remote frame is answered by TPDO 1 of type 253", 1, Some(1), heard.len())
    }))
}

/// A remote frame triggers a TPDO of transmission type 252, which carries the values at the last SYNC.
#[case(id = "301/tpdo/remote-sampled", clause = "CiA 301 7.2.2.3", confidence = Cited, level = Should,
       needs = [Changeable, Sync], catches = [RtrTypeSampledAtOnce],
       answers = [InvalidValue])]
fn remote_sampled(bench: &mut Bench<'_>) -> Judged {
    let subject = remote_subject(bench, 252)?;
    operational(bench)?;
    sync(bench, subject.can_id)?;
    bench.write(subject.at, &subject.values[1])?;
    let heard = remote(bench, subject.can_id)?;
    let found = heard.first().map_or(Observation::Silence, |answer| Observation::Value(answer.data().to_vec()));
    let right = Observation::Value(subject.values[0].clone());
    bench.check(demand(found == right, || {
        let duty =
            "a remote frame is answered by TPDO 1 of type 252 with the value at the last SYNC, not the current one";
        Breach::new(TPDO.subject(), duty).expected(right).found(found)
    }))
}

/// Configures TPDO 1 for remote frames; not applicable if the device refuses that.
fn remote_subject(bench: &mut Bench<'_>, transmission_type: u8) -> Result<Subject, Stop> {
    let subject = subject(bench, 255)?;
    let own = bench.pdo_off(TPDO)?;
    let with_remote = CobId(own.0 & !(CobId::NO_RTR | CobId::INVALID));
    let off = (with_remote.0 | CobId::INVALID).to_le_bytes();
    let on = bench.valid_cob_id(TPDO, with_remote).0.to_le_bytes();
    let steps = [(1, off.to_vec()), (2, vec![transmission_type]), (1, on.to_vec())];
    for (multiplexer, value) in steps.map(|(sub, value)| (TPDO.parameter(sub), value)) {
        let attempt = bench.download(multiplexer, &value)?;
        if let Some(code) = attempt.abort() {
            bench.check(attempt.refused(Situation::InvalidValue))?;
            let duty = match multiplexer.sub.0 {
                2 => format!("TPDO 1 can have type {transmission_type}"),
                _ => "TPDO 1 can answer remote frames".to_owned(),
            };
            return Err(Stop::NotApplicable(Reason::new(duty, "remote frames", format!("abort {code}"))));
        }
    }
    Ok(subject)
}

/// The device does not answer a remote frame for a TPDO with bit 30 of its COB-ID set.
#[case(id = "301/tpdo/remote-forbidden", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Tpdo], catches = [RemoteFrameAnsweredWhenNotAllowed])]
fn remote_forbidden(bench: &mut Bench<'_>) -> Judged {
    // An input may change at any time; without SYNC a synchronous TPDO does not show that.
    let is_changeable = bench.can_write_all(&MAPPING)?.is_ok() && bench.changeable_object().is_some();
    let can_id = countable(bench, if is_changeable { 255 } else { 1 })?;
    let own = bench.pdo_off(TPDO)?;
    bench.pdo_on(TPDO, CobId(own.0 | CobId::NO_RTR))?;
    operational(bench)?;
    let heard = remote(bench, can_id)?;
    bench.check(demand(heard.is_empty(), || {
        counted("a remote frame is not answered while bit 30 forbids it", 0, Some(0), heard.len())
    }))
}

/// The SYNC start value of TPDO 1 in [`sync_start`].
const START: u8 = 3;

/// With a SYNC start value and a SYNC counter the first TPDO follows the SYNC with that counter value, and a further
/// TPDO follows each later SYNC. This holds whichever of the two was written first, and whichever counter value the
/// first SYNC has.
#[case(id = "301/tpdo/sync-start", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Tpdo, Sync, SyncCounter],
       catches = [SyncStartValueIgnored, LateSyncCounterOverlooked, SyncStartAgain, SyncStartPassedBegins], cct = "3.8")]
fn sync_start(bench: &mut Bench<'_>) -> Judged {
    let can_id = countable(bench, 1)?;
    if !bench.can_write(TPDO.parameter(6))? {
        let reason = Reason::new("TPDO 1 has a SYNC start value", "1800h:06", "absent or read-only");
        return Err(Stop::NotApplicable(reason));
    }
    bench.stop_sync_period()?;
    bench.each([true, false], |bench, counter_first| {
        // 1019h is written before the start value in the first round, and after it in the second.
        let overflow = if counter_first { 10 } else { 20 };
        if counter_first {
            bench.write(OVERFLOW, &[overflow])?;
            bench.set_pdo(TPDO, &[(6, &[START])])?;
        } else {
            bench.write(OVERFLOW, &[0])?;
            bench.set_pdo(TPDO, &[(6, &[START])])?;
            bench.write(OVERFLOW, &[overflow])?;
        }
        // A device that becomes operational after the start value has passed waits for it to come again.
        for first in [1, START + 2] {
            begins_with(bench, can_id, first, overflow)?;
            bench.command(Command::ENTER_PRE_OPERATIONAL)?;
            bench.listen(bench.timing().reaction)?;
        }
        Ok(())
    })
}

/// Sends SYNCs from the counter `from` up to the overflow value, and those of the next cycle until the start value has
/// passed. Requires that the first TPDO follows the SYNC with the start value, and that a TPDO follows each later SYNC.
fn begins_with(bench: &mut Bench<'_>, can_id: u16, from: u8, overflow: u8) -> Judged {
    let id = bench.sync_id()?;
    operational(bench)?;
    let (mut first, mut missing) = (None, 0);
    let (last, again) = if from > START { (overflow, START + 2) } else { (overflow.min(10), 0) };
    for counter in (from..=last).chain(1..=again) {
        bench.drain()?;
        bench.send_bytes(id, &[counter])?;
        let sent = !bench.frames_of(can_id, bench.shortly())?.is_empty();
        first = first.or_else(|| sent.then_some(counter));
        missing += usize::from(first.is_some() && !sent);
    }
    bench.check(demand(first == Some(START), || {
        let breach =
            Breach::new(TPDO.subject(), "the first TPDO follows the SYNC whose counter equals the start value");
        let found = first.map_or(Observation::Silence, |counter| Observation::Number(u64::from(counter)));
        breach.expected(Observation::Number(u64::from(START))).found(found)
    }))?;
    bench.check(demand(missing == 0, || {
        counted("TPDO 1 of type 1 follows each SYNC after its first one: number of missing TPDOs", 0, Some(0), missing)
    }))
}

/// A TPDO has the number of bytes of its mapping.
#[case(id = "301/tpdo/length", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [EventTimer], catches = [TpdoTooLong])]
fn length(bench: &mut Bench<'_>) -> Judged {
    bench.require_mapped(TPDO)?;
    let bits: u32 = bench.mapping(TPDO)?.iter().map(|mapped| u32::from(mapped.bits)).sum();
    let length = bits.div_ceil(8) as usize;
    let transmission_type = bench.read_number(TPDO.parameter(2))?;
    if transmission_type < 254 {
        bench.set_pdo(TPDO, &[(2, &[255])])?;
    }
    bench.set_event_timer(TPDO, 100)?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    operational(bench)?;
    let heard = bench.frames_of(can_id, Duration::from_millis(300))?;
    if heard.is_empty() {
        let reason = Reason::new("TPDO 1 is sent", "one every 100 ms", "none in 300 ms");
        return Err(Stop::Inconclusive(reason));
    }
    let wrong = heard.iter().map(|record| record.data().len()).find(|&found| found != length);
    bench.check(demand(wrong.is_none(), || {
        let breach =
            Breach::new(TPDO.subject(), format!("TPDO 1 has the number of bytes for the {bits} bits that it maps"));
        let breach = breach.expected(Observation::Number(length as u64));
        breach.found(Observation::Number(wrong.unwrap_or_default() as u64))
    }))
}
