//! Heartbeat producer (1017h).

use crate::bench::Bench;
use crate::bench::state::{HEARTBEAT_TIME, command_to};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::Request;
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record, Timestamp};

fn set_time(bench: &mut Bench<'_>, milliseconds: u16) -> Result<(), Stop> {
    bench.write(HEARTBEAT_TIME, &milliseconds.to_le_bytes())
}

fn heartbeats(bench: &mut Bench<'_>, span: Duration) -> Result<Vec<Record>, Stop> {
    let heard = bench.listen(span)?;
    Ok(heard.into_iter().filter(|record| bench.is_error_control(&record.frame)).collect())
}

/// The breach of a wrong number of heartbeats: fewer than `least`, or more than `most`.
fn counted(duty: &'static str, least: u64, most: Option<u64>, found: usize) -> Breach {
    let found = Observation::Count(found as u64);
    Breach::new(Service::Heartbeat, duty).expected(Allowed::Count { least, most }).found(found)
}

/// The device sends heartbeats with the period in milliseconds that 1017h holds.
///
/// The case judges the mean over ten periods or more, of 100, 250 and 1000 ms; single periods may jitter.
#[case(id = "301/heartbeat/period", clause = "CiA 301 7.5.2.20", confidence = Cited, level = Must,
       needs = [Heartbeat], catches = [HeartbeatPeriodDoubled, HeartbeatTimerRounded], cct = "7.102")]
fn period(bench: &mut Bench<'_>) -> Judged {
    const PERIODS: u64 = 10;
    burst(bench)?;
    bench.each([100_u16, 250, 1_000], |bench, milliseconds| {
        let period = Duration::from_millis(u64::from(milliseconds));
        // Only this case judges whether the device accepts a valid time; all other cases need a device that does.
        bench.download(HEARTBEAT_TIME, &milliseconds.to_le_bytes())?.expect_confirmation()?;
        // The first period may have begun before the new value.
        heartbeats(bench, period)?;
        let heard = heartbeats(bench, period.times(PERIODS) + Duration::from_nanos(period.nanos() / 2))?;
        let mean = mean_period(&heard);
        let gaps = heard.windows(2).filter_map(|pair| Some(pair.last()?.timestamp.since(pair.first()?.timestamp)));
        if let (Some(least), Some(most)) = (gaps.clone().min(), gaps.max()) {
            bench.measure(format!("heartbeat of {period}, shortest"), least);
            bench.measure(format!("heartbeat of {period}, longest"), most);
        }
        let tolerance = bench.timing().tolerance(period) + Duration::from_nanos(bench.bus_delay().nanos() / PERIODS);
        let is_right = mean.is_some_and(|mean| mean.nanos().abs_diff(period.nanos()) <= tolerance.nanos());
        bench.check(demand(is_right, || {
            let duty = format!("with 1017h = {milliseconds} a heartbeat comes every {period} on average");
            let least = Duration::from_nanos(period.nanos().saturating_sub(tolerance.nanos()));
            Breach::new(Service::Heartbeat, duty)
                .expected(Allowed::Time { least, most: period + tolerance })
                .found(mean.map_or(Observation::Count(heard.len() as u64), Observation::Time))
                .over(heard.len().saturating_sub(1) as u64)
        }))
    })
}

/// Requires that a device that sent no heartbeats before does not send the first ones in a burst.
fn burst(bench: &mut Bench<'_>) -> Judged {
    const PERIOD: Duration = Duration::from_millis(200);
    if bench.read_number(HEARTBEAT_TIME)? != 0 {
        return Ok(());
    }
    let begun = bench.now();
    bench.download(HEARTBEAT_TIME, &200_u16.to_le_bytes())?.expect_confirmation()?;
    bench.listen(PERIOD.times(3))?;
    let mut heard = bench.heard_since(begun);
    heard.retain(|record| bench.is_error_control(&record.frame));
    let gaps = heard.windows(2).filter_map(|pair| Some(pair.last()?.timestamp.since(pair.first()?.timestamp)));
    let least = Duration::from_nanos(PERIOD.nanos() / 4);
    let shortest = gaps.min().unwrap_or(PERIOD);
    bench.check(demand(shortest >= least, || {
        let duty = "with 1017h = 200 the first heartbeats are 200 ms apart";
        let allowed = Allowed::Time { least, most: PERIOD.times(2) };
        Breach::new(Service::Heartbeat, duty).expected(allowed).found(Observation::Time(shortest))
    }))
}

fn mean_period(heard: &[Record]) -> Option<Duration> {
    let (first, last) = (heard.first()?, heard.last()?);
    let gaps = u64::try_from(heard.len().checked_sub(1)?).ok().filter(|&gaps| gaps > 0)?;
    Some(Duration::from_nanos(last.timestamp.since(first.timestamp).nanos() / gaps))
}

/// With 1017h = 0 the device sends no heartbeat.
#[case(id = "301/heartbeat/off", clause = "CiA 301 7.5.2.20", confidence = Cited, level = Must,
       needs = [Heartbeat], catches = [HeartbeatNotStopped], cct = "7.103")]
fn off(bench: &mut Bench<'_>) -> Judged {
    let period = Duration::from_millis(100);
    set_time(bench, 100)?;
    let before = heartbeats(bench, period.times(3))?;
    demand(!before.is_empty(), || counted("with 1017h = 100 heartbeats come every 100 ms", 3, Some(3), 0))
        .or_inconclusive()?;
    set_time(bench, 0)?;
    // A heartbeat may already be on its way.
    bench.listen(bench.timing().reaction)?;
    let after = heartbeats(bench, period.times(5))?;
    bench.check(demand(after.is_empty(), || {
        counted("with 1017h = 0 no heartbeat comes, in 500 ms", 0, Some(0), after.len())
    }))
}

/// A heartbeat is one byte that holds the NMT state: 7Fh pre-operational, 05h operational, 04h stopped; bit 7 is 0.
/// The first heartbeat is no exception. While the state changes, a heartbeat may show either state.
#[case(id = "301/heartbeat/state", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Must,
       needs = [Heartbeat], catches = [HeartbeatWrongState, HeartbeatToggles, HeartbeatLostOnStateChange])]
fn state(bench: &mut Bench<'_>) -> Judged {
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let begun = bench.now();
    set_time(bench, 50)?;
    shows(bench, State::OPERATIONAL, &[], begun)?;
    let states = [State::PRE_OPERATIONAL, State::OPERATIONAL, State::STOPPED, State::OPERATIONAL];
    let mut before = State::OPERATIONAL;
    bench.each(states, |bench, state| {
        let begun = bench.now();
        if let Some(command) = command_to(state) {
            bench.command(command)?;
        }
        let earlier = std::mem::replace(&mut before, state);
        shows(bench, state, &[earlier], begun)
    })?;
    bench.reset(Command::RESET_NODE)?;
    if bench.starts_by_itself()? {
        return Ok(());
    }
    let begun = bench.now();
    set_time(bench, 50)?;
    shows(bench, State::PRE_OPERATIONAL, &[], begun)
}

/// Requires heartbeats that show this state. Heartbeats between `begun` and the end of the reaction time may still show
/// one of the states `before`.
fn shows(bench: &mut Bench<'_>, state: State, before: &[State], begun: Timestamp) -> Judged {
    bench.listen(bench.timing().reaction)?;
    let reacted = bench.now();
    let mut early = bench.heard_since(begun);
    early.retain(|record| bench.is_error_control(&record.frame));
    let heard = heartbeats(bench, Duration::from_millis(200))?;
    let is_right = |record: &Record| match *record.data() {
        [byte] => byte == state.0 || record.timestamp <= reacted && before.iter().any(|before| byte == before.0),
        _ => false,
    };
    let wrong = early.iter().chain(&heard).find(|record| !is_right(record));
    let found = match wrong {
        Some(wrong) => Observation::Value(wrong.data().to_vec()),
        None if heard.is_empty() => Observation::Silence,
        None => return Ok(()),
    };
    let duty = format!("heartbeats of a device that is {state} show this state");
    let breach = Breach::new(Service::Heartbeat, duty).expected(Observation::Value(vec![state.0]));
    bench.check(Err(Box::new(breach.found(found))))
}

/// A new heartbeat time that is written while heartbeats are sent takes effect after the old period at the latest,
/// without a burst of heartbeats.
#[case(id = "301/heartbeat/new-time", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Must,
       needs = [Heartbeat], catches = [HeartbeatBurst])]
fn new_time(bench: &mut Bench<'_>) -> Judged {
    const SPAN: Duration = Duration::from_millis(450);
    set_time(bench, 400)?;
    heartbeats(bench, Duration::from_millis(500))?;
    // Does not wait for the confirmation: a burst would be over by then.
    bench.send_request(&Request::download(HEARTBEAT_TIME, &100_u16.to_le_bytes()))?;
    let first = heartbeats(bench, SPAN)?.len();
    bench.check(demand(first <= 6, || {
        counted("after 1017h was changed from 400 to 100 ms heartbeats come every 100 ms at most", 1, Some(6), first)
    }))?;
    // Even a slow server has confirmed by now.
    heartbeats(bench, bench.timing().sdo_response)?;
    bench.drain()?;
    let then = heartbeats(bench, SPAN)?.len();
    bench.check(demand((3..=6).contains(&then), || {
        counted("once 1017h was changed from 400 to 100 ms heartbeats come every 100 ms, in 450 ms", 3, Some(6), then)
    }))
}

/// The device observes a heartbeat time of 1 ms and accepts a time of 65535 ms, or refuses these values with abort 0609
/// 0030h to 0609 0032h. The SDO server answers while heartbeats are sent.
#[case(id = "301/heartbeat/extremes", clause = "CiA 301 7.5.2.20", confidence = Cited, level = Should,
       needs = [Heartbeat], catches = [HeartbeatTimerRounded])]
fn extremes(bench: &mut Bench<'_>) -> Judged {
    // A timer with whole milliseconds may count 2 ms instead of 1 ms, and other tasks of the device delay it further.
    const LEAST: u64 = 40;
    let attempt = bench.download(HEARTBEAT_TIME, &1_u16.to_le_bytes())?;
    if attempt.abort().is_some() {
        bench.check(attempt.refused(Situation::InvalidValue))?;
    } else {
        const SPAN: Duration = Duration::from_millis(100);
        let heard = heartbeats(bench, SPAN)?.len();
        let served = bench.upload(HEARTBEAT_TIME)?.value().map(|_| ());
        bench.check(served)?;
        bench.check(demand(heard as u64 >= LEAST, || {
            let duty = "with 1017h = 1 a heartbeat comes every millisecond, about 100 in 100 ms";
            // A device that is late by the mean distance of its heartbeats can't send more of them.
            let distance = Duration::from_nanos(SPAN.nanos() / heard.max(1) as u64);
            counted(duty, LEAST, None, heard).explained_by(distance)
        }))?;
    }
    let attempt = bench.download(HEARTBEAT_TIME, &u16::MAX.to_le_bytes())?;
    let is_refused = attempt.abort().is_some();
    bench.check(if is_refused { attempt.refused(Situation::InvalidValue) } else { attempt.expect_confirmation() })
}

/// 1017h has two bytes: writing one byte is refused with abort 0607 0013h, writing four bytes with abort 0607 0012h.
#[case(id = "301/heartbeat/length", clause = "CiA 301 7.5.2.20", confidence = Cited, level = Must,
       needs = [Heartbeat], catches = [SdoLengthUnchecked, SdoShortLengthUnchecked, SdoLengthWrongCode], cct = "2.8")]
fn length(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(HEARTBEAT_TIME)?;
    let answer = bench.download(HEARTBEAT_TIME, &[0])?;
    bench.check(answer.refused(Situation::TooShort))?;
    let answer = bench.download(HEARTBEAT_TIME, &[0; 4])?;
    bench.check(answer.refused(Situation::TooLong))?;
    bench.expect_unchanged(HEARTBEAT_TIME, &before)
}

/// The first heartbeat after a change of the NMT state shows the new state.
#[case(id = "301/heartbeat/new-state", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Must,
       needs = [Heartbeat], catches = [HeartbeatStateLate, HeartbeatWrongState, HeartbeatPeriodDoubled])]
fn new_state(bench: &mut Bench<'_>) -> Judged {
    const PERIOD: Duration = Duration::from_millis(300);
    set_time(bench, 300)?;
    bench.each([State::OPERATIONAL, State::STOPPED, State::PRE_OPERATIONAL], |bench, state| {
        // Right after a heartbeat there is time for the state change before the next one.
        let one_period = PERIOD + bench.tolerance(PERIOD) + bench.host_delay();
        let before = heartbeats(bench, one_period)?;
        demand(!before.is_empty(), || counted("with 1017h = 300 a heartbeat comes every 300 ms", 1, None, 0))?;
        let last = before.last().map(|record| record.timestamp);
        let since = last.map_or(Duration::ZERO, |last| bench.now().since(last));
        if since > Duration::from_millis(200) {
            bench.listen(Duration::from_millis(150))?;
        }
        if let Some(command) = command_to(state) {
            bench.command(command)?;
        }
        // A heartbeat at the moment of the command may show either state.
        bench.listen(Duration::from_millis(20))?;
        let after = heartbeats(bench, one_period + Duration::from_millis(50))?;
        let found = after.first().map_or(Observation::Silence, |record| Observation::Value(record.data().to_vec()));
        let right = Observation::Value(vec![state.0]);
        bench.check(demand(found == right, || {
            let duty = format!("the first heartbeat of a device that became {state} shows this state");
            Breach::new(Service::Heartbeat, duty).expected(right).found(found)
        }))
    })
}

/// The boot-up message counts as the first heartbeat after a reset: the next heartbeat follows after the stored
/// heartbeat time. The case stores the old time again afterwards.
#[case(id = "301/heartbeat/after-boot-up", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Must,
       needs = [Heartbeat, Store], touches = [Nvm], catches = [HeartbeatLateAfterBootUp, StoredConfigurationIdle])]
fn after_boot_up(bench: &mut Bench<'_>) -> Judged {
    const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
    const LATEST: Duration = Duration::from_millis(250);
    let before = bench.read(HEARTBEAT_TIME)?;
    set_time(bench, 200)?;
    bench.write(STORE, b"save")?;
    bench.drain()?;
    bench.command(Command::RESET_COMMUNICATION)?;
    let boot_up = bench.wait_for_boot_up()?;
    let heard = heartbeats(bench, Duration::from_millis(800))?;
    let stored = bench.read(HEARTBEAT_TIME);
    // The device gets its old value back, whether the check passed or not.
    bench.write(HEARTBEAT_TIME, &before)?;
    bench.write(STORE, b"save")?;
    let stored = stored?;
    if stored != [200, 0] {
        let actual = format!("{} after reset communication", Bytes(&stored));
        return Err(Stop::Inconclusive(Reason::new("1017h can be stored", "C8 00 after the reset", actual)));
    }
    let gap = boot_up.zip(heard.first()).map(|(boot_up, first)| first.timestamp.since(boot_up));
    bench.check(demand(gap.is_some_and(|gap| gap <= LATEST), || {
        let duty = "with 1017h = 200 stored a heartbeat follows the boot-up message after 200 ms";
        Breach::new(Service::Heartbeat, duty)
            .expected(Allowed::Time { least: Duration::ZERO, most: LATEST })
            .found(gap.map_or(Observation::Silence, Observation::Time))
    }))
}
