//! Block transfers: complete on a correct device, and ended by the client if the server goes wrong.

#![cfg(test)]

use super::super::Bench;
use super::on_device;
use crate::scripted::{frame, with_bench};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::Outcome;
use canvass_bus::client::block_download::DownloadManner;
use canvass_bus::client::block_upload::UploadManner;
use canvass_traces::{Direction, Duration, Frame};

const NAME: Multiplexer = Multiplexer::new(0x1008, 0);

#[test]
fn values_go_through_in_blocks() {
    on_device(|bench| {
        let name = bench.read(NAME).unwrap();
        let (attempt, _) = bench.block_upload(NAME, UploadManner::default()).unwrap();
        assert_eq!((attempt.what.as_str(), attempt.outcome), ("block upload of 1008h:00", Outcome::Uploaded(name)));
        let text = bench.long_scratch().unwrap();
        let before = bench.read(text).unwrap();
        let value = [0x41; 20];
        let (attempt, _) = bench.block_download(text, &value, DownloadManner::right(&value)).unwrap();
        assert_eq!(attempt.what, format!("block download of 20 bytes to {text}"));
        assert_eq!((attempt.outcome, bench.read(text)), (Outcome::Downloaded, Ok(value.to_vec())));
        bench.finish();
        assert_eq!(bench.read(text), Ok(before), "it is put back");
        // A refusal is a valid outcome here, too.
        let missing = Multiplexer::new(0x5FFF, 0);
        let (attempt, _) = bench.block_upload(missing, UploadManner::default()).unwrap();
        assert_eq!((attempt.abort(), attempt.responses.len()), (Some(AbortCode::NO_OBJECT), 1));
    });
}

/// The last frame of the client.
fn last_sent(bench: &mut Bench<'_>) -> String {
    bench.drain().unwrap();
    let own = bench.evidence().frames().filter(|exhibit| exhibit.record.direction == Direction::Tx);
    own.last().map(|exhibit| exhibit.text.clone()).unwrap_or_default()
}

/// The outcome of a block upload of 1008h from a server with these answers, the last frame of the client, and the
/// duration.
fn uploaded(answers: &'static [(&'static str, &'static [&'static str])]) -> (Outcome, String, Duration) {
    let script = move |request: &Frame| {
        let text = request.to_string();
        let found = answers.iter().find(|(asked, _)| text.starts_with(asked));
        let found = found.map_or(&[][..], |(_, answers)| answers);
        (1..).zip(found).map(|(ms, answer)| (Duration::from_millis(ms), frame(answer))).collect()
    };
    with_bench(script, |bench| {
        let begun = bench.now();
        let (attempt, _) = bench.block_upload(NAME, UploadManner::default()).unwrap();
        let took = bench.now().since(begun);
        (attempt.outcome, last_sent(bench), took)
    })
}

#[test]
fn a_server_that_goes_wrong_in_blocks_gets_an_abort() {
    let (outcome, sent, took) = uploaded(&[]);
    assert_eq!((outcome, sent.as_str()), (Outcome::Silent, "63F#8008100000000405"));
    assert_eq!(took, Duration::from_secs(1));
    let (outcome, sent, _) = uploaded(&[("63F#A4", &["5BF#6008100000000000"])]);
    assert!(matches!(outcome, Outcome::Violated(_)), "{outcome:?}");
    assert_eq!(sent, "63F#8008100000000008");
    let (outcome, sent, _) = uploaded(&[("63F#A4", &["5BF#8008100011000906"])]);
    assert!(matches!(outcome, Outcome::Aborted(abort) if abort.code == AbortCode::NO_SUB_INDEX));
    assert_eq!(sent, "63F#A40810007F000000", "nothing more is sent");
    // The server sends a segment, but then no end of the transfer.
    let begun: &[(&str, &[&str])] = &[("63F#A4", &["5BF#C208100002000000"]), ("63F#A3", &["5BF#8141420000000000"])];
    let (outcome, sent, _) = uploaded(begun);
    assert_eq!((outcome, sent.as_str()), (Outcome::Silent, "63F#8008100000000405"));
}

/// A segment of a block has no command byte: bytes that look like a wrong answer are data. An abort is still an abort.
#[test]
fn segments_are_no_answers() {
    let judged = |segment: &'static str| {
        let script = move |request: &Frame| {
            let answer = match request.to_string().get(..6).unwrap_or_default() {
                "63F#A0" => "5BF#C208100002000000",
                "63F#A3" => segment,
                "63F#A2" => "5BF#D500000000000000",
                _ => return Vec::new(),
            };
            vec![(Duration::from_millis(1), frame(answer))]
        };
        with_bench(script, |bench| {
            let manner = UploadManner { crc: false, ..UploadManner::default() };
            let (attempt, _) = bench.block_upload(NAME, manner).unwrap();
            bench.expect_tidy().unwrap();
            (attempt.outcome, bench.take_breaches(None).len())
        })
    };
    assert_eq!(judged("5BF#8141420000000000"), (Outcome::Uploaded(vec![0x41, 0x42]), 0));
    let (outcome, breaches) = judged("5BF#8001100000000008");
    assert!(matches!(outcome, Outcome::Aborted(_) | Outcome::Violated(_)), "{outcome:?}");
    assert_eq!(breaches, 1, "it names another object");
}
