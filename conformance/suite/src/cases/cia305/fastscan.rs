//! Fastscan (CiA 305, 6.7): a slave without node-ID is found by halving.
//!
//! The device has its node-ID taken away for these cases, and gets it back.

use super::dialogue::{address, configure, exchange, expect, expect_silence, node_id, wait};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss::{self, Request, Response};
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::Duration;

pub(super) const RESET: u8 = 0x80;

/// Runs `test` while the device has no node-ID; gives it its own back afterwards, whatever came of it.
pub(super) fn unconfigured(bench: &mut Bench<'_>, test: impl FnOnce(&mut Bench<'_>, [u32; 4]) -> Judged) -> Judged {
    let address = address(bench)?;
    configure(bench)?;
    let answer = exchange(bench, Request::ConfigureNodeId { node_id: 255 })?;
    let taken = matches!(answer, Some(Response::Configured { error: 0, .. }));
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    bench.listen(Duration::from_millis(1_000))?;
    let mut is_gone = taken && !bench.answers()?;
    if taken && !is_gone {
        // It may say that it has no node-ID, and answer SDOs all the same: that is the matter of a case.
        configure(bench)?;
        is_gone = node_id(bench)? == Some(255);
        wait(bench)?;
    }
    let judged = match is_gone {
        true => test(bench, address),
        false => Err(Stop::NotApplicable(Reason::new(
            "the node-ID can be taken away by LSS",
            "a device without node-ID",
            "it keeps its node-ID",
        ))),
    };
    // What happened in the case counts, not that the device can't be configured after it.
    let configured = bench.uncancelled(give_back);
    judged.and_then(|verdict| configured.map(|()| verdict))
}

fn give_back(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let own = bench.node().raw();
    configure(bench)?;
    exchange(bench, Request::ConfigureNodeId { node_id: own })?;
    wait(bench)?;
    bench.listen(Duration::from_millis(500))?;
    // A device that had a node-ID waits for the reset.
    bench.command_all(Command::RESET_COMMUNICATION)?;
    bench.listen(Duration::from_millis(1_000)).map(|_| ())
}

pub(super) fn scan(bench: &mut Bench<'_>, id: u32, bit_check: u8, sub: u8, next: u8) -> Result<Option<Response>, Stop> {
    exchange(bench, Request::Fastscan { id, bit_check, sub, next })
}

/// A device without node-ID is silent but for LSS: no boot-up message, no SDO.
#[case(id = "305/unconfigured/silent", clause = "CiA 305", confidence = Unknown, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [UnconfiguredNodeBoots])]
fn silent(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        bench.command_all(Command::RESET_NODE)?;
        let mut heard = None;
        bench.wait_for(Duration::from_millis(1_500), |record| {
            heard = heard.or(Some(record.frame));
            None::<()>
        })?;
        demand(heard.is_none(), || {
            let actual = heard.map(|frame| frame.to_string()).unwrap_or_default();
            Reason::new("a device without node-ID sends nothing after a reset", "silence", actual)
        })?;
        let answers = bench.answers()?;
        bench.check(demand(!answers, || {
            Reason::new("a device without node-ID answers no SDO request", "silence", "an answer")
        }))
    })
}

/// A device without node-ID answers the search for such devices by 50h.
#[case(id = "305/unconfigured/identify", clause = "CiA 305 6.6.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssIdentifyUnanswered])]
fn identify(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        let answer = exchange(bench, Request::IdentifyNonConfigured)?;
        bench.check(expect("the search for slaves without node-ID", "50h", answer, |answer| {
            answer == Response::NonConfigured
        }))
    })
}

/// A device that gets a node-ID by LSS boots with it when configuration ends.
#[case(id = "305/unconfigured/boots", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [UnconfiguredNodeIdWaits, BootUpMissing, BootUpWrongData])]
fn boots(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        let own = bench.node().raw();
        configure(bench)?;
        exchange(bench, Request::ConfigureNodeId { node_id: own })?;
        bench.watch_restart();
        bench.drain()?;
        bench.send(&Request::SwitchGlobal { mode: 0 }.to_frame(lss::MASTER_CAN_ID))?;
        let boot_up = bench.wait_for_boot_up()?;
        bench.check(demand(boot_up.is_some(), || {
            let duty = "a device that had no node-ID boots with the one that it got";
            Reason::new(duty, format!("a boot-up message of node {own}"), "none")
        }))
    })
}

/// The inquiry of the node-ID of a device without one gives 255.
#[case(id = "305/unconfigured/inquiry", clause = "CiA 305 6.5.3", confidence = Attested, level = Should,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdInquiredWrong])]
fn inquiry(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        configure(bench)?;
        let given = node_id(bench)?;
        wait(bench)?;
        bench.check(demand(given == Some(255), || {
            let actual = given.map_or_else(|| "no answer".to_owned(), |node| node.to_string());
            Reason::new("a device without node-ID says so", "255", actual)
        }))
    })
}

/// Fastscan begins with a message that every device without node-ID answers.
#[case(id = "305/fastscan/begin", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [FastscanUnanswered])]
fn begin(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        let answer = scan(bench, 0, RESET, 0, 0)?;
        bench.check(expect("the begin of Fastscan", "4Fh", answer, |answer| answer == Response::Identified))
    })
}

/// Finds the address bit by bit; returns it as far as it was found.
fn find(bench: &mut Bench<'_>) -> Result<[u32; 4], Stop> {
    let mut found = [0_u32; 4];
    scan(bench, 0, RESET, 0, 0)?;
    for sub in 0..4_u8 {
        let mut id = 0_u32;
        for bit in (0..32_u8).rev() {
            // Without an answer the bit is 1.
            if scan(bench, id, bit, sub, sub)?.is_none() {
                id |= 1 << bit;
            }
        }
        let next = if sub == 3 { 0 } else { sub + 1 };
        if scan(bench, id, 0, sub, next)?.is_none() {
            break;
        }
        if let Some(part) = found.get_mut(usize::from(sub)) {
            *part = id;
        }
    }
    Ok(found)
}

/// Fastscan finds the whole address, and the device found is then in configuration.
#[case(id = "305/fastscan/find", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [FastscanUnanswered, FastscanIgnoresBits])]
fn find_all(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        let found = find(bench)?;
        demand(found == address, || {
            let shown = |address: [u32; 4]| address.map(|part| format!("{part:08X}h")).join(" ");
            Reason::new("Fastscan finds the LSS address", shown(address), shown(found))
        })?;
        super::dialogue::expect_configuration(bench, "Fastscan")
    })
}

/// A bit that is not that of the device is not answered, be it the one that is looked at or one above it.
#[case(id = "305/fastscan/wrong-bit", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [FastscanIgnoresBits])]
fn wrong_bit(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        scan(bench, 0, RESET, 0, 0)?;
        let answer = scan(bench, address[0] ^ 0x8000_0000, 31, 0, 0)?;
        expect_silence("a Fastscan of another vendor-ID", answer)?;
        let answer = scan(bench, address[0] & 0x8000_0000, 31, 0, 0)?;
        expect("the right bit after it", "4Fh", answer, |answer| answer == Response::Identified)?;
        let answer = scan(bench, (address[0] & 0xC000_0000) ^ 0x8000_0000, 30, 0, 0)?;
        bench.check(expect_silence("a Fastscan with another bit above the one that is looked at", answer))
    })
}

/// Only the last part of the address ends Fastscan: a match of an earlier one does not lead into configuration.
#[case(id = "305/fastscan/early-match", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [FastscanEarlyMatch])]
fn early_match(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        scan(bench, 0, RESET, 0, 0)?;
        scan(bench, address[0], 0, 0, 1)?;
        // The product code matches, and the master goes back to the vendor-ID.
        scan(bench, address[1], 0, 1, 0)?;
        super::dialogue::expect_waiting(bench, "a match of the product code alone")
    })
}

/// Bit checks and parts that don't exist are ignored, and the device goes on working.
#[case(id = "305/fastscan/out-of-range", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [FastscanHangs])]
fn out_of_range(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        scan(bench, 0, RESET, 0, 0)?;
        for (bit_check, sub, next) in [(32, 0, 0), (127, 0, 0), (129, 0, 0), (0, 4, 0), (31, 255, 0), (31, 0, 4)] {
            let answer = scan(bench, 0, bit_check, sub, next)?;
            let what = format!("a Fastscan of bit {bit_check}, part {sub}, next part {next}");
            expect_silence(&what, answer)?;
        }
        let answer = scan(bench, 0, RESET, 0, 0)?;
        bench.check(expect("the begin of Fastscan after it", "4Fh", answer, |answer| answer == Response::Identified))
    })
}

/// A device with a node-ID takes no part in Fastscan.
#[case(id = "305/fastscan/configured", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [FastscanAnsweredWhenConfigured])]
fn with_node_id(bench: &mut Bench<'_>) -> Judged {
    let answer = scan(bench, 0, RESET, 0, 0)?;
    bench.check(expect_silence("the begin of Fastscan with a node-ID", answer))
}
