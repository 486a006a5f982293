//! Heartbeat producer (1017h).

use crate::bench::Bench;
use crate::bench::state::{HEARTBEAT_TIME, command_to};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::sdo::Request;
use canvass_bus::client::sdo::Bytes;
use canvass_traces::{Duration, Record};

fn set_time(bench: &mut Bench<'_>, milliseconds: u16) -> Result<(), Stop> {
    bench.write(HEARTBEAT_TIME, &milliseconds.to_le_bytes())
}

fn heartbeats(bench: &mut Bench<'_>, span: Duration) -> Result<Vec<Record>, Stop> {
    let heard = bench.listen(span)?;
    Ok(heard.into_iter().filter(|record| bench.is_error_control(&record.frame)).collect())
}

/// Heartbeats come at the period that 1017h says, in milliseconds.
///
/// Judged is the mean over ten periods or more, of 100, 250 and 1000 ms; single ones may jitter.
#[case(id = "301/heartbeat/period", clause = "CiA 301 7.5.2.20", confidence = Derived, level = Must,
       needs = [Heartbeat], catches = [HeartbeatPeriodDoubled, HeartbeatTimerRounded], cct = "7.102")]
fn period(bench: &mut Bench<'_>) -> Judged {
    const PERIODS: u64 = 10;
    for milliseconds in [100, 250, 1_000] {
        let period = Duration::from_millis(u64::from(milliseconds));
        set_time(bench, milliseconds)?;
        // The first period may begin before the new value.
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
        demand(is_right, || {
            let actual = mean.map_or_else(|| "fewer than two heartbeats".to_owned(), |mean| mean.to_string());
            let duty = format!("with 1017h = {milliseconds} a heartbeat comes every {period}");
            Reason::new(duty, format!("{period} ± {tolerance} on average"), actual)
        })?;
    }
    Ok(())
}

fn mean_period(heard: &[Record]) -> Option<Duration> {
    let (first, last) = (heard.first()?, heard.last()?);
    let gaps = u64::try_from(heard.len().checked_sub(1)?).ok().filter(|&gaps| gaps > 0)?;
    Some(Duration::from_nanos(last.timestamp.since(first.timestamp).nanos() / gaps))
}

/// With 1017h = 0 the device sends no heartbeat.
#[case(id = "301/heartbeat/off", clause = "CiA 301 7.5.2.20", confidence = Derived, level = Must,
       needs = [Heartbeat], catches = [HeartbeatNotStopped], cct = "7.103")]
fn off(bench: &mut Bench<'_>) -> Judged {
    let period = Duration::from_millis(100);
    set_time(bench, 100)?;
    let before = heartbeats(bench, period.times(3))?;
    demand(!before.is_empty(), || {
        Reason::new("with 1017h = 100 heartbeats come", "one every 100 ms", "none in 300 ms")
    })
    .or_inconclusive()?;
    set_time(bench, 0)?;
    // One may be on its way.
    bench.listen(bench.timing().reaction)?;
    let after = heartbeats(bench, period.times(5))?;
    bench.check(demand(after.is_empty(), || {
        Reason::new("with 1017h = 0 no heartbeat comes", "silence for 500 ms", format!("{} heartbeats", after.len()))
    }))
}

/// A heartbeat is one byte that holds the NMT state: 7Fh pre-operational, 05h operational, 04h stopped; bit 7 is 0.
#[case(id = "301/heartbeat/state", clause = "CiA 301 7.2.8.3.2.2", confidence = Attested, level = Must,
       needs = [Heartbeat], catches = [HeartbeatWrongState, HeartbeatToggles, HeartbeatLostOnStateChange])]
fn state(bench: &mut Bench<'_>) -> Judged {
    set_time(bench, 50)?;
    for state in [State::PRE_OPERATIONAL, State::OPERATIONAL, State::STOPPED, State::OPERATIONAL] {
        if let Some(command) = command_to(state) {
            bench.command(command)?;
        }
        bench.listen(bench.timing().reaction)?;
        let heard = heartbeats(bench, Duration::from_millis(200))?;
        let wrong = heard.iter().find(|record| record.data() != [state.0]);
        let actual = match (heard.is_empty(), wrong) {
            (true, _) => Some("no heartbeat in 200 ms".to_owned()),
            (_, Some(wrong)) => Some(Bytes(wrong.data()).to_string()),
            _ => None,
        };
        demand(actual.is_none(), || {
            let duty = format!("heartbeats of a device that is {state} say so");
            Reason::new(duty, format!("{:02X}", state.0), actual.unwrap_or_default())
        })?;
    }
    Ok(())
}

/// A new heartbeat time while heartbeats are sent takes effect at once: the timer starts anew, without a burst.
#[case(id = "301/heartbeat/new-time", clause = "CiA 301 7.2.8.2.2.3", confidence = Attested, level = Must,
       needs = [Heartbeat], catches = [HeartbeatBurst])]
fn new_time(bench: &mut Bench<'_>) -> Judged {
    set_time(bench, 400)?;
    heartbeats(bench, Duration::from_millis(500))?;
    // Without waiting for the confirmation: a burst would be over by then.
    bench.send_request(&Request::download(HEARTBEAT_TIME, &100_u16.to_le_bytes()))?;
    let heard = heartbeats(bench, Duration::from_millis(450))?;
    bench.check(demand((3..=6).contains(&heard.len()), || {
        let duty = "after 1017h was changed from 400 to 100 ms heartbeats come every 100 ms";
        Reason::new(duty, "4 in 450 ms, give or take one", heard.len().to_string())
    }))
}

/// A heartbeat time of 1 ms is honoured and one of 65535 ms is taken, or they are refused with abort 0609 0030h to
/// 0609 0032h; SDOs are served beside them.
#[case(id = "301/heartbeat/extremes", clause = "CiA 301 7.5.2.20", confidence = Derived, level = Should,
       needs = [Heartbeat], catches = [HeartbeatTimerRounded])]
fn extremes(bench: &mut Bench<'_>) -> Judged {
    use canvass_analyzer::wire::sdo::AbortCode;
    let refused = [AbortCode::INVALID_VALUE, AbortCode::VALUE_TOO_HIGH, AbortCode::VALUE_TOO_LOW];
    let attempt = bench.download(HEARTBEAT_TIME, &1_u16.to_le_bytes())?;
    if attempt.abort().is_some() {
        bench.check(attempt.refused_with(&refused, &[AbortCode::GENERAL]))?;
    } else {
        let heard = heartbeats(bench, Duration::from_millis(100))?;
        bench.upload(HEARTBEAT_TIME)?.value()?;
        demand(heard.len() >= 50, || {
            let expected = "about 100 in 100 ms, 50 at least";
            Reason::new("with 1017h = 1 a heartbeat comes every millisecond", expected, heard.len().to_string())
        })?;
    }
    let attempt = bench.download(HEARTBEAT_TIME, &u16::MAX.to_le_bytes())?;
    if attempt.abort().is_some() {
        bench.check(attempt.refused_with(&refused, &[AbortCode::GENERAL]))?;
    }
    Ok(())
}

/// 1017h has two bytes: one or four are refused with abort 0607 0013h or 0607 0012h.
#[case(id = "301/heartbeat/length", clause = "CiA 301 7.5.2.20", confidence = Derived, level = Must,
       needs = [Heartbeat], catches = [SdoLengthUnchecked, SdoShortLengthUnchecked, SdoLengthWrongCode], cct = "2.8")]
fn length(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(HEARTBEAT_TIME)?;
    let answer = bench.download(HEARTBEAT_TIME, &[0])?;
    bench.check(answer.refused(Situation::TooShort))?;
    let answer = bench.download(HEARTBEAT_TIME, &[0; 4])?;
    bench.check(answer.refused(Situation::TooLong))?;
    bench.expect_unchanged(HEARTBEAT_TIME, &before)?;
    Ok(())
}

/// The first heartbeat after a change of the NMT state shows the new state.
#[case(id = "301/heartbeat/new-state", clause = "CiA 301 7.2.8.3.2.2", confidence = Attested, level = Must,
       needs = [Heartbeat], catches = [HeartbeatStateLate, HeartbeatWrongState, HeartbeatPeriodDoubled])]
fn new_state(bench: &mut Bench<'_>) -> Judged {
    set_time(bench, 300)?;
    for state in [State::OPERATIONAL, State::STOPPED, State::PRE_OPERATIONAL] {
        // Right after a heartbeat there is time for the change before the next one.
        let before = heartbeats(bench, Duration::from_millis(310) + bench.bus_delay())?;
        demand(!before.is_empty(), || {
            Reason::new("with 1017h = 300 a heartbeat comes every 300 ms", "one in 310 ms", "none")
        })?;
        let last = before.last().map(|record| record.timestamp);
        let since = last.map_or(Duration::ZERO, |last| bench.now().since(last));
        if since.nanos() > Duration::from_millis(200).nanos() {
            bench.listen(Duration::from_millis(150))?;
        }
        if let Some(command) = command_to(state) {
            bench.command(command)?;
        }
        // A heartbeat at the moment of the command may show either state.
        bench.listen(Duration::from_millis(20))?;
        let after = heartbeats(bench, Duration::from_millis(350))?;
        let first = after.first().map(|record| record.data().to_vec()).unwrap_or_default();
        demand(first == [state.0], || {
            let duty = format!("the first heartbeat of a device that became {state} says so");
            Reason::new(duty, format!("{:02X}", state.0), Bytes(&first).to_string())
        })?;
    }
    Ok(())
}

/// After a reset the boot-up message counts as the first heartbeat: the next comes after the stored heartbeat time. The
/// old time is stored again afterwards.
#[case(id = "301/heartbeat/after-boot-up", clause = "CiA 301 7.2.8.2.2.3", confidence = Attested, level = Should,
       needs = [Heartbeat, Store], touches = [Nvm], catches = [HeartbeatLateAfterBootUp, StoreWithoutEffect])]
fn after_boot_up(bench: &mut Bench<'_>) -> Judged {
    use canvass_analyzer::Multiplexer;
    use canvass_analyzer::wire::nmt::Command;
    const STORE: Multiplexer = Multiplexer::new(0x1010, 1);
    let before = bench.read(HEARTBEAT_TIME)?;
    set_time(bench, 200)?;
    bench.write(STORE, b"save")?;
    bench.drain()?;
    bench.command(Command::RESET_COMMUNICATION)?;
    let boot_up = bench.wait_for_boot_up()?;
    let heard = heartbeats(bench, Duration::from_millis(800))?;
    // Whatever came of it, the device gets its old value back.
    bench.write(HEARTBEAT_TIME, &before)?;
    bench.write(STORE, b"save")?;
    let gap = boot_up.zip(heard.first()).map(|(boot_up, first)| first.timestamp.since(boot_up));
    bench.check(demand(gap.is_some_and(|gap| gap.nanos() <= Duration::from_millis(250).nanos()), || {
        let actual = gap.map_or_else(|| "none in 800 ms".to_owned(), |gap| format!("after {gap}"));
        Reason::new("with 1017h = 200 stored a heartbeat follows the boot-up message", "after 200 ms", actual)
    }))
}
