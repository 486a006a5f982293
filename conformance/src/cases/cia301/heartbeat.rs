//! Heartbeat producer (1017h).

use crate::bench::Bench;
use crate::bench::state::{HEARTBEAT_TIME, command_to};
use crate::case;
use crate::client::sdo::Bytes;
use crate::verdict::{Judged, Reason, Verdict, demand};
use canvass_analyzer::wire::error_control::State;
use canvass_traces::{Duration, Record};

fn set_time(bench: &mut Bench<'_>, milliseconds: u16) -> Result<(), Verdict> {
    bench.write(HEARTBEAT_TIME, &milliseconds.to_le_bytes())
}

fn heartbeats(bench: &mut Bench<'_>, span: Duration) -> Result<Vec<Record>, Verdict> {
    let heard = bench.listen(span)?;
    Ok(heard.into_iter().filter(|record| bench.is_error_control(&record.frame)).collect())
}

/// Heartbeats come at the period that 1017h says, in milliseconds.
///
/// Judged is the mean over ten periods or more, of 100, 250 and 1000 ms; single ones may jitter.
#[case(id = "301/heartbeat/period", clause = "CiA 301 7.5.2.20", confidence = Derived, level = Must,
       needs = [Heartbeat], catches = [HeartbeatPeriodDoubled], cct = "7.102")]
fn period(bench: &mut Bench<'_>) -> Judged {
    const PERIODS: u64 = 10;
    for milliseconds in [100, 250, 1_000] {
        let period = Duration::from_millis(u64::from(milliseconds));
        set_time(bench, milliseconds)?;
        // The first period may begin before the new value.
        heartbeats(bench, period)?;
        let heard = heartbeats(bench, period.times(PERIODS) + Duration::from_nanos(period.nanos() / 2))?;
        let mean = mean_period(&heard);
        let tolerance = bench.timing().tolerance(period);
        let is_right = mean.is_some_and(|mean| mean.nanos().abs_diff(period.nanos()) <= tolerance.nanos());
        demand(is_right, || {
            let actual = mean.map_or_else(|| "fewer than two heartbeats".to_owned(), |mean| mean.to_string());
            let duty = format!("with 1017h = {milliseconds} a heartbeat comes every {period}");
            Reason::new(duty, format!("{period} ± {tolerance} on average"), actual)
        })?;
    }
    Ok(Verdict::Pass)
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
    .map_err(Verdict::as_inconclusive)?;
    set_time(bench, 0)?;
    // One may be on its way.
    bench.listen(bench.timing().reaction)?;
    let after = heartbeats(bench, period.times(5))?;
    demand(after.is_empty(), || {
        Reason::new("with 1017h = 0 no heartbeat comes", "silence for 500 ms", format!("{} heartbeats", after.len()))
    })
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
    Ok(Verdict::Pass)
}
