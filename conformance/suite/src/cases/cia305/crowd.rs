//! LSS with several slaves on the bus: the tester acts as the others.

use super::dialogue::{
    address, breach, expect, expect_configuration, expect_silence, observed, set_node_id, tell, wait,
};
use super::fastscan::RESET;
use super::unconfigured::unconfigured;
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::hear;
use crate::verdict::{Judged, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss::{self, Bound, Request, Response};
use canvass_bus::observation::Observation;

/// The device's answer to a Fastscan message that another slave answers at the same time.
fn scan_together(bench: &mut Bench<'_>, request: Request) -> Result<Option<Response>, Stop> {
    bench.drain()?;
    bench.send(&request.to_frame(lss::MASTER_CAN_ID))?;
    bench.send(&Response::Identified.to_frame(lss::SLAVE_CAN_ID))?;
    hear(bench, bench.timing().lss)
}

/// When several slaves answer, each of them continues to take part in Fastscan. A slave that has received its node-ID
/// takes no further part, so that the next scan finds the others.
#[case(id = "305/fastscan/several-slaves", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone, Fastscan], touches = [NodeId],
       catches = [FastscanYieldsToOthers, FastscanAnsweredWhenConfigured])]
fn several(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        for (sub, part) in (0..4_u8).zip(address) {
            let steps = [(0, RESET, 0, 0), (part & 0x8000_0000, 31, sub, sub), (part, 0, sub, (sub + 1) % 4)];
            for &(id, bit_check, sub, next) in if sub == 0 { &steps[..] } else { &steps[1..] } {
                let answer = scan_together(bench, Request::Fastscan { id, bit_check, sub, next })?;
                let what = format!("beside another slave, a Fastscan that fits part {sub}");
                let expected = observed(Some(Response::Identified));
                expect(&what, expected, answer, |answer| answer == Response::Identified)?;
            }
        }
        expect_configuration(bench, "a Fastscan with another slave")?;
        let own = bench.node().raw();
        set_node_id(bench, own)?;
        wait(bench)?;
        bench.wait_for_boot_up()?;
        let answer = tell(bench, Request::Fastscan { id: 0, bit_check: RESET, sub: 0, next: 0 })?;
        bench.check(expect_silence("the begin of Fastscan by a slave that has received its node-ID", answer))
    })
}

/// The master finds the revision number and the serial number of a slave by halving their ranges, without Fastscan.
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
        let bytes = |parts: [u32; 2]| Observation::Value(parts.iter().flat_map(|part| part.to_le_bytes()).collect());
        let breach = breach("halving the ranges finds revision and serial number, 1018h:03 and 04");
        let told = format!("revision {:08X}h, serial number {:08X}h", found[0], found[1]);
        breach.expected(bytes([own[2], own[3]])).found(bytes(found)).told(told)
    }))
}

fn is_within(bench: &mut Bench<'_>, bounds: [u32; 6]) -> Result<bool, Stop> {
    let last = Bound::ALL.len() - 1;
    let mut answered = false;
    for (n, (bound, value)) in Bound::ALL.into_iter().zip(bounds).enumerate() {
        let request = Request::IdentifyRemote { bound, value };
        if n < last {
            // Only the last of the six messages is answered: the others need no wait.
            bench.send(&request.to_frame(lss::MASTER_CAN_ID))?;
        } else {
            answered = tell(bench, request)? == Some(Response::Identified);
        }
    }
    Ok(answered)
}
