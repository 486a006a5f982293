//! Fastscan (CiA 305, 6.7): a binary search for the LSS address of a slave without node-ID. Not every slave supports
//! it.
//!
//! The cases take the node-ID away from the device, and set it again afterwards.

use super::dialogue::{
    breach, configure, exchange, expect, expect_configuration, expect_silence, expect_waiting, observed, tell, wait,
};
use super::unconfigured::unconfigured;
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::expect_dialogue;
use crate::verdict::{Check, Judged, Stop, demand};
use canvass_analyzer::wire::lss::{Lss, Request, Response};
use canvass_bus::observation::Observation;

/// The bit check of the message with which a scan begins.
pub(super) const RESET: u8 = 0x80;

/// Sends a message that need not be answered; silence is a valid answer, too.
fn scan(bench: &mut Bench<'_>, id: u32, bit_check: u8, sub: u8, next: u8) -> Result<Option<Response>, Stop> {
    tell(bench, Request::Fastscan { id, bit_check, sub, next })
}

/// Sends the message that every slave without node-ID answers.
pub(super) fn scan_begin(bench: &mut Bench<'_>) -> Result<Option<Response>, Stop> {
    exchange(bench, Request::Fastscan { id: 0, bit_check: RESET, sub: 0, next: 0 })
}

fn expect_match(what: &str, answer: Option<Response>) -> Check {
    let expected = observed(Some(Response::Identified));
    expect(what, expected, answer, |answer| answer == Response::Identified)
}

/// Fastscan begins with a message that every device without node-ID answers, even during another scan: the scan then
/// starts again with the vendor-ID.
#[case(id = "305/fastscan/begin", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone, Fastscan], touches = [NodeId], catches = [FastscanIgnoresBits])]
fn begin(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        let answer = scan_begin(bench)?;
        bench.check(expect_match("the begin of Fastscan", answer))?;
        // The vendor-ID fits, and the product code would be next.
        scan(bench, address[0], 0, 0, 1)?;
        let answer = scan_begin(bench)?;
        bench.check(expect_match("the begin of another Fastscan", answer))?;
        let answer = scan(bench, address[0] ^ 0x8000_0000, 31, 0, 0)?;
        bench.check(expect_silence("after it a Fastscan of another vendor-ID", answer))?;
        let answer = scan(bench, address[0] & 0x8000_0000, 31, 0, 0)?;
        bench.check(expect_match("after it a Fastscan of the first bit of the vendor-ID", answer))?;
        expect_dialogue::<Lss>(bench)
    })
}

/// Finds the address bit by bit; returns the part that was found.
fn find(bench: &mut Bench<'_>) -> Result<[u32; 4], Stop> {
    let mut found = [0_u32; 4];
    scan_begin(bench)?;
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

/// An address as the bytes of its four parts.
fn bytes(address: [u32; 4]) -> Observation {
    Observation::Value(address.iter().flat_map(|part| part.to_le_bytes()).collect())
}

/// Fastscan finds the complete LSS address, after which the device is in configuration.
#[case(id = "305/fastscan/find", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone, Fastscan], touches = [NodeId], catches = [FastscanIgnoresBits])]
fn find_all(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        let found = find(bench)?;
        demand(found == address, || {
            let told = found.map(|part| format!("{part:08X}h")).join(" ");
            breach("Fastscan finds the LSS address, 1018h").expected(bytes(address)).found(bytes(found)).told(told)
        })?;
        expect_configuration(bench, "Fastscan")
    })
}

/// The slave does not answer a Fastscan request whose ID number differs from its own in the checked bit or in a higher
/// bit.
#[case(id = "305/fastscan/wrong-bit", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone, Fastscan], touches = [NodeId], catches = [FastscanIgnoresBits])]
fn wrong_bit(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        scan_begin(bench)?;
        let answer = scan(bench, address[0] ^ 0x8000_0000, 31, 0, 0)?;
        bench.check(expect_silence("a Fastscan of another vendor-ID", answer))?;
        let answer = scan(bench, address[0] & 0x8000_0000, 31, 0, 0)?;
        bench.check(expect_match("the right bit after it", answer))?;
        let answer = scan(bench, (address[0] & 0xC000_0000) ^ 0x8000_0000, 30, 0, 0)?;
        bench.check(expect_silence("a Fastscan with another bit above the checked bit", answer))
    })
}

/// The case only records whether a match of an earlier part than the last one, after which the master goes back, switches
/// the slave to configuration: the master of the standard never does this, and several public slaves switch.
#[case(id = "305/fastscan/early-match", clause = "CiA 305 6.7", confidence = Attested, level = Open,
       needs = [Lss, Alone, Fastscan], touches = [NodeId], catches = [FastscanEarlyMatch])]
fn early_match(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, address| {
        scan_begin(bench)?;
        scan(bench, address[0], 0, 0, 1)?;
        // The product code matches, and the master goes back to the vendor-ID.
        scan(bench, address[1], 0, 1, 0)?;
        expect_waiting(bench, "a match of the product code alone")
    })
}

/// The slave ignores Fastscan requests with a bit check or a part that does not exist, and still works.
#[case(id = "305/fastscan/out-of-range", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone, Fastscan], touches = [NodeId], catches = [FastscanHangs])]
fn out_of_range(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        scan_begin(bench)?;
        let strange = [(32, 0, 0), (127, 0, 0), (129, 0, 0), (0, 4, 0), (31, 255, 0), (31, 0, 4)];
        bench.each(strange, |bench, (bit_check, sub, next)| {
            let answer = scan(bench, 0, bit_check, sub, next)?;
            let what = format!("a Fastscan of bit {bit_check}, part {sub}, next part {next}");
            bench.check(expect_silence(&what, answer))
        })?;
        let answer = scan_begin(bench)?;
        bench.check(expect_match("the begin of Fastscan after it", answer))
    })
}

/// A device with a node-ID takes no part in Fastscan.
#[case(id = "305/fastscan/configured", clause = "CiA 305 6.7", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [FastscanAnsweredWhenConfigured])]
fn with_node_id(bench: &mut Bench<'_>) -> Judged {
    let answer = scan(bench, 0, RESET, 0, 0)?;
    bench.check(expect_silence("the begin of Fastscan with a node-ID", answer))?;
    // Silence proves something only if the slave is present.
    configure(bench)?;
    wait(bench)
}
