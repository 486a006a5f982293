//! The synchronous window (1007h), and the first effective SYNC after the start.

use crate::bench::pdo::TPDO;
use crate::bench::{Bench, Exhibit, KEEPS_UP};
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Record};

const WINDOW: Multiplexer = Multiplexer::new(object::SYNCHRONOUS_WINDOW_LENGTH, 0);
const OVERFLOW: Multiplexer = Multiplexer::new(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0);
const WINDOW_US: u32 = 5_000;
/// A CAN-ID that nobody uses, with a higher priority than every PDO.
const IN_THE_WAY: u16 = 0x07F;
/// Number of full frames that take 8 ms at 1 Mbit/s, and longer at any other bit rate.
const FRAMES: usize = 70;

/// Sets TPDO 1 to type 1 without event timer; returns its CAN-ID.
pub(super) fn synchronous(bench: &mut Bench<'_>) -> Result<u16, Stop> {
    bench.expect_plain_sync()?;
    bench.set_pdo(TPDO, &[(2, &[1])])?;
    if bench.can_write(TPDO.parameter(5))? {
        bench.set_event_timer(TPDO, 0)?;
    }
    Ok((bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16)
}

/// The breach of a number of TPDOs other than `right`.
pub(super) fn counted(duty: &'static str, right: u64, found: usize) -> Breach {
    let expected = Allowed::Count { least: right, most: Some(right) };
    let tpdo = Subject::Pdo { transmit: true, number: 1 };
    Breach::new(tpdo, duty).expected(expected).found(Observation::Count(found as u64))
}

pub(super) fn count(heard: &[Record], can_id: u16) -> usize {
    heard.iter().filter(|record| record.frame.cob_id() == Some(can_id)).count()
}

/// The case only records whether the device still sends a synchronous TPDO that could not be sent within the
/// synchronous window (1007h). The device may discard such a TPDO.
#[case(id = "301/sync/window", clause = "CiA 301 7.5.2.7", confidence = Cited, level = Open,
       needs = [EventTimer, Sync, DynamicMapping], catches = [SyncWindowIgnored])]
fn window(bench: &mut Bench<'_>) -> Judged {
    if !bench.can_write(WINDOW)? {
        return Err(Stop::NotApplicable(Reason::new("the device has a synchronous window", "1007h", "none")));
    }
    if bench.bit_rate().is_none() {
        // On a bus without wires, frames do not delay each other.
        let reason = Reason::new("the transmission time of frames is known", "a known bit rate", "none, as on a vcan");
        return Err(Stop::NotApplicable(reason));
    }
    let can_id = synchronous(bench)?;
    let sync = bench.sync_id()?;
    bench.write(WINDOW, &WINDOW_US.to_le_bytes())?;
    bench.command(Command::START)?;
    bench.listen(Duration::from_millis(100))?;
    bench.drain()?;
    bench.send_bytes(sync, &[])?;
    let free = bench.listen(Duration::from_millis(50))?;
    demand(count(&free, can_id) == 1, || {
        counted("with a free bus TPDO 1 comes within the window of 5 ms", 1, count(&free, can_id))
    })
    .or_inconclusive()?;
    bench.send_bytes(sync, &[])?;
    for _ in 0..FRAMES {
        bench.send_bytes(IN_THE_WAY, &[0xFF; 8])?;
    }
    let heard = bench.listen(Duration::from_millis(200))?;
    let late = count(&heard, can_id);
    if late == 1 && !came_after_the_window(bench, sync, can_id) {
        // The bus was free between two frames of the tester, so the TPDO came in time.
        return Err(Stop::Inconclusive(free_in_between(bench, sync)));
    }
    bench.check(demand(late == 0, || {
        counted("a TPDO that could not be sent within 1007h = 5000 µs is not sent at all", 0, late)
    }))
}

/// The reason why a TPDO was sent although frames of the tester should have blocked it: the tester's machine paused
/// while it sent, or the device found a gap.
fn free_in_between(bench: &Bench<'_>, sync: u16) -> Reason {
    const LONGEST_GAP: Duration = Duration::from_millis(1);
    let own = |exhibit: &&Exhibit| matches!(exhibit.record.frame.cob_id(), Some(id) if id == sync || id == IN_THE_WAY);
    let sent: Vec<_> = bench.evidence().frames().filter(own).map(|exhibit| exhibit.record.timestamp).collect();
    let crowd = sent.get(sent.len().saturating_sub(FRAMES + 1)..).unwrap_or_default();
    let gap = crowd.iter().zip(crowd.iter().skip(1)).map(|(before, after)| after.since(*before)).max();
    match gap.filter(|&gap| gap > LONGEST_GAP) {
        Some(gap) => {
            Reason::new(KEEPS_UP, "frames without a gap between them", format!("a gap of {gap} between two frames"))
        }
        None => Reason::new("the bus is busy while the window is open", "no gap", "a TPDO was sent immediately"),
    }
}

/// Whether the synchronous window was over when the last TPDO came. Not every adapter reports when the tester's own
/// frames were on the bus.
fn came_after_the_window(bench: &Bench<'_>, sync: u16, can_id: u16) -> bool {
    let last = |id: u16| {
        let of_id = bench.evidence().frames().filter(|exhibit| exhibit.record.frame.cob_id() == Some(id));
        of_id.last().map(|exhibit| exhibit.record.timestamp)
    };
    let after = last(can_id).zip(last(sync)).map(|(tpdo, sync)| tpdo.since(sync));
    after.is_some_and(|after| after > Duration::from_micros(WINDOW_US.into()))
}

/// A TPDO without SYNC start value follows each SYNC with a counter, whatever the counter value is.
#[case(id = "301/sync/counter-obeyed", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [EventTimer, SyncCounter, DynamicMapping], catches = [SyncWithoutStartValueIgnored])]
fn counter_obeyed(bench: &mut Bench<'_>) -> Judged {
    let can_id = synchronous(bench)?;
    bench.stop_sync_period()?;
    bench.write(OVERFLOW, &[4])?;
    if bench.can_write(TPDO.parameter(6))? {
        bench.set_pdo(TPDO, &[(6, &[0])])?;
    }
    let sync = bench.sync_id()?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    bench.each([2, 3, 4, 1], |bench, counter| {
        bench.drain()?;
        bench.send_bytes(sync, &[counter])?;
        let heard = bench.frames_of(can_id, bench.shortly())?;
        bench.check(demand(heard.len() == 1, || {
            counted("with 1019h = 4 and no SYNC start value a TPDO of type 1 follows each SYNC", 1, heard.len())
        }))
    })
}

/// A SYNC in pre-operational has no effect: the first synchronous TPDO follows the first SYNC after the start.
#[case(id = "301/sync/before-start", clause = "CiA 301 7.3.2.2.2", confidence = Cited, level = Must,
       needs = [EventTimer, Sync, DynamicMapping], catches = [SyncRememberedOverStart, TpdoInPreOperational])]
fn before_start(bench: &mut Bench<'_>) -> Judged {
    let can_id = synchronous(bench)?;
    let sync = bench.sync_id()?;
    bench.drain()?;
    bench.send_bytes(sync, &[])?;
    let before = bench.listen(Duration::from_millis(50))?;
    bench.command(Command::START)?;
    let started = bench.listen(Duration::from_millis(100))?;
    bench.send_bytes(sync, &[])?;
    let after = bench.listen(Duration::from_millis(50))?;
    let [before, started, after] = [&before, &started, &after].map(|heard| count(heard, can_id));
    bench.check(demand(before == 0, || counted("a SYNC in pre-operational causes no TPDO", 0, before)))?;
    bench.check(demand(started == 0, || {
        counted("a SYNC in pre-operational causes no TPDO after the start", 0, started)
    }))?;
    bench.check(demand(after == 1, || counted("TPDO 1 of type 1 follows the first SYNC in operational", 1, after)))
}
