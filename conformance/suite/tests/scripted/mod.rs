//! A scripted bus for the tests of the bench and of runs, with a device of a few lines on it. Its time is virtual.

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, BusError};
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::case::Case;
use canvass_suite::clause::{Clause, Confidence, Level};
use canvass_suite::verdict::Judged;
use canvass_traces::{ChannelId, Direction, Duration, Frame, Record, Timestamp};
use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

/// Answers a frame with frames, each after a delay.
pub type Script = Box<dyn FnMut(&Frame) -> Vec<(Duration, Frame)>>;

/// A bus with a script as the only other participant.
pub struct ScriptedBus {
    now: Timestamp,
    script: Script,
    queue: VecDeque<Record>,
}

impl ScriptedBus {
    pub fn new(script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static) -> Self {
        Self { now: Timestamp::ZERO, script: Box::new(script), queue: VecDeque::new() }
    }

    fn enqueue(&mut self, at: Timestamp, frame: Frame, direction: Direction) {
        let record = Record::new(at, ChannelId(0), frame).with_direction(direction);
        let place = self.queue.partition_point(|queued| queued.timestamp <= at);
        self.queue.insert(place, record);
    }
}

impl Bus for ScriptedBus {
    fn now(&self) -> Timestamp {
        self.now
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.enqueue(self.now, *frame, Direction::Tx);
        for (delay, answer) in (self.script)(frame) {
            self.enqueue(self.now + delay, answer, Direction::Rx);
        }
        Ok(())
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        match self.queue.front() {
            Some(next) if next.timestamp <= deadline => {
                self.now = self.now.max(next.timestamp);
                Ok(self.queue.pop_front())
            }
            _ => {
                self.now = self.now.max(deadline);
                Ok(None)
            }
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        None
    }
}

/// The node-ID in these tests.
pub const NODE: u8 = 63;

/// Runs `test` on a bench with this script.
pub fn with_bench<T>(
    script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static,
    test: impl FnOnce(&mut Bench<'_>) -> T,
) -> T {
    with_options(script, &Options::default(), test)
}

/// Runs `test` on a bench with this script and these options.
pub fn with_options<T>(
    script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static,
    options: &Options,
    test: impl FnOnce(&mut Bench<'_>) -> T,
) -> T {
    with_target(script, &Target::unknown(NodeId::new(NODE).unwrap()), options, test)
}

/// Runs `test` on a bench with this script, this target and these options.
pub fn with_target<T>(
    script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static,
    target: &Target,
    options: &Options,
    test: impl FnOnce(&mut Bench<'_>) -> T,
) -> T {
    let mut bus = ScriptedBus::new(script);
    let cancel = AtomicBool::new(false);
    let mut annotate = |record: &Record| record.frame.to_string();
    test(&mut Bench::new(&mut bus, target, options, &mut annotate, &cancel))
}

/// A device with a description: sections of an EDS, each with its lines beyond read and write access.
pub fn described(sections: &[(&str, &str)]) -> Target {
    let mut eds = String::new();
    for (name, lines) in sections {
        let object = name.split("sub").next().unwrap_or_default();
        if object != *name && !eds.contains(&format!("[{object}]")) {
            let subs = sections.iter().filter(|(name, _)| name.starts_with(&format!("{object}sub"))).count();
            eds.push_str(&format!("[{object}]\nParameterName={object}\nObjectType=0x9\nSubNumber={subs}\n\n"));
        }
        let access = if lines.contains("AccessType") { "" } else { "AccessType=rw\n" };
        eds.push_str(&format!("[{name}]\nParameterName={name}\n{access}{lines}\n\n"));
    }
    let description = canvass_analyzer::dictionary::eds::read(eds.as_bytes()).unwrap();
    Target { description: Some(description), ..Target::unknown(NodeId::new(NODE).unwrap()) }
}

/// A case without needs.
pub const fn test_case(id: &'static str, run: fn(&mut Bench<'_>) -> Judged) -> Case {
    let clause = Clause { standard: "CiA 301", section: None, confidence: Confidence::Unknown };
    let (needs, touches, catches) = (&[], &[], &[]);
    let answers = &[];
    Case { id, requirement: "A test.", clause, level: Level::Must, needs, touches, catches, answers, cct: None, run }
}

/// A frame in the notation of `cansend`.
pub fn frame(text: &str) -> Frame {
    canvass_traces::parse_frame(text).unwrap().frame
}

/// Answers frames from a table, each after 1 ms; a reset is answered with a boot-up message.
pub fn table(rows: &'static [(&'static str, &'static str)]) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
    move |request| {
        let request = request.to_string();
        let answers = rows.iter().filter(|(asked, _)| *asked == request);
        answers.map(|(_, answer)| (Duration::from_millis(1), frame(answer))).collect()
    }
}

/// A row of a scripted dictionary: an object, its value, and whether it can be written.
pub type Row = ((u16, u8), Vec<u8>, bool);

/// Answers expedited reads and writes from a dictionary, and nothing else.
pub fn dictionary(rows: Vec<Row>) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
    let mut rows = rows;
    move |request| {
        if request.cob_id() != Some(0x600 + u16::from(NODE)) {
            return Vec::new();
        }
        let [command, low, high, sub, data @ ..] = request.bytes();
        let index = u16::from_le_bytes([low, high]);
        let has_index = rows.iter().any(|row| row.0.0 == index);
        let entry = rows.iter_mut().find(|row| row.0 == (index, sub));
        let mut answer = [0x80, low, high, sub, 0, 0, 0, 0];
        let refused: u32 = match (command >> 5, entry) {
            (2, Some((_, value, _))) => {
                answer[0] = 0x43 | ((4 - value.len() as u8) << 2);
                answer[4..4 + value.len()].copy_from_slice(value);
                0
            }
            (1, Some((_, value, true))) => {
                *value = data[..4 - usize::from(command >> 2 & 3)].to_vec();
                answer[0] = 0x60;
                0
            }
            (1, Some(_)) => 0x0601_0002,
            (1 | 2, None) if has_index => 0x0609_0011,
            (1 | 2, None) => 0x0602_0000,
            (4, _) => return Vec::new(),
            _ => 0x0504_0001,
        };
        if refused != 0 {
            answer[4..].copy_from_slice(&refused.to_le_bytes());
        }
        let id = canvass_traces::CanId::standard_masked(0x580 + u32::from(NODE));
        vec![(Duration::from_millis(1), Frame::full(id, answer))]
    }
}
