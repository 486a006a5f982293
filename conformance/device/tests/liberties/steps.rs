//! A device, and the actions of a master step by step as text.

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Firmware};
use canvass_traces::{CanId, Direction, Duration, Frame};

/// Does these steps with a device of this firmware as delivered; returns the result of the last step. The steps, each
/// with its result:
///
/// - `60A#40001000` sends a frame: the frames of the next 50 ms;
/// - `600` waits 600 ms: the frames of this time;
/// - `after 60A#40001000` sends a frame: the milliseconds until the first frame, at most 6 s;
/// - `r 1018:01` reads: `=` and the bytes from the fourth on, or the abort code, or `silence`;
/// - `w 1017:00 E803` writes these bytes: `ok`, or the abort code, or `silence`;
/// - `count 6D0 1000` waits 1000 ms: the number of frames with that CAN-ID.
///
/// The results leave out heartbeats.
pub fn result(model: &str, firmware: impl Into<Firmware>, steps: &[&str]) -> String {
    let model = Model::by_id(model).unwrap();
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(Device::new(model, NodeId::new(10), firmware, 1)));
    steps.iter().map(|step| run(&mut bus, step)).last().unwrap()
}

fn run(bus: &mut SimulatedBus, step: &str) -> String {
    let words: Vec<&str> = step.split(' ').collect();
    match words[..] {
        ["after", frame] => {
            let begin = bus.now();
            bus.send(&parse(frame)).unwrap();
            let came = records(bus, 6_000).into_iter().next();
            came.map_or("never".to_owned(), |(_, at)| format!("{} ms", at.since(begin).as_millis() as u64))
        }
        ["count", id, millis] => {
            let came = records(bus, millis.parse().unwrap());
            came.iter().filter(|(frame, _)| frame.starts_with(&format!("{id}#"))).count().to_string()
        }
        ["r", at] => sdo(bus, 0x40, at, ""),
        ["w", at, value] => sdo(bus, 0x23 | (4 - value.len() as u8 / 2) << 2, at, value),
        [frame] if frame.contains('#') => {
            bus.send(&parse(frame)).unwrap();
            frames(bus, 50)
        }
        [millis] => frames(bus, millis.parse().unwrap()),
        _ => panic!("{step}"),
    }
}

fn sdo(bus: &mut SimulatedBus, command: u8, at: &str, value: &str) -> String {
    let (index, sub) = at.split_once(':').unwrap();
    let (high, low) = index.split_at(2);
    bus.send(&parse(&format!("60A#{command:02X}{low}{high}{sub}{value:0<8}"))).unwrap();
    // With the liberty of the slowest "save" the answer takes 3 s.
    let came = records(bus, if value == "73617665" { 3_100 } else { 1_000 });
    let Some((answer, _)) = came.iter().find(|(frame, _)| frame.starts_with("58A#")) else {
        return "silence".to_owned();
    };
    let (command, rest) = (&answer[4..6], &answer[12..]);
    match command {
        "80" => (0..4).rev().map(|n| &rest[2 * n..2 * n + 2]).collect(),
        "60" => "ok".to_owned(),
        _ => format!("={rest}"),
    }
}

fn frames(bus: &mut SimulatedBus, millis: u64) -> String {
    records(bus, millis).into_iter().map(|(frame, _)| frame).collect::<Vec<_>>().join(" ")
}

fn records(bus: &mut SimulatedBus, millis: u64) -> Vec<(String, canvass_traces::Timestamp)> {
    let deadline = bus.now() + Duration::from_millis(millis);
    let mut records = Vec::new();
    while let Some(record) = bus.receive(deadline).unwrap() {
        if record.direction == Direction::Rx {
            records.push((record.frame.to_string(), record.timestamp));
        }
    }
    records
}

/// Parses a frame in candump's notation: `60A#4000100000000000`, `18A#R`.
fn parse(text: &str) -> Frame {
    let (id, data) = text.split_once('#').unwrap();
    let id = CanId::standard(u32::from_str_radix(id, 16).unwrap()).unwrap();
    if data == "R" {
        return Frame::remote(id, 0).unwrap();
    }
    let mut bytes: Vec<u8> =
        (0..data.len() / 2).map(|n| u8::from_str_radix(&data[2 * n..2 * n + 2], 16).unwrap()).collect();
    if id.raw() == 0x60A {
        bytes.resize(8, 0);
    }
    Frame::new(id, &bytes).unwrap()
}
