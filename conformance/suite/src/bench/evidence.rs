//! The frames that were on the bus while a case ran.

use canvass_traces::{Direction, Record, Timestamp};
use std::collections::VecDeque;

/// Frames with their decoded text. Only the first and the last frames are kept.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    head: Vec<Exhibit>,
    tail: VecDeque<Exhibit>,
    omitted: u64,
}

/// One frame of the evidence.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Exhibit {
    /// The frame with its time and direction. Its number refers to the recording of the run.
    pub record: Record,
    /// The meaning of the frame. The text contains data of the device: it may hold anything.
    pub text: String,
}

/// Gives frames their text. Receives every frame of a run once, in order.
pub trait Annotate {
    /// The meaning of the frame.
    fn annotate(&mut self, record: &Record) -> String;

    /// The number of the last frame in the recording, from 1; 0 if nothing is recorded.
    fn number(&self) -> u64 {
        0
    }
}

impl<F: FnMut(&Record) -> String> Annotate for F {
    fn annotate(&mut self, record: &Record) -> String {
        self(record)
    }
}

impl Evidence {
    /// Number of frames that are kept from the start, and from the end.
    pub const KEPT: usize = 250;

    /// Adds a frame. If there are too many, a frame in the middle is dropped.
    pub fn push(&mut self, exhibit: Exhibit) {
        if self.head.len() < Self::KEPT {
            self.head.push(exhibit);
            return;
        }
        if self.tail.len() == Self::KEPT {
            self.tail.pop_front();
            self.omitted += 1;
        }
        self.tail.push_back(exhibit);
    }

    /// The kept frames, in the order in which they were on the bus.
    pub fn frames(&self) -> impl Iterator<Item = &Exhibit> {
        self.head.iter().chain(&self.tail)
    }

    /// The time of the tester's latest frame with this CAN-ID.
    pub(crate) fn sent(&self, can_id: u16) -> Option<Timestamp> {
        let is_it = |exhibit: &&Exhibit| {
            exhibit.record.direction == Direction::Tx && exhibit.record.frame.cob_id() == Some(can_id)
        };
        let found = self.tail.iter().rev().find(is_it).or_else(|| self.head.iter().rev().find(is_it));
        found.map(|exhibit| exhibit.record.timestamp)
    }

    /// The time of the latest frame.
    pub(crate) fn last(&self) -> Option<Timestamp> {
        self.tail.back().or_else(|| self.head.last()).map(|exhibit| exhibit.record.timestamp)
    }

    /// Number of frames that were left out.
    pub const fn omitted(&self) -> u64 {
        self.omitted
    }

    /// Number of frames in [`Evidence::frames`] before the gap.
    pub const fn gap(&self) -> usize {
        self.head.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{CanId, ChannelId, Frame};

    #[test]
    fn first_and_last_frames_are_kept() {
        let mut evidence = Evidence::default();
        let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
        for n in 0..1_000 {
            let record = Record::new(Timestamp(n), ChannelId(0), frame);
            evidence.push(Exhibit { record, text: String::new() });
        }
        let times: Vec<u64> = evidence.frames().map(|exhibit| exhibit.record.timestamp.0).collect();
        assert_eq!((times.len(), evidence.omitted()), (500, 500));
        assert_eq!((times[evidence.gap() - 1], times[evidence.gap()]), (249, 750));
    }

    /// The time of the tester's latest frame with a CAN-ID is found, however old the frame is; frames of others do not
    /// count.
    #[test]
    fn the_latest_own_frame_is_found() {
        let mut evidence = Evidence::default();
        assert_eq!((evidence.last(), evidence.sent(1)), (None, None));
        let mut push = |at, id, direction| {
            let frame = Frame::full(CanId::standard_masked(id), [0; 8]);
            let record = Record::new(Timestamp(at), ChannelId(0), frame).with_direction(direction);
            evidence.push(Exhibit { record, text: String::new() });
            (evidence.last(), evidence.sent(1))
        };
        assert_eq!(push(1, 1, Direction::Rx), (Some(Timestamp(1)), None));
        assert_eq!(push(2, 1, Direction::Tx), (Some(Timestamp(2)), Some(Timestamp(2))));
        assert_eq!(push(3, 1, Direction::Tx), (Some(Timestamp(3)), Some(Timestamp(3))));
        for at in 4..300 {
            assert_eq!(push(at, 2, Direction::Tx), (Some(Timestamp(at)), Some(Timestamp(3))));
        }
        assert_eq!(push(300, 1, Direction::Tx).1, Some(Timestamp(300)));
        assert_eq!(push(301, 1, Direction::Tx).1, Some(Timestamp(301)));
        assert_eq!(push(302, 1, Direction::Rx), (Some(Timestamp(302)), Some(Timestamp(301))));
    }
}
