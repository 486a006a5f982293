//! A violation as a test for pytest, with python-canopen and python-can.

use super::candump::{times, wait_after};
use super::check::Check;
use super::rust_test::identifier;
use crate::Start;
use crate::campaign::Found;
use crate::stimulus::{Sequence, Stimulus};
use canvass_analyzer::NodeId;
use canvass_traces::{Duration, Frame, Timestamp};
use std::fmt::Write;

/// The file with names between @ in place of what depends on the violation.
const TEMPLATE: &str = include_str!("pytest_template.py");

/// A file for pytest. The test fails as long as the device shows the violation. It sends the frames of the log at their
/// times, on the bus of python-can's configuration.
pub fn pytest(found: &Found, node: NodeId, seed: u64) -> String {
    let violation = &found.violation;
    let (property, rule, expected) = (violation.property, violation.rule, words(&violation.expected));
    let check = Check::of(found);
    let prelude = Sequence { stimuli: found.prelude.clone(), ..Sequence::default() };
    let values = [
        ("property", property.id().to_owned()),
        ("title", property.title().to_owned()),
        ("rule", rule.to_owned()),
        ("clause", words(&violation.clause())),
        ("actual", words(&violation.actual)),
        ("start", start(found).to_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("seed", seed.to_string()),
        ("node", node.raw().to_string()),
        ("patience", seconds(check.patience(found))),
        ("before", rows(&prelude)),
        ("begin", seconds(length(&prelude))),
        ("sequence", rows(&found.sequence)),
        ("until", seconds(length(&found.sequence))),
        ("name", identifier(&format!("{property} {rule}"))),
        ("begins", begins(found).to_owned()),
        ("assertion", assertion(&check, &expected)),
        ("expected", expected),
    ];
    values.iter().fold(TEMPLATE.to_owned(), |text, (name, value)| text.replace(&format!("@{name}@"), value))
}

/// The text in one line, without the characters that end a string of Python.
fn words(text: &str) -> String {
    let plain = |letter: char| match letter {
        letter if letter.is_control() => ' ',
        '\\' => '/',
        '"' => '\'',
        letter => letter,
    };
    text.chars().map(plain).collect()
}

/// How the device comes to the start of the sequence.
fn start(found: &Found) -> &'static str {
    match (found.sequence.start, found.prelude.is_empty()) {
        (Start::Unconfigured, _) => "Start: switch the device on without node-ID.",
        (Start::Configured, true) => {
            "Start: the test resets the node; the violation was found on a device that was switched on."
        }
        (Start::Configured, false) => "Start: the test uses the SDO server and resets the node.",
    }
}

fn begins(found: &Found) -> &'static str {
    match (found.sequence.start, found.prelude.is_empty()) {
        (Start::Unconfigured, _) => "",
        (Start::Configured, true) => "    assert device.reset(), \"the node does not start\"\n",
        (Start::Configured, false) => "    device.play(PRELUDE, PRELUDE_TIME)\n",
    }
}

/// The lines of Python that fail if the violation came.
fn assertion(check: &Check, expected: &str) -> String {
    let heard = |since: &str, can_id: u16| format!("device.heard.since({since}, 0x{can_id:X})");
    let (preparation, condition) = match check {
        Check::Otherwise { can_id, answers } => {
            let answers = answers.iter().fold(String::new(), |text, frame| text + "\n        \"" + &hex(frame) + "\",");
            let came = heard("begun", *can_id);
            let preparation = format!(
                "    wrong = [{answers}\n    ]\n    came = [bytes(msg.data).hex().upper() for _, msg in {came}]\n"
            );
            (preparation, "all(came[at : at + len(wrong)] != wrong for at in range(len(came)))".to_owned())
        }
        Check::Fewer { frame, any_data, times } => {
            let id = frame.id().as_standard().unwrap_or_default();
            let data = format!(" if bytes(msg.data).hex().upper() == \"{}\"", hex(frame));
            let data = if *any_data { "" } else { &data };
            let preparation = format!("    wrong = [msg for _, msg in {}{data}]\n", heard("begun", id));
            (preparation, format!("len(wrong) < {times}"))
        }
        Check::More { can_id, than, boot_up, within } => {
            let data = if *boot_up { "" } else { " and bytes(msg.data) != b\"\\0\"" };
            let in_time = format!(" if at - last <= {}{data}", seconds(*within));
            let preparation = format!("    came = [msg for at, msg in {}{in_time}]\n", heard("last", *can_id));
            (preparation, format!("len(came) > {than}"))
        }
        Check::Period { can_id, number, least, most } => {
            let since = if number.is_some() { "begun" } else { "last" };
            let times = format!("    times = [at for at, _ in {}]\n", heard(since, *can_id));
            let (least, most) = (seconds(*least), seconds(*most));
            match number {
                Some(number) => {
                    let (before, at) = (number.saturating_sub(2), number.saturating_sub(1));
                    let condition =
                        format!("len(times) < {number} or {least} <= times[{at}] - times[{before}] <= {most}");
                    (times, condition)
                }
                None => {
                    let gaps = "all({} <= b - a <= {} for a, b in zip(times, times[1:]))";
                    let gaps = gaps.replacen("{}", &least, 1).replacen("{}", &most, 1);
                    (times, format!("times and {gaps}"))
                }
            }
        }
        Check::Starts => (String::new(), "device.reset()".to_owned()),
        Check::Unknown => {
            return "    pytest.skip(\"only the reference models of canvass fuzz --replay show this\")\n".to_owned();
        }
    };
    format!("{preparation}    assert {condition}, \"expected {expected}\"\n")
}

/// The frames of a sequence as the rows of a list.
fn rows(sequence: &Sequence) -> String {
    let rows = times(sequence).zip(&sequence.stimuli).fold(String::new(), |mut text, (at, stimulus)| {
        // Writing to a string can't fail.
        let _ = write!(text, "\n    ({}, {}),", seconds(at.since(Timestamp::ZERO)), message(stimulus));
        text
    });
    if rows.is_empty() { rows } else { rows + "\n" }
}

fn message(Stimulus { frame, .. }: &Stimulus) -> String {
    let id = frame.id().raw();
    let extended = if frame.id().is_extended() { ", extended=True" } else { "" };
    match frame.is_remote() {
        true => format!("frame(0x{id:03X}{extended}, remote={})", frame.len()),
        false => format!("frame(0x{id:03X}, \"{}\"{extended})", hex(frame)),
    }
}

fn hex(frame: &Frame) -> String {
    frame.data().iter().fold(String::new(), |mut text, byte| {
        // Writing to a string can't fail.
        let _ = write!(text, "{byte:02X}");
        text
    })
}

/// The duration of a sequence with the wait after its last frame.
fn length(sequence: &Sequence) -> Duration {
    sequence.stimuli.iter().map(wait_after).fold(Duration::ZERO, |sum, wait| sum + wait)
}

fn seconds(time: Duration) -> String {
    format!("{}.{:06}", time.nanos() / 1_000_000_000, time.nanos() % 1_000_000_000 / 1_000)
}
