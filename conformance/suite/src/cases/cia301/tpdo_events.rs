//! TPDOs: events, SYNC and remote frames (CiA 301, 7.2.2).

use crate::bench::pdo::TPDO;
use crate::bench::{Bench, percentile};
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::Request;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::sdo::Bytes;
use canvass_traces::{CanId, Duration, Frame, Record};

const SHORTLY: Duration = Duration::from_millis(100);

/// TPDO 1 carries one object that SDOs can write.
struct Subject {
    at: Multiplexer,
    can_id: u16,
    values: [Vec<u8>; 2],
}

/// Gives TPDO 1 a changeable object and a transmission type, without event timer and inhibit time.
fn subject(bench: &mut Bench<'_>, transmission_type: u8) -> Result<Subject, Stop> {
    let (mapped, other) = bench.changeable()?;
    let before = bench.read(mapped.at)?;
    bench.write(mapped.at, &before)?;
    bench.set_mapping(TPDO, &[mapped])?;
    let none = 0_u16.to_le_bytes();
    bench.set_pdo(TPDO, &[(3, &none), (5, &none), (2, &[transmission_type])])?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    Ok(Subject { at: mapped.at, can_id, values: [before, other] })
}

fn operational(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.command(Command::START)?;
    bench.listen(SHORTLY).map(|_| ())
}

fn sync(bench: &mut Bench<'_>, subject: &Subject) -> Result<Vec<Record>, Stop> {
    let id = bench.sync_id()?;
    bench.drain()?;
    bench.send_bytes(id, &[])?;
    bench.frames_of(subject.can_id, Duration::from_millis(50))
}

fn remote(bench: &mut Bench<'_>, subject: &Subject) -> Result<Vec<Record>, Stop> {
    bench.drain()?;
    if let Some(request) = Frame::remote(CanId::standard_masked(u32::from(subject.can_id)), 8) {
        bench.send(&request)?;
    }
    let heard = bench.frames_of(subject.can_id, SHORTLY)?;
    Ok(heard.into_iter().filter(|record| !record.frame.is_remote()).collect())
}

/// A TPDO of transmission type 0 is sent with the SYNC after a change of its value, and with no other.
#[case(id = "301/tpdo/acyclic", clause = "CiA 301 7.2.2.2", confidence = Known, level = Must,
       needs = [Changeable, Sync], catches = [AcyclicTpdoWithoutEvent], cct = "3.7")]
fn acyclic(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 0)?;
    operational(bench)?;
    // Becoming operational may count as an event.
    sync(bench, &subject)?;
    let without = sync(bench, &subject)?.len() + sync(bench, &subject)?.len();
    demand(without == 0, || {
        Reason::new("without a change SYNC causes no TPDO of type 0", "none", format!("{without}"))
    })?;
    bench.write(subject.at, &subject.values[1])?;
    let after = sync(bench, &subject)?.len();
    let then = sync(bench, &subject)?.len();
    bench.check(demand((after, then) == (1, 0), || {
        let actual = format!("{after} with the first SYNC, {then} with the second");
        Reason::new("a change causes one TPDO of type 0 with the next SYNC", "1 and 0", actual)
    }))
}

/// A synchronous TPDO follows each SYNC at once. Median and maximum of the delay are reported.
#[case(id = "301/tpdo/sync-latency", clause = "CiA 301 7.2.2.2", confidence = Known, level = Must,
       needs = [Changeable, Sync], catches = [SyncOverlooked, SyncTpdoLate], cct = "3.6")]
fn sync_latency(bench: &mut Bench<'_>) -> Judged {
    const SYNCS: usize = 50;
    const LATEST: Duration = Duration::from_millis(20);
    // SYNC itself, what is on the wire, and the TPDO.
    let latest_allowed = LATEST + bench.bus_delay() + bench.bus_delay();
    let subject = subject(bench, 1)?;
    let id = bench.sync_id()?;
    operational(bench)?;
    let mut delays = Vec::with_capacity(SYNCS);
    for _ in 0..SYNCS {
        bench.drain()?;
        let sent = bench.now();
        bench.send_bytes(id, &[])?;
        let heard = bench.frames_of(subject.can_id, Duration::from_millis(50))?;
        delays.extend(heard.first().map(|record| record.timestamp.since(sent)));
    }
    for (name, percent) in [("median", 50), ("95 %", 95), ("maximum", 100)] {
        if let Some(delay) = percentile(&mut delays, percent) {
            bench.measure(format!("SYNC to TPDO, {name}"), delay);
        }
    }
    demand(delays.len() == SYNCS, || {
        let actual = format!("{} of {SYNCS}", delays.len());
        Reason::new("every SYNC is followed by a TPDO of type 1", format!("{SYNCS} within 50 ms"), actual)
    })?;
    let latest = delays.last().copied().unwrap_or(Duration::ZERO);
    bench.check(demand(latest <= latest_allowed, || {
        let expected = format!("{latest_allowed} at most");
        Reason::new("a TPDO of type 1 follows SYNC at once", expected, latest.to_string())
    }))
}

/// The count of SYNCs of a TPDO of type n begins anew when the device becomes operational.
#[case(id = "301/tpdo/sync-count-restarts", clause = "CiA 301 7.2.2.2", confidence = Known, level = Should,
       needs = [Changeable, Sync], catches = [SyncCountNotReset, NmtEnterPreOperationalIgnored])]
fn sync_count_restarts(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 3)?;
    operational(bench)?;
    // After a first cycle two of the three SYNCs of the next are sent.
    for _ in 0..5 {
        sync(bench, &subject)?;
    }
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(SHORTLY)?;
    operational(bench)?;
    let heard = [sync(bench, &subject)?.len(), sync(bench, &subject)?.len(), sync(bench, &subject)?.len()];
    bench.check(demand(heard == [0, 0, 1], || {
        let actual = format!("{heard:?}");
        Reason::new("with type 3 the third SYNC after the start causes a TPDO", "[0, 0, 1]", actual)
    }))
}

/// A change of its value sends an event-driven TPDO at once.
#[case(id = "301/tpdo/change", clause = "CiA 301 7.2.2.3", confidence = Known, level = Should,
       needs = [Changeable], catches = [TpdoLostAfterSdo, SdoSilentWhenOperational], cct = "3.4")]
fn change(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 254)?;
    operational(bench)?;
    bench.drain()?;
    // The TPDO may be faster than the confirmation.
    bench.send_request(&Request::download(subject.at, &subject.values[1]))?;
    let heard = bench.frames_of(subject.can_id, SHORTLY)?;
    bench.check(demand(heard.iter().any(|record| record.data() == subject.values[1]), || {
        let shown = heard.last().map_or_else(|| "none".to_owned(), |record| Bytes(record.data()).to_string());
        let expected = format!("one with {} within {SHORTLY}", Bytes(&subject.values[1]));
        Reason::new(format!("a change of {} sends TPDO 1", subject.at), expected, shown)
    }))
}

/// When the device becomes operational, event-driven TPDOs are sent once.
#[case(id = "301/tpdo/at-start", clause = "CiA 301 7.2.2.3", confidence = Known, level = Should,
       needs = [Changeable], catches = [TpdoNotSentAtStart])]
fn at_start(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 254)?;
    bench.drain()?;
    bench.command(Command::START)?;
    let heard = bench.frames_of(subject.can_id, SHORTLY)?;
    bench.check(demand(!heard.is_empty(), || {
        Reason::new("an event-driven TPDO is sent when the device becomes operational", "one", "none")
    }))
}

/// An event timer of 10 ms is kept on average: not a tick too long.
#[case(id = "301/tpdo/event-timer-mean", clause = "CiA 301 7.2.2.3", confidence = Known, level = Must,
       needs = [EventTimer], catches = [EventTimerOffByOne, EventTimerDoubled])]
fn event_timer_mean(bench: &mut Bench<'_>) -> Judged {
    const PERIOD: Duration = Duration::from_millis(20);
    const PERIODS: u64 = 50;
    let transmission_type = bench.read_number(TPDO.parameter(2))?;
    if transmission_type < 254 {
        bench.set_pdo(TPDO, &[(2, &[255])])?;
    }
    bench.write(TPDO.parameter(5), &20_u16.to_le_bytes())?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    operational(bench)?;
    let heard = bench.frames_of(can_id, PERIOD.times(PERIODS))?;
    let span = heard.first().zip(heard.last()).map(|(first, last)| last.timestamp.since(first.timestamp));
    let gaps = u64::try_from(heard.len().saturating_sub(1)).unwrap_or(0);
    let mean = span.filter(|_| gaps > 0).map_or(Duration::ZERO, |span| Duration::from_nanos(span.nanos() / gaps));
    bench.measure("TPDO period with an event timer of 20 ms", mean);
    // Over so many periods the ticks of a timer average out; value changes make the mean shorter, never longer.
    let limit = Duration::from_micros(20_800) + Duration::from_nanos(bench.bus_delay().nanos() / PERIODS);
    bench.check(demand(gaps > 0 && mean <= limit, || {
        let actual = if gaps == 0 { "fewer than two TPDOs".to_owned() } else { mean.to_string() };
        Reason::new("with an event timer of 20 ms TPDO 1 comes every 20 ms", format!("{limit} at most"), actual)
    }))
}

/// The inhibit time counts in 100 microseconds: with 1000 a TPDO may come every 100 ms.
#[case(id = "301/tpdo/inhibit-unit", clause = "CiA 301 7.5.2.37", confidence = Attested, level = Must,
       needs = [EventTimer, DynamicMapping], catches = [InhibitTimeInMilliseconds])]
fn inhibit_unit(bench: &mut Bench<'_>) -> Judged {
    bench.set_pdo(TPDO, &[(2, &[255]), (3, &1_000_u16.to_le_bytes()), (5, &50_u16.to_le_bytes())])?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    operational(bench)?;
    let heard = bench.frames_of(can_id, Duration::from_millis(1_050))?;
    bench.check(demand((8..=11).contains(&heard.len()), || {
        let duty = "with an inhibit time of 1000 (100 ms) and a shorter event timer TPDO 1 comes every 100 ms";
        Reason::new(duty, "10 in 1.05 s, give or take one", heard.len().to_string())
    }))
}

/// A TPDO of transmission type 253 is sent when a remote frame asks for it.
#[case(id = "301/tpdo/remote-triggered", clause = "CiA 301 7.2.2.3", confidence = Known, level = Should,
       needs = [Changeable], catches = [TpdoRemoteIgnored], cct = "3.3")]
fn on_remote(bench: &mut Bench<'_>) -> Judged {
    let subject = remote_subject(bench, 253)?;
    operational(bench)?;
    let heard = remote(bench, &subject)?;
    bench.check(demand(heard.len() == 1, || {
        Reason::new("a remote frame is answered by TPDO 1 of type 253", "one TPDO", format!("{}", heard.len()))
    }))
}

/// A TPDO of transmission type 252 holds the values at the last SYNC when a remote frame asks for it.
#[case(id = "301/tpdo/remote-sampled", clause = "CiA 301 7.2.2.3", confidence = Known, level = Should,
       needs = [Changeable, Sync], catches = [RtrTypeSampledAtOnce])]
fn remote_sampled(bench: &mut Bench<'_>) -> Judged {
    let subject = remote_subject(bench, 252)?;
    operational(bench)?;
    sync(bench, &subject)?;
    bench.write(subject.at, &subject.values[1])?;
    let heard = remote(bench, &subject)?;
    let Some(answer) = heard.first() else {
        let reason = Reason::new("a remote frame is answered by TPDO 1 of type 252", "a TPDO", "none");
        return Err(Stop::from(reason));
    };
    bench.check(demand(answer.data() == subject.values[0], || {
        let duty = "TPDO 1 of type 252 has the value of the last SYNC, not of now";
        Reason::new(duty, Bytes(&subject.values[0]).to_string(), Bytes(answer.data()).to_string())
    }))
}

/// Lets TPDO 1 answer remote frames; not applicable where the device refuses that.
fn remote_subject(bench: &mut Bench<'_>, transmission_type: u8) -> Result<Subject, Stop> {
    let subject = subject(bench, 255)?;
    let own = bench.pdo_off(TPDO)?;
    let with_remote = CobId(own.0 & !(CobId::NO_RTR | CobId::INVALID));
    let off = (with_remote.0 | CobId::INVALID).to_le_bytes();
    for (multiplexer, value) in [(TPDO.parameter(1), off.to_vec()), (TPDO.parameter(2), vec![transmission_type])] {
        if let Some(code) = bench.download(multiplexer, &value)?.abort() {
            let duty = format!("TPDO 1 can have type {transmission_type}");
            return Err(Stop::NotApplicable(Reason::new(duty, "remote frames", format!("abort {code}"))));
        }
    }
    bench.pdo_on(TPDO, with_remote)?;
    Ok(subject)
}

/// A remote frame for a TPDO with bit 30 of its COB-ID set is not answered.
#[case(id = "301/tpdo/remote-forbidden", clause = "CiA 301 7.5.2.37", confidence = Attested, level = Must,
       needs = [Changeable], catches = [RemoteFrameAnsweredWhenNotAllowed])]
fn remote_forbidden(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 255)?;
    let own = bench.pdo_off(TPDO)?;
    bench.pdo_on(TPDO, CobId(own.0 | CobId::NO_RTR))?;
    operational(bench)?;
    let heard = remote(bench, &subject)?;
    bench.check(demand(heard.is_empty(), || {
        Reason::new(
            "a remote frame is not answered where bit 30 forbids it",
            "silence",
            format!("{} TPDO", heard.len()),
        )
    }))
}

/// With a SYNC start value and a SYNC counter the first TPDO follows the SYNC of that number.
#[case(id = "301/tpdo/sync-start", clause = "CiA 301 7.5.2.37", confidence = Attested, level = Must,
       needs = [Changeable, SyncCounter], catches = [SyncStartValueIgnored], cct = "3.8")]
fn sync_start(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 1)?;
    if !bench.can_write(TPDO.parameter(6))? {
        let reason = Reason::new("TPDO 1 has a SYNC start value", "1800h:06", "absent or read-only");
        return Err(Stop::NotApplicable(reason));
    }
    bench.write(Multiplexer::new(0x1006, 0), &0_u32.to_le_bytes())?;
    bench.write(Multiplexer::new(0x1019, 0), &[10])?;
    bench.set_pdo(TPDO, &[(6, &[3])])?;
    let id = bench.sync_id()?;
    operational(bench)?;
    let mut first = None;
    for counter in 1..=10_u8 {
        bench.drain()?;
        bench.send_bytes(id, &[counter])?;
        if !bench.frames_of(subject.can_id, Duration::from_millis(30))?.is_empty() {
            first = first.or(Some(counter));
        }
    }
    bench.check(demand(first == Some(3), || {
        let actual = first.map_or_else(|| "none in ten SYNCs".to_owned(), |n| format!("SYNC {n}"));
        Reason::new("with a SYNC start value of 3 the first TPDO follows SYNC 3", "SYNC 3", actual)
    }))
}

/// A TPDO has as many bytes as its mapping.
#[case(id = "301/tpdo/length", clause = "CiA 301 7.2.2", confidence = Known, level = Must,
       needs = [EventTimer], catches = [TpdoTooLong])]
fn length(bench: &mut Bench<'_>) -> Judged {
    let bits: u32 = bench.mapping(TPDO)?.iter().map(|mapped| u32::from(mapped.bits)).sum();
    let length = bits.div_ceil(8) as usize;
    let transmission_type = bench.read_number(TPDO.parameter(2))?;
    if transmission_type < 254 {
        bench.set_pdo(TPDO, &[(2, &[255])])?;
    }
    bench.write(TPDO.parameter(5), &100_u16.to_le_bytes())?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    operational(bench)?;
    let heard = bench.frames_of(can_id, Duration::from_millis(300))?;
    let Some(first) = heard.first() else {
        let reason = Reason::new("TPDO 1 is sent", "one every 100 ms", "none in 300 ms");
        return Err(Stop::Inconclusive(reason));
    };
    bench.check(demand(heard.iter().all(|record| record.data().len() == length), || {
        let actual = format!("{} bytes", first.data().len());
        Reason::new(format!("TPDO 1 maps {bits} bits"), format!("{length} bytes"), actual)
    }))
}
