//! The schemas in `docs/schemas` are those of the types, and the lines of `decode` match their type to the byte.

// `cfg(test)` has no effect here, but clippy uses it to recognise where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::network::Network;
use canvass_analyzer::{Meaning, NodeId};
use canvass_device::models::Model;
use canvass_reports::decode::{JsonLines, Line, Lines};
use canvass_reports::results::DecodeLine;
use canvass_reports::results::schemas::{file_name, schemas};
use canvass_traces::{Capture, ReadOptions, Reader};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn the_schemas_in_the_documentation_are_current() {
    for (contract, schema) in schemas() {
        let path = root().join("docs/schemas").join(file_name(contract));
        let shipped = std::fs::read_to_string(&path).unwrap_or_default();
        let current = shipped == format!("{:#}\n", schema.as_value());
        assert!(current, "{} is not current: run `cargo xtask docs`", path.display());
    }
}

/// The lines for a capture in which node 63 is an encoder.
fn lines(path: &Path) -> Vec<String> {
    let Ok(mut capture) = Capture::open(path, &ReadOptions::default()) else { return Vec::new() };
    let mut network = Network::new();
    let model = Model::by_id("kuebler-sendix-58x8").unwrap();
    network.describe(NodeId::new(63).unwrap(), canvass_analyzer::dictionary::KnownDevice::clone(model.device()));
    let (mut json, mut out) = (JsonLines::new(), Vec::new());
    while let Some(record) = capture.next() {
        let Ok(record) = record else { continue };
        let decoded = network.handle(&record);
        let meaning = Meaning::new(&record, &decoded, network.bus(record.channel).unwrap());
        json.line(&Line { record: &record, channels: capture.channels(), decoded: &decoded, meaning }, &mut out);
    }
    String::from_utf8(out).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn the_lines_of_decode_are_of_their_type_to_the_byte() {
    let samples = std::fs::read_dir(root().join("traces/samples")).unwrap().map(|entry| entry.unwrap().path());
    let mut seen = 0;
    for path in samples.chain([root().join("docs/examples/commissioning.log")]) {
        for line in lines(&path) {
            let read: DecodeLine = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"));
            assert_eq!(serde_json::to_string(&read).unwrap(), line, "{}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen} lines");
}
