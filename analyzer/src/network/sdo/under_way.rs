//! Block transfers that began before the capture.
//!
//! A segment may look like any message, as its first byte is the sequence number. Segments are recognised because they
//! follow each other without a frame from the other side, and are numbered from 1 after each confirmation.

use super::transfer::Direction;
use crate::wire::Wire;
use crate::wire::sdo::BlockSegment;
use canvass_traces::{Duration, Timestamp};

/// The block transfers that may be open on a channel, until a request with its answer shows the channel's state.
#[derive(Clone, Default)]
pub(crate) struct UnderWay {
    /// A request was answered: no earlier transfer is open.
    over: bool,
    /// The sequence number of the client's next segment, and the time of the segment or confirmation before it.
    download: Option<(u8, Timestamp)>,
    /// The sequence number of the server's next segment, and the time of the segment or confirmation before it.
    upload: Option<(u8, Timestamp)>,
}

impl UnderWay {
    /// Maximum time between two segments of a block.
    const SOON: Duration = Duration::from_millis(1_000);

    /// Handles a request with its answer, which ends all earlier transfers.
    pub const fn end(&mut self) {
        self.over = true;
    }

    /// Whether an earlier transfer may still be open.
    pub(crate) const fn is_possible(&self) -> bool {
        !self.over
    }

    /// The frame as a segment, if the frames before make it one. `direction` is the direction of the data.
    pub fn segment(&mut self, now: Timestamp, direction: Direction, payload: &[u8]) -> Option<BlockSegment> {
        let (own, other) = match direction {
            Direction::Download => (&mut self.download, &mut self.upload),
            Direction::Upload => (&mut self.upload, &mut self.download),
        };
        let segment = BlockSegment::read(payload).ok()?;
        // After a confirmation (A2h) the other side begins with 1 again; any other message excludes that this side
        // receives segments.
        *other = payload.starts_with(&[0xA2]).then_some((1, now));
        let expected = own.filter(|(_, before)| now.since(*before) <= Self::SOON);
        *own = (!segment.last).then(|| (segment.sequence.saturating_add(1), now));
        expected.filter(|(next, _)| *next == segment.sequence && payload.first() != Some(&0x80)).map(|_| segment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segments(frames: &[(Direction, u8)]) -> Vec<bool> {
        let mut under_way = UnderWay::default();
        let frames = frames.iter().enumerate();
        let seen = frames.map(|(n, (direction, byte))| {
            under_way.segment(Timestamp(n as u64 * 1_000_000), *direction, &[*byte, 0, 0, 0, 0, 0, 0, 0]).is_some()
        });
        seen.collect()
    }

    #[test]
    fn a_download_from_its_middle() {
        let client = |byte| (Direction::Download, byte);
        let frames = [client(0x40), client(0x41), client(0x42), (Direction::Upload, 0xA2), client(0x01), client(0x82)];
        assert_eq!(segments(&frames), [false, true, true, false, true, true]);
    }

    #[test]
    fn an_upload_from_its_middle() {
        let server = |byte| (Direction::Upload, byte);
        let frames =
            [server(0x7E), server(0x7F), (Direction::Download, 0xA2), server(0x01), server(0x82), server(0xC5)];
        assert_eq!(segments(&frames), [false, true, false, true, true, false]);
    }

    #[test]
    fn requests_and_answers_are_none() {
        let frames = [(Direction::Download, 0x40), (Direction::Upload, 0x41), (Direction::Download, 0x60)];
        assert_eq!(segments(&frames), [false, false, false]);
        let polls = [(Direction::Download, 0x40), (Direction::Download, 0x40), (Direction::Download, 0x40)];
        assert_eq!(segments(&polls), [false, false, false]);
    }

    /// Segments come within a second of each other.
    #[test]
    fn what_comes_late_is_none() {
        for (millis, is_segment) in [(1_000, true), (1_001, false)] {
            let mut under_way = UnderWay::default();
            let mut at = |millis: u64, byte: u8| {
                let payload = [byte, 0, 0, 0, 0, 0, 0, 0];
                under_way.segment(Timestamp(millis * 1_000_000), Direction::Download, &payload).is_some()
            };
            assert!(!at(0, 0x40));
            assert_eq!(at(millis, 0x41), is_segment, "{millis}");
        }
    }
}
