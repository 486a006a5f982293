//! Tests of the filter language as a user meets it.

use super::{Filter, Subject};
use crate::network::Network;
use canvass_traces::parse_frame;
use proptest::prelude::*;

/// Whether the filter lets the last of these frames pass.
fn passes(filter: &str, frames: &[&str]) -> bool {
    let filter: Filter = filter.parse().unwrap();
    let mut network = Network::new();
    let last = frames.iter().map(|frame| {
        let record = parse_frame(frame).unwrap();
        let decoded = network.handle(&record);
        filter.matches(&Subject { record: &record, decoded: &decoded, channel: "can0" })
    });
    last.last().unwrap()
}

const READ_PRESET: &str = "603#4003600000000000";
const REFUSED: &str = "583#8003600000000206";

#[test]
fn the_example() {
    let example = "service=sdo and node in 1..8 and index=0x6003 or abort";
    assert!(passes(example, &[READ_PRESET]));
    assert!(!passes(example, &["603#4004600000000000"]), "another object");
    assert!(!passes(example, &["609#4003600000000000"]), "another node");
    assert!(passes(example, &["609#4003600000000000", "589#8003600000000206"]), "an abort of any node");
    assert!(!passes(example, &["183#0102"]));
}

#[test]
fn operators() {
    for (filter, expected) in [
        ("node = 3", true),
        ("node != 3", false),
        ("node < 3", false),
        ("node <= 3", true),
        ("node > 2", true),
        ("node >= 4", false),
        ("node in 1,2,3", true),
        ("node not in 1..8", false),
        ("index=6003h", true),
        ("id=0x603 and len==8", true),
        ("channel=can0", true),
        ("channel in can1, vcan0", false),
        ("service not in pdo, sdo", false),
        ("not abort", true),
        ("not (abort or emcy)", true),
        ("abort or node=3 and index=0x6004", false),
        ("(abort or node=3) and index=0x6003", true),
        ("abort = 0x06020000", false),
    ] {
        assert_eq!(passes(filter, &[READ_PRESET]), expected, "{filter}");
    }
    assert!(passes("abort=0x06020000", &[READ_PRESET, REFUSED]));
    assert!(passes("emcy=0x8130", &["083#3081110000000000"]));
    assert!(!passes("node != 3", &["080#"]), "SYNC has no node");
}

#[test]
fn errors_point_at_the_column() {
    let error = |text: &str| text.parse::<Filter>().unwrap_err();
    let shown = |text: &str| error(text).to_string();
    assert_eq!(error("service=sdo and nod=3").column, 17);
    assert_eq!(error("service=sdo node=3").column, 13);
    assert_eq!(error("node in 1..x").column, 12);
    assert_eq!(error("(abort").column, 7);
    assert_eq!(error("").column, 1);
    for open in ["abort and ", "abort or", "not", "service in sdo,", "node in 1,"] {
        assert_eq!((error(open).found, error(open).column), (None, open.len() + 1), "{open}");
    }
    assert!(shown("node=x").contains("expected a number such as 63, 0x3F or 3Fh, found \"x\"\n  node=x\n       ^"));
    assert!(shown("service=can").contains("expected a service: nmt"));
}

#[test]
fn brackets_do_not_exhaust_the_stack() {
    let deep = "(".repeat(100_000);
    assert!(deep.parse::<Filter>().unwrap_err().expected.contains("fewer brackets"));
}

proptest! {
    #[test]
    fn any_text_is_a_filter_or_an_error(text in "\\PC{0,40}") {
        let _ = text.parse::<Filter>().map_err(|error| error.to_string());
    }

    #[test]
    fn any_words(words in prop::collection::vec(prop::sample::select(vec![
        "and", "or", "not", "(", ")", "node", "in", "=", "<", "3", "..", ",", "service", "sdo", "abort", "0x6003",
    ]), 0..12)) {
        let text = words.join(" ");
        if let Err(error) = text.parse::<Filter>() {
            prop_assert!(error.column <= text.chars().count() + 1);
        }
    }
}
