//! TPDOs: the events that send them.

use crate::bench::Bench;
use crate::bench::objects::{EVENT_TIMER, INHIBIT_TIME, TPDO_COB_ID, TRANSMISSION_TYPE};
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::CobId;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::{CanId, Duration, Frame, Record};

const PERIOD_MS: u16 = 100;
const PERIOD: Duration = Duration::from_millis(100);

/// Configures TPDO 1 for its event timer and returns its CAN-ID.
fn cyclic_tpdo(bench: &mut Bench<'_>) -> Result<u16, Stop> {
    bench.require_mapped(TPDO)?;
    let cob_id = CobId(bench.read_number(TPDO_COB_ID)?);
    let transmission_type = bench.read_number(TRANSMISSION_TYPE)?;
    if transmission_type < 254 {
        bench.pdo_off(TPDO)?;
        set_type(bench, 255)?;
        bench.pdo_on(TPDO, cob_id)?;
    }
    bench.set_event_timer(TPDO, PERIOD_MS)?;
    Ok((cob_id.can_id() & 0x7FF) as u16)
}

/// The breach of a wrong number of TPDOs: fewer than `least`, or more than `most`.
fn counted(duty: String, least: u64, most: Option<u64>, found: usize) -> Breach {
    let expected = Allowed::Count { least, most };
    Breach::new(TPDO.subject(), duty).expected(expected).found(Observation::Count(found as u64))
}

fn tpdos(bench: &mut Bench<'_>, cob_id: u16, span: Duration) -> Result<Vec<Record>, Stop> {
    let mut heard = Vec::new();
    bench.wait_for(span, |record| {
        if record.frame.cob_id() == Some(cob_id) && heard.len() < 1_000 {
            heard.push(record.clone());
        }
        None::<()>
    })?;
    Ok(heard)
}

/// In operational the device sends a TPDO with the period of its event timer, or of its inhibit time if that is longer.
///
/// The case judges the mean over ten periods; a single period may be up to one half longer.
#[case(id = "301/tpdo/event-timer", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer], catches = [EventTimerDoubled], cct = "3.5")]
fn event_timer(bench: &mut Bench<'_>) -> Judged {
    const PERIODS: u64 = 10;
    let cob_id = cyclic_tpdo(bench)?;
    let period = PERIOD.max(bench.pdo_inhibit_time(TPDO)?);
    bench.command(Command::START)?;
    tpdos(bench, cob_id, period)?;
    let heard = tpdos(bench, cob_id, period.times(PERIODS) + Duration::from_nanos(period.nanos() / 2))?;
    let duty = || format!("with {EVENT_TIMER} = {PERIOD_MS} the TPDO comes every {period}");
    // Value changes may send the TPDO in between, so only too few TPDOs are wrong; the gaps between them are decisive.
    bench.check(demand(heard.len() as u64 >= PERIODS, || counted(duty(), PERIODS, None, heard.len())))?;
    let gaps = heard.windows(2).map(|pair| match pair {
        [a, b] => b.timestamp.since(a.timestamp),
        _ => Duration::ZERO,
    });
    let longest = gaps.max().unwrap_or(Duration::ZERO);
    bench.measure(format!("TPDO period with an event timer of {PERIOD}, longest"), longest);
    let gaps = heard.len().saturating_sub(1) as u64;
    let span = heard.first().zip(heard.last()).map(|(first, last)| last.timestamp.since(first.timestamp));
    let mean = Duration::from_nanos(span.unwrap_or_default().nanos() / gaps.max(1));
    let tolerance = bench.timing().tolerance(period) + Duration::from_nanos(bench.bus_delay().nanos() / gaps.max(1));
    let at_most = |most| Allowed::Time { least: Duration::ZERO, most };
    let breach = |most| Breach::new(EVENT_TIMER, duty()).expected(at_most(most));
    bench.check(demand(mean <= period + tolerance, || {
        breach(period + tolerance).found(Observation::Time(mean)).over(gaps)
    }))?;
    let most = Duration::from_nanos(period.nanos() * 3 / 2);
    bench.check(demand(longest <= most, || breach(most).found(Observation::Time(longest))))
}

/// The device sends no TPDO in pre-operational, even if an event timer is running.
#[case(id = "301/state/pre-operational/tpdo", clause = "CiA 301 7.3.2.2.2", confidence = Cited, level = Must,
       needs = [Tpdo], catches = [TpdoInPreOperational], cct = "9.2")]
fn pre_operational(bench: &mut Bench<'_>) -> Judged {
    silent_unless_operational(bench, Command::ENTER_PRE_OPERATIONAL)
}

/// The device sends no TPDO in stopped, even if an event timer is running.
#[case(id = "301/state/stopped/tpdo", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       needs = [Tpdo], catches = [TpdoWhenStopped], cct = "9.4")]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    silent_unless_operational(bench, Command::STOP)
}

/// Requires that the TPDO comes in operational, and no longer after `command`.
fn silent_unless_operational(bench: &mut Bench<'_>, command: Command) -> Judged {
    let trigger = trigger(bench)?;
    bench.command(Command::START)?;
    let running = trigger.listen(bench, 3)?;
    demand(!running.is_empty(), || counted(format!("TPDO 1 is sent in operational {}", trigger.text()), 1, None, 0))
        .or_inconclusive()?;
    bench.command(command)?;
    // A TPDO may already be on its way.
    bench.listen(bench.timing().reaction)?;
    let heard = trigger.listen(bench, 5)?;
    bench.check(demand(heard.is_empty(), || {
        counted(format!("after {command} TPDO 1 is not sent"), 0, Some(0), heard.len())
    }))?;
    not_for_a_remote_frame(bench, trigger.can_id(), command)
}

/// Requires that the TPDO is not sent for a remote frame, either.
fn not_for_a_remote_frame(bench: &mut Bench<'_>, can_id: u16, command: Command) -> Judged {
    let Some(request) = Frame::remote(CanId::standard_masked(u32::from(can_id)), 8) else { return Ok(()) };
    bench.send(&request)?;
    let answers = tpdos(bench, can_id, bench.timing().silence)?;
    bench.check(demand(answers.is_empty(), || {
        counted(format!("after {command} TPDO 1 does not answer a remote frame"), 0, Some(0), answers.len())
    }))
}

/// The trigger of TPDO 1, with the CAN-ID of the TPDO.
enum Trigger {
    /// The event timer.
    Timer(u16),
    /// SYNC with the second CAN-ID, if the device has no event timer.
    Sync(u16, u16),
}

fn trigger(bench: &mut Bench<'_>) -> Result<Trigger, Stop> {
    if bench.has(EVENT_TIMER)? {
        return cyclic_tpdo(bench).map(Trigger::Timer);
    }
    if !(1..=240).contains(&bench.read_number(TRANSMISSION_TYPE)?) {
        set_type(bench, 1)?;
    }
    bench.expect_plain_sync()?;
    let can_id = CobId(bench.read_number(TPDO_COB_ID)?).can_id() & 0x7FF;
    Ok(Trigger::Sync(can_id as u16, bench.sync_id()?))
}

/// Sets the transmission type. If the device refuses changes to a PDO in use, the PDO is off meanwhile. Some devices of
/// DS-301 V3.0 have a fixed type.
fn set_type(bench: &mut Bench<'_>, transmission_type: u8) -> Result<(), Stop> {
    let mut attempt = bench.download(TRANSMISSION_TYPE, &[transmission_type])?;
    if attempt.abort().is_some() && bench.can_write(TPDO_COB_ID)? {
        let cob_id = bench.pdo_off(TPDO)?;
        attempt = bench.download(TRANSMISSION_TYPE, &[transmission_type])?;
        bench.pdo_on(TPDO, cob_id)?;
    }
    match attempt.abort() {
        Some(code) => {
            let duty = format!("TPDO 1 can have transmission type {transmission_type}");
            Err(Stop::NotApplicable(Reason::new(duty, "confirmation", format!("abort {code}"))))
        }
        None => attempt.expect_confirmation().or_inconclusive(),
    }
}

impl Trigger {
    /// The TPDOs within this many periods or SYNCs.
    fn listen(&self, bench: &mut Bench<'_>, times: u64) -> Result<Vec<Record>, Stop> {
        match *self {
            Self::Timer(can_id) => tpdos(bench, can_id, PERIOD.times(times)),
            Self::Sync(can_id, sync_id) => {
                let mut heard = Vec::new();
                for _ in 0..times {
                    bench.send_bytes(sync_id, &[])?;
                    heard.extend(tpdos(bench, can_id, bench.timing().reaction)?);
                }
                Ok(heard)
            }
        }
    }

    const fn can_id(&self) -> u16 {
        match *self {
            Self::Timer(can_id) | Self::Sync(can_id, ..) => can_id,
        }
    }

    const fn text(&self) -> &'static str {
        match self {
            Self::Timer(_) => "every 100 ms",
            Self::Sync(..) => "with each SYNC",
        }
    }
}

/// The shortest pause after a SYNC.
const LEAST_PAUSE: Duration = Duration::from_millis(20);

/// The device sends a TPDO of transmission type n once for every n SYNCs.
#[case(id = "301/tpdo/sync-cycle", clause = "CiA 301 7.2.2.2", confidence = Cited, level = Must,
       needs = [Tpdo], catches = [SyncCycleIgnored], cct = "6.3")]
fn sync_cycle(bench: &mut Bench<'_>) -> Judged {
    bench.require_mapped(TPDO)?;
    bench.expect_plain_sync()?;
    let cob_id = (CobId(bench.read_number(TPDO_COB_ID)?).can_id() & 0x7FF) as u16;
    let sync_id = bench.sync_id()?;
    let (mut pause, mut slowest) = (bench.shortly().max(LEAST_PAUSE), Duration::ZERO);
    // 240 is the longest cycle.
    bench.each([(1_u8, 4), (3, 4), (240, 1)], |bench, (cycle, cycles)| {
        bench.command(Command::ENTER_PRE_OPERATIONAL)?;
        bench.listen(bench.timing().reaction)?;
        match set_type(bench, cycle) {
            Err(Stop::NotApplicable(_)) if cycle == 240 => return Ok(()),
            set => set?,
        }
        bench.command(Command::START)?;
        bench.listen(bench.timing().reaction)?;
        let mut sent = 0;
        for _ in 0..cycles * usize::from(cycle) {
            let at = bench.now();
            bench.send_bytes(sync_id, &[])?;
            let heard = tpdos(bench, cob_id, pause)?;
            sent += heard.len();
            slowest = heard.first().map_or(slowest, |record| slowest.max(record.timestamp.since(at)));
        }
        // After each SYNC the device gets the time that it needs for its TPDO.
        pause = LEAST_PAUSE.max(slowest + slowest);
        sent += tpdos(bench, cob_id, bench.shortly())?.len();
        bench.check(demand(sent == cycles, || {
            let syncs = cycles * usize::from(cycle);
            let duty = format!("with transmission type {cycle} TPDO 1 follows every {cycle}. of {syncs} SYNCs");
            counted(duty, cycles as u64, Some(cycles as u64), sent)
        }))
    })
}

/// At least the inhibit time passes between two TPDOs, whatever the event timer is.
#[case(id = "301/tpdo/inhibit-time", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer], catches = [InhibitTimeIgnored])]
fn inhibit_time(bench: &mut Bench<'_>) -> Judged {
    const INHIBIT: Duration = Duration::from_millis(300);
    let cob_id = bench.read(TPDO_COB_ID)?;
    let number = crate::bench::sdo::number(&cob_id);
    // The inhibit time, in units of 100 µs, can change only while the PDO is not valid.
    bench.write(TPDO_COB_ID, &(number | CobId::INVALID).to_le_bytes())?;
    bench.write(INHIBIT_TIME, &3_000_u16.to_le_bytes())?;
    bench.write(TPDO_COB_ID, &cob_id)?;
    let can_id = cyclic_tpdo(bench)?;
    bench.command(Command::START)?;
    let heard = tpdos(bench, can_id, INHIBIT.times(5))?;
    let gaps = heard.windows(2).filter_map(|pair| match pair {
        [a, b] => Some(b.timestamp.since(a.timestamp)),
        _ => None,
    });
    let least = Duration::from_nanos(INHIBIT.nanos().saturating_sub(bench.tolerance(INHIBIT).nanos()));
    let shortest = gaps.min();
    bench.check(demand(shortest.is_some_and(|gap| gap >= least), || {
        let breach = Breach::new(INHIBIT_TIME, "TPDOs are at least the inhibit time apart");
        match shortest {
            Some(gap) => breach.expected(Allowed::Time { least, most: INHIBIT.times(2) }).found(Observation::Time(gap)),
            None => counted("TPDO 1 is sent every 300 ms, in 1.5 s".to_owned(), 2, None, heard.len()),
        }
    }))
}
