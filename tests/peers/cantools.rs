//! cantools reads the CAN databases that canvass makes of descriptions, and decodes frames to the same values as
//! `canvass signals`.

use serde_json::Value;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const PYTHON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/peers-venv/bin/python");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers/signals.py");
const NODE: u8 = 42;
/// Number of frames of each PDO.
const FRAMES: usize = 200;

/// Random bytes that are the same in every run.
struct Random(u64);

impl Random {
    fn byte(&mut self) -> u8 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 56) as u8
    }
}

fn canvass(args: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO_BIN_EXE_canvass")).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// The frames as cantools decodes them, one object for each.
fn decoded(dbc: &Path, frames: &[String]) -> Vec<Value> {
    let piped = Command::new(PYTHON).arg(SCRIPT).arg(dbc).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let mut child = piped
        .unwrap_or_else(|error| panic!("{PYTHON}: {error}; cargo xtask ci installs the peers that these tests need"));
    let mut input = child.stdin.take().unwrap();
    let lines: String = frames.iter().map(|frame| format!("{frame}\n")).collect();
    let writing = std::thread::spawn(move || input.write_all(lines.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writing.join().unwrap().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The CAN-IDs and lengths of the messages of a database.
fn messages(dbc: &Path) -> Vec<(u32, usize)> {
    let bytes = std::fs::read(dbc).unwrap();
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let lines = text.lines().filter_map(|line| line.strip_prefix("BO_ "));
    let message = |line: &str| {
        let (id, rest) = line.split_once(' ')?;
        let length = rest.split(' ').nth(1)?;
        Some((id.parse().ok()?, length.parse().ok()?))
    };
    lines.map(|line| message(line).unwrap()).collect()
}

/// Compares the values of random frames; returns the number of compared values.
fn agree(description: &Path) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let (dbc, log) = (folder.path().join("node.dbc"), folder.path().join("frames.log"));
    let node = NODE.to_string();
    canvass(&["eds", "convert", description.to_str().unwrap(), dbc.to_str().unwrap(), "--node", &node]);
    let mut random = Random(7);
    let mut frames = Vec::new();
    for _ in 0..FRAMES {
        for &(id, length) in &messages(&dbc) {
            let data: String = (0..length).map(|_| format!("{:02X}", random.byte())).collect();
            frames.push(format!("{id:03X}#{data}"));
        }
    }
    let mut capture = String::new();
    for (number, frame) in frames.iter().enumerate() {
        writeln!(capture, "({}.{:06}) can0 {frame}", 1_700_000_000 + number / 1000, number % 1000 * 1000).unwrap();
    }
    std::fs::write(&log, capture).unwrap();
    let device = format!("{NODE}={}", description.display());
    let rows = canvass(&["signals", log.to_str().unwrap(), "--device", &device, "--format", "json"]);
    let rows = String::from_utf8(rows).unwrap();
    let rows: Vec<Value> = rows.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let theirs = decoded(&dbc, &frames);
    assert_eq!((rows.len(), theirs.len()), (frames.len(), frames.len()), "{}", description.display());
    rows.iter().zip(&theirs).map(|(row, message)| compare(row, message)).sum()
}

/// Compares one frame; returns the number of compared values.
fn compare(row: &Value, message: &Value) -> usize {
    let (name, pdo) = (message["name"].as_str().unwrap(), row["pdo"].as_str().unwrap());
    assert!(name.ends_with(&pdo.replace(' ', "")), "{name} is not {pdo}");
    let is_sent = pdo.starts_with("TPDO");
    assert_eq!(message["senders"].as_array().unwrap().is_empty(), !is_sent, "{message}");
    let signals = message["signals"].as_array().unwrap();
    let mut compared = 0;
    for (position, signal) in signals.iter().enumerate() {
        let [_, value, unit, comment] = &signal.as_array().unwrap()[..] else { panic!("{signal}") };
        // An object that is mapped twice has one column, with its last value.
        if signals[position + 1..].iter().any(|later| later[3] == *comment) {
            continue;
        }
        let (object, label) = comment.as_str().unwrap().split_once(' ').unwrap();
        let unit = unit.as_str().filter(|unit| !unit.is_empty()).map(|unit| format!(" [{unit}]")).unwrap_or_default();
        let columns = [format!("node {NODE} {label} {object}{unit}"), format!("node {NODE} {label}{unit}")];
        let ours = columns.iter().find_map(|column| row.get(column)).unwrap_or_else(|| panic!("{columns:?} in {row}"));
        let ours = ours.as_f64().or_else(|| ours.as_bool().map(|bit| f64::from(u8::from(bit)))).unwrap();
        let theirs = value.as_f64().unwrap();
        // canvass prints physical values to six decimals.
        let tolerance = 1e-6_f64.max(theirs.abs() * 1e-12);
        assert!((ours - theirs).abs() <= tolerance, "{name} {signal}: {ours}\n{row}");
        compared += 1;
    }
    compared
}

#[test]
fn cantools_gets_the_same_values_out_of_frames() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("conformance/device/models");
    let mut compared = 0;
    let mut descriptions = 0;
    for entry in std::fs::read_dir(models).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "eds") {
            compared += agree(&path);
            descriptions += 1;
        }
    }
    assert!(descriptions >= 11 && compared > 5_000, "{compared} values of {descriptions} descriptions");
}
