//! Sends the frames that the manuals print to a simulated device, which must answer as printed.
//!
//! The rows are those of the analyzer's tests (`analyzer/tests/manuals/`). The test sends the master's frames and waits
//! for the device's frames. A script for each file (`*.script`) gives the actions that a row needs before it. If the
//! device answers differently, the script also gives its answer and the reason:
//!
//! ```text
//! @ SECTION; CAN-ID; BYTES[ #N]    the row (the N-th with these bytes) of the following lines
//!     device MODEL NODE            a new device, after its start
//!     shaft STEPS                  the position at which the shaft rests
//!     send CAN-ID BYTES            a frame that the manual does not print
//!     wait MILLISECONDS
//!     power                        off and on
//!     error CODE                   an error of the hardware with this code occurs
//!     answers BYTES; REASON        the device answers these bytes instead of the printed ones
//!     skip REASON                  the device can't send, or can't receive, the frame of the row
//! ```

use crate::bench::{Bench, parse};
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_device::Motion;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum wait for a printed frame, in milliseconds.
const PATIENCE: u64 = 6_000;

struct Replay {
    bench: Bench,
    /// The frames that the device has sent since the master's last frame.
    heard: Vec<String>,
    /// Number of printed frames that the device had to send.
    expected: usize,
    skipped: usize,
    complaints: Vec<String>,
}

impl Replay {
    fn act(&mut self, action: &str) {
        let (verb, rest) = action.split_once(' ').unwrap_or((action, ""));
        match verb {
            "device" => {
                let (model, node) = rest.split_once(' ').unwrap();
                (self.bench, self.heard) = Bench::started(model, node.parse().unwrap());
            }
            "shaft" => {
                let motion = Motion::still(rest.parse().unwrap());
                self.bench.device.set_motion(self.bench.now, motion);
            }
            "send" => {
                let (id, bytes) = rest.split_once(' ').unwrap_or((rest, ""));
                self.send(id, bytes);
            }
            "wait" => self.heard.extend(self.bench.run(rest.parse().unwrap())),
            "error" => {
                let code = EmcyCode(u16::from_str_radix(rest, 16).unwrap());
                self.bench.device.set_error(self.bench.now, code, true);
                self.heard.extend(self.bench.run(50));
            }
            "power" => self.heard = self.bench.power_cycle(),
            other => panic!("no action is called {other:?}"),
        }
    }

    fn send(&mut self, id: &str, bytes: &str) {
        let frame = frame(id, bytes);
        self.heard = self.bench.ask(&frame);
        if id == "000" && (bytes.starts_with("81") || bytes.starts_with("82")) {
            self.heard.extend(self.bench.run(300));
        }
    }

    /// Removes a frame from the frames heard, after waiting for it if necessary; returns whether it was there.
    fn take(&mut self, wanted: &str) -> bool {
        let mut waited = 0;
        loop {
            if let Some(position) = self.heard.iter().position(|heard| heard == wanted) {
                self.heard.remove(position);
                return true;
            }
            if waited >= PATIENCE {
                return false;
            }
            waited += 50;
            self.heard.extend(self.bench.run(50));
        }
    }
}

/// A frame in candump's notation. SDO, LMT and EMCY messages are filled up to their eight bytes.
fn frame(id: &str, bytes: &str) -> String {
    if bytes == "remote" {
        return format!("{id}#R");
    }
    let mut digits: String = bytes.split_whitespace().collect();
    if id.starts_with('5') || id.starts_with('6') {
        digits.push_str(&"0".repeat(16_usize.saturating_sub(digits.len())));
    }
    format!("{id}#{digits}")
}

fn is_from_master(id: &str, bytes: &str) -> bool {
    bytes == "remote" || matches!(id, "000" | "080" | "7E5") || id.starts_with('6')
}

/// The actions for each row of a file.
fn script(text: &str) -> BTreeMap<String, Vec<String>> {
    let mut script: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut key = String::new();
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        match line.strip_prefix("@ ") {
            Some(row) => key = row.trim_end().to_owned(),
            None => script.entry(key.clone()).or_default().push(line.trim().to_owned()),
        }
    }
    script
}

fn play(rows: &str, text: &str, model: &str) -> (usize, usize) {
    let mut script = script(text);
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let bench = Bench::new(model);
    let mut replay = Replay { bench, heard: Vec::new(), expected: 0, skipped: 0, complaints: Vec::new() };
    for (line, row) in (1..).zip(rows.lines()) {
        if row.is_empty() || row.starts_with('#') || row == "reset" {
            continue;
        }
        if let Some((id, bytes)) = row.strip_prefix("> ").and_then(|context| context.split_once(' ')) {
            if is_from_master(id, bytes) {
                replay.send(id, bytes);
            }
            continue;
        }
        let columns: Vec<&str> = row.split(';').map(str::trim).collect();
        let [section, id, bytes, ..] = columns.as_slice() else { panic!("line {line}: {row}") };
        let key = format!("{section}; {id}; {bytes}").trim_end().to_owned();
        let count = seen.entry(key.clone()).or_default();
        *count += 1;
        let mut actions = script.remove(&format!("{key} #{count}")).unwrap_or_default();
        actions.extend(script.get(&key).cloned().unwrap_or_default());
        let mut wanted = frame(id, bytes);
        let mut skip = false;
        for action in &actions {
            if let Some(other) = action.strip_prefix("answers ") {
                let (bytes, reason) =
                    other.split_once(';').unwrap_or_else(|| panic!("line {line}: no reason: {other}"));
                assert!(!reason.trim().is_empty(), "line {line}: no reason: {other}");
                wanted = frame(id, bytes.trim());
            } else if let Some(reason) = action.strip_prefix("skip ") {
                assert!(!reason.trim().is_empty(), "line {line}: no reason");
                skip = true;
            } else {
                replay.act(action);
            }
        }
        if skip {
            replay.skipped += 1;
        } else if is_from_master(id, bytes) {
            replay.send(id, bytes);
        } else {
            replay.expected += 1;
            let before = replay.heard.clone();
            if !replay.take(&wanted) {
                replay.complaints.push(format!("line {line}, section {section}: no {wanted}, but {before:?}"));
            }
        }
    }
    let idle: Vec<&String> = script.keys().filter(|key| !seen.contains_key(*key)).collect();
    assert!(idle.is_empty(), "no such row: {idle:?}");
    let complaints = replay.complaints;
    assert!(complaints.is_empty(), "{} of {}:\n{}", complaints.len(), replay.expected, complaints.join("\n"));
    (replay.expected, replay.skipped)
}

#[test]
fn lika_ax58() {
    let rows = include_str!("../../../../analyzer/tests/manuals/lika-ax58.txt");
    let played = play(rows, include_str!("lika-ax58.script"), "lika-ax58");
    assert_eq!(played, (67, 5), "frames of the device that were printed and seen, rows that it can't send");
}

#[test]
fn tr_electronic() {
    let rows = include_str!("../../../../analyzer/tests/manuals/tr-electronic.txt");
    let played = play(rows, include_str!("tr-electronic.script"), "tr-c65");
    assert_eq!(played, (81, 10), "frames of the device that were printed and seen, rows that it can't send");
}

/// Rows of the analyzer's tables that Kübler's manuals do not print as complete frames: section, begin of the frame,
/// and reason.
const NOT_PRINTED: &[(&str, &str, &str)] = &[
    ("5.2.1.1", "3BF#", "the speed is printed as LSB and MSB: replayed with a shaft that rests"),
    ("5.2.7", "5BF#60036001", "6003h has no sub-index 01: an erratum, replayed with its abort"),
    ("5.3.7.2", "5BF#80", "the command byte 80h alone is printed"),
    ("5.2.3.2", "584#80", "the command byte 80h alone is printed"),
    ("5.3.8", "", "the table of CAN-IDs: contents are not printed; the device's own are replayed for nodes 1 and 127"),
    ("5.5.20", "5BF#60052101", "2105h has no sub-index 01: an erratum, replayed with its abort"),
    ("5.5.45", "0BF#004209", "overspeed, by the device's own measurement: tests of the encoder"),
    ("5.7.4", "3BF#", "values of a shaft that turns; replayed with one that rests"),
    ("5.7.5", "18B#", "the CAN-ID before the change"),
    ("5.7.6", "7E4#5E00", "inquire node-ID answers the node-ID: an erratum"),
    ("5.7.7", "1BF#BA4C00000000", "DLC 4 is printed with six bytes: an erratum, replayed with four"),
    ("5.8", "", "classes of error codes and bits of the register, of which no message is printed"),
    ("5.8.1", "0BF#01FF8000", "bytes 4 to 7 are printed as XX"),
    ("5.8.1", "0BF#003201", "no register is printed: it has the bit for voltage"),
    ("5.8.4", "", "the table of abort codes; those that the device has are replayed"),
    ("5.5.2", "184#1027000088900000", "channel B is printed as BB BB BB BB: replayed with 4700.0 mm less channel A"),
    ("5.5.3", "284#", "the angles are not printed"),
    ("5.6.1", "584#60001800", "the answer echoes another sub-index: an erratum, replayed with its abort"),
    ("5.6.1", "584#60011800", "the answer echoes another sub-index: an erratum, replayed with its abort"),
    ("6", "584#800460", "the table of abort codes; those that the device has are replayed"),
];

/// The tests replay every frame that Kübler's devices send in the examples of their manuals (`kuebler-replay.toml`,
/// `kuebler-emergencies.csv`).
#[test]
fn all_printed_frames_of_kuebler_are_replayed() {
    let dialogues = include_str!("kuebler-replay.toml");
    let mut replayed: BTreeSet<String> =
        dialogues.split('"').filter_map(|text| text.strip_prefix("< ")).map(str::to_owned).collect();
    let emergencies = include_str!("kuebler-emergencies.csv").lines().filter(|line| !line.starts_with('#')).skip(1);
    replayed.extend(emergencies.map(|row| frame("0BF", row.split(';').nth(3).unwrap())));
    let rows = [
        include_str!("../../../../analyzer/tests/manuals/kuebler-sendix.txt"),
        include_str!("../../../../analyzer/tests/manuals/kuebler-draw-wire.txt"),
    ];
    let mut missing = Vec::new();
    for row in rows.iter().flat_map(|text| text.lines()) {
        let columns: Vec<&str> = row.split(';').map(str::trim).collect();
        let [section, id, bytes, _, ..] = columns.as_slice() else { continue };
        if row.starts_with(['#', '>']) || is_from_master(id, bytes) {
            continue;
        }
        let frame = frame(id, bytes);
        let excused = NOT_PRINTED.iter().any(|(where_, begins, _)| where_ == section && frame.starts_with(*begins));
        if !excused && !replayed.contains(&frame) {
            missing.push(format!("{section}: {frame}"));
        }
    }
    assert!(missing.is_empty(), "{}:\n{}", missing.len(), missing.join("\n"));
}

/// The replay reads the notation of the analyzer's rows.
#[test]
fn notation() {
    assert_eq!(frame("601", "40 08 10 00"), "601#4008100000000000");
    assert!(parse(&frame("701", "remote")).is_remote());
}
