//! A transfer that a case leaves open does not disturb the next case.

use super::super::idle::Cure;
use super::super::sdo::DEVICE_TYPE;
use crate::scripted::{frame, with_bench};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{Payload, Request};
use canvass_traces::{Duration, Frame};

const HEARTBEAT_TIME: Multiplexer = Multiplexer::new(0x1017, 0);
const SERVED: &str = "5BF#4300100096010200";
const BUSY: &str = "5BF#8000000021000008";

/// Begins a segmented download.
const SEGMENTED: Request = Request::InitiateDownload { multiplexer: HEARTBEAT_TIME, payload: Payload::Segmented(2) };
/// Begins a block download.
const BLOCKS: Request = Request::InitiateBlockDownload { multiplexer: HEARTBEAT_TIME, crc: true, size: Some(2) };

/// A server whose open transfer no reset ends.
fn stubborn(mut serve: impl FnMut(&str) -> Option<&'static str>) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
    move |request| {
        let text = request.to_string();
        let answer = if text == "000#813F" { Some("73F#00") } else { serve(&text) };
        answer.map(|answer| (Duration::from_millis(1), frame(answer))).into_iter().collect()
    }
}

/// The action that ended the transfer of a case, whether the server then serves a request, and the duration.
fn ended(
    script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static,
    request: Request,
) -> (Option<Cure>, bool, Duration) {
    with_bench(script, |bench| {
        bench.exchange(&request, "a transfer").unwrap();
        let begun = bench.now();
        bench.finish();
        let took = bench.now().since(begun);
        bench.begin();
        let serves = bench.upload(DEVICE_TYPE).unwrap().value().is_ok();
        (bench.kept_open().map(|kept| kept.cure), serves, took)
    })
}

#[test]
fn an_abort_of_the_client_ends_the_transfer() {
    let mut is_open = false;
    let script = stubborn(move |request| match request.get(..6).unwrap_or_default() {
        "63F#21" => {
            is_open = true;
            Some("5BF#6017100000000000")
        }
        "63F#80" => {
            assert_eq!(request, "63F#8017100000000008", "it names the object of the transfer");
            is_open = false;
            None
        }
        "63F#40" if is_open => Some(BUSY),
        "63F#40" => Some(SERVED),
        _ => None,
    });
    let (cure, serves, took) = ended(script, SEGMENTED);
    assert_eq!((cure, serves), (None, true), "this is what the standard says");
    assert!(took < Duration::from_millis(10), "{took}");
}

/// A server that takes every message of the first block for a segment, also an abort.
#[test]
fn a_server_that_takes_an_abort_for_a_segment_gets_a_segment_first() {
    let (mut is_open, mut has_begun) = (false, false);
    let script = stubborn(move |request| match request.get(..6).unwrap_or_default() {
        "63F#C2" | "63F#C6" => {
            is_open = true;
            Some("5BF#A41710007F000000")
        }
        "63F#01" => {
            has_begun = true;
            None
        }
        "63F#80" => {
            is_open &= !has_begun;
            None
        }
        "63F#40" if !is_open => Some(SERVED),
        _ => None,
    });
    let (cure, serves, _) = ended(script, BLOCKS);
    assert_eq!((cure, serves), (Some(Cure::Segment), true));
}

#[test]
fn a_server_that_ends_the_transfer_by_itself_is_waited_for() {
    let mut refused = 0;
    let script = stubborn(move |request| match request.get(..6).unwrap_or_default() {
        "63F#21" => Some("5BF#6017100000000000"),
        "63F#40" if refused < 12 => {
            refused += 1;
            Some(BUSY)
        }
        "63F#40" => Some(SERVED),
        _ => None,
    });
    let (cure, serves, took) = ended(script, SEGMENTED);
    assert_eq!((cure, serves), (Some(Cure::Silence), true));
    assert!(took < Duration::from_secs(20), "{took}");
}

/// The slow actions are tried only once: otherwise a run would try them after every case.
#[test]
fn a_server_that_nothing_ends_is_not_waited_for_again() {
    let script = stubborn(|request| match request.get(..6).unwrap_or_default() {
        "63F#21" => Some("5BF#6017100000000000"),
        "63F#40" => Some(BUSY),
        _ => None,
    });
    with_bench(script, |bench| {
        let mut leave = || {
            bench.begin();
            bench.exchange(&SEGMENTED, "a transfer").unwrap();
            let begun = bench.now();
            bench.finish();
            bench.now().since(begun)
        };
        let times = [leave(), leave()];
        assert_eq!(bench.kept_open().map(|kept| kept.cure), Some(Cure::Nothing));
        assert!(times[0] > Duration::from_secs(10) && times[1] < Duration::from_secs(1), "{times:?}");
    });
}

/// A case that has ended all its transfers costs no further frame.
#[test]
fn nothing_is_sent_after_complete_transfers() {
    let script = stubborn(|request| request.starts_with("63F#40").then_some(SERVED));
    with_bench(script, |bench| {
        bench.upload(DEVICE_TYPE).unwrap().value().unwrap();
        let before = bench.evidence().frames().count();
        let after = bench.finish().evidence.frames().count();
        assert_eq!(before, after);
    });
}
