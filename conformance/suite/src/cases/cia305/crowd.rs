//! LSS with more than one slave on the bus: the tester plays the others.

use super::dialogue::{address, configure, exchange, expect_silence, wait};
use super::fastscan::{RESET, scan, unconfigured};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss::{self, Bound, Request, Response};

/// Whether a Fastscan message is answered while another slave answers it too.
fn scan_together(bench: &mut Bench<'_>, id: u32, bit_check: u8, sub: u8, next: u8) -> Result<bool, Stop> {
    bench.drain()?;
    bench.send(&Request::Fastscan { id, bit_check, sub, next }.to_frame(lss::MASTER_CAN_ID))?;
    bench.send(&Response::Identified.to_frame(lss::SLAVE_CAN_ID))?;
    let answer = bench.wait_for(bench.timing().silence, |record| {
        let is_slave = record.frame.cob_id() == Some(lss::SLAVE_CAN_ID);
        is_slave.then(|| Response::read(record.frame.data()).ok()).flatten()
    })?;
    Ok(answer.is_some())
}

/// Where several slaves answer, each goes on taking part in Fastscan; the one that got its node-ID does not any more, so
/// that the next scan finds the others.
#[case(id = "305/fastscan/several-slaves", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [FastscanYieldsToOthers, FastscanAnsweredWhenConfigured])]
fn several(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        let own = bench.node().raw();
        for (sub, part) in (0..4_u8).zip(address) {
            let steps = [(0, RESET, 0, 0), (part & 0x8000_0000, 31, sub, sub), (part, 0, sub, (sub + 1) % 4)];
            for &(id, bit_check, sub, next) in if sub == 0 { &steps[..] } else { &steps[1..] } {
                demand(scan_together(bench, id, bit_check, sub, next)?, || {
                    let duty = format!("a slave whose part {sub} fits answers beside another slave");
                    Reason::new(duty, "4Fh", "silence")
                })?;
            }
        }
        super::dialogue::expect_configuration(bench, "a Fastscan with another slave")?;
        exchange(bench, Request::ConfigureNodeId { node_id: own })?;
        bench.watch_restart();
        wait(bench)?;
        bench.listen(canvass_traces::Duration::from_millis(1_000))?;
        let answer = scan(bench, 0, RESET, 0, 0)?;
        bench.check(expect_silence("the begin of Fastscan by a slave that got its node-ID", answer))
    })
}

/// A slave is found by halving the ranges of revision and serial number, without Fastscan.
#[case(id = "305/identify/halving", clause = "CiA 305 6.6.2", confidence = Attested, level = Should,
       needs = [Lss, Alone], catches = [LssIdentifyUnanswered, LssIdentifyUnchecked, LssIdentifyRangeExclusive,
       WatchdogResetUnderLoad])]
fn halving(bench: &mut Bench<'_>) -> Judged {
    let own = address(bench)?;
    let mut found = [0_u32; 2];
    for place in 0..2 {
        let (mut low, mut high) = (0_u32, u32::MAX);
        while low < high {
            let middle = low + (high - low) / 2;
            let mut bounds = [own[0], own[1], 0, u32::MAX, 0, u32::MAX];
            if place == 1 {
                (bounds[2], bounds[3]) = (found[0], found[0]);
            }
            (bounds[2 + 2 * place], bounds[3 + 2 * place]) = (low, middle);
            match is_within(bench, bounds)? {
                true => high = middle,
                false => low = middle + 1,
            }
        }
        if let Some(part) = found.get_mut(place) {
            *part = low;
        }
    }
    bench.check(demand(found == [own[2], own[3]], || {
        let shown = |parts: [u32; 2]| format!("revision {:08X}h, serial number {:08X}h", parts[0], parts[1]);
        Reason::new("halving the ranges finds the slave", shown([own[2], own[3]]), shown(found))
    }))
}

fn is_within(bench: &mut Bench<'_>, bounds: [u32; 6]) -> Result<bool, Stop> {
    let last = Bound::ALL.len() - 1;
    let mut answered = false;
    for (n, (bound, value)) in Bound::ALL.into_iter().zip(bounds).enumerate() {
        let request = Request::IdentifyRemote { bound, value };
        if n < last {
            // Only the last of the six is answered: the others need no wait.
            bench.send(&request.to_frame(lss::MASTER_CAN_ID))?;
        } else {
            answered = exchange(bench, request)? == Some(Response::Identified);
        }
    }
    Ok(answered)
}

/// A node-ID that was configured but not stored is lost with reset node: the device has its old one.
#[case(id = "305/node-id/not-stored", clause = "CiA 305 6.4.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdStoredAtOnce])]
fn not_stored(bench: &mut Bench<'_>) -> Judged {
    use canvass_analyzer::wire::nmt::Command;
    let own = bench.node().raw();
    let other = if own == 101 { 102 } else { 101 };
    configure(bench)?;
    let answer = exchange(bench, Request::ConfigureNodeId { node_id: other })?;
    wait(bench)?;
    demand(matches!(answer, Some(Response::Configured { error: 0, .. })), || {
        Reason::new("a node-ID can be configured", "error code 0", super::dialogue::shown(answer))
    })
    .or_inconclusive()?;
    bench.listen(canvass_traces::Duration::from_millis(500))?;
    bench.command_all(Command::RESET_NODE)?;
    let boot_up = bench.wait_for_boot_up()?;
    let is_back = boot_up.is_some() || bench.answers()?;
    if !is_back {
        give_back(bench, own)?;
    }
    bench.check(demand(is_back, || {
        let duty = format!("after reset node a node-ID that was not stored is lost: the device is node {own}");
        Reason::new(duty, format!("a boot-up message of node {own}"), format!("none; it may be node {other}"))
    }))
}

/// The device gets its own node-ID again, stored if the other one was.
fn give_back(bench: &mut Bench<'_>, own: u8) -> Result<(), Stop> {
    use canvass_analyzer::wire::nmt::Command;
    configure(bench)?;
    exchange(bench, Request::ConfigureNodeId { node_id: own })?;
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    bench.listen(canvass_traces::Duration::from_millis(1_000)).map(|_| ())
}
