//! A bus for the tests of bench and runner, with a device of a few lines on it. Its time is virtual.

use crate::bench::{Bench, Options, Target};
use canvass_analyzer::NodeId;
use canvass_bus::{Bus, BusError};
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

/// Runs `test` on a bench with that script.
pub fn with_bench<T>(
    script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static,
    test: impl FnOnce(&mut Bench<'_>) -> T,
) -> T {
    with_options(script, &Options::default(), test)
}

/// The same with options.
pub fn with_options<T>(
    script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static,
    options: &Options,
    test: impl FnOnce(&mut Bench<'_>) -> T,
) -> T {
    let mut bus = ScriptedBus::new(script);
    let target = Target::unknown(NodeId::new(NODE).unwrap());
    let cancel = AtomicBool::new(false);
    let mut annotate = |record: &Record| record.frame.to_string();
    test(&mut Bench::new(&mut bus, &target, options, &mut annotate, &cancel))
}

/// A frame in the notation of `cansend`.
pub fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once('#').unwrap();
    let id = canvass_traces::CanId::standard(u32::from_str_radix(id, 16).unwrap()).unwrap();
    let data: Vec<u8> =
        (0..data.len()).step_by(2).map(|at| u8::from_str_radix(&data[at..at + 2], 16).unwrap()).collect();
    Frame::new(id, &data).unwrap()
}

/// Answers frames from a table, each after 1 ms; a reset with boot-up.
pub fn table(rows: &'static [(&'static str, &'static str)]) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
    move |request| {
        let request = request.to_string();
        let answers = rows.iter().filter(|(asked, _)| *asked == request);
        answers.map(|(_, answer)| (Duration::from_millis(1), frame(answer))).collect()
    }
}
