//! The cases of CiA's conformance test tool, as its markers on 7FFh cut a capture.

use crate::room::Room;
use crate::wire::case_marker::{CaseMarker, Verdict};
use canvass_traces::{Place, Timestamp};

/// The cases of a capture.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct TestRun {
    /// The cases in the order of their begin, at most [`TestRun::MOST`].
    pub cases: Vec<TestCase>,
    /// How many more there were.
    pub omitted: u64,
}

/// One case.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TestCase {
    /// Its group.
    pub group: u8,
    /// Its number in the group.
    pub case: u8,
    /// The verdict; `None` where the case was not ended.
    pub verdict: Option<Verdict>,
    /// When it began.
    pub begin: Timestamp,
    /// When it ended, or the last frame of it was seen.
    pub end: Timestamp,
    /// The place of its first marker.
    pub place: Place,
    /// The place of its last marker, or of the last frame in it: all from `place` to here is the case.
    pub last_place: Place,
    /// The frames in it, without the markers.
    pub frames: u64,
}

impl TestRun {
    /// How many cases are kept.
    pub const MOST: usize = 10_000;

    /// A marker.
    pub fn marker(&mut self, now: Timestamp, place: Place, marker: CaseMarker, room: &Room) {
        let CaseMarker { group, case, verdict } = marker;
        let is_open = |last: &&mut TestCase| last.verdict.is_none() && (last.group, last.case) == (group, case);
        if let (Some(open), Some(_)) = (self.cases.last_mut().filter(is_open), verdict) {
            (open.verdict, open.end, open.last_place) = (verdict, now, place);
            return;
        }
        // A begin, or the end of a case whose begin was not recorded.
        // A list that grows takes up to twice the memory of what is in it.
        if self.cases.len() < Self::MOST && room.take(2 * size_of::<TestCase>()) {
            self.cases.push(TestCase {
                group,
                case,
                verdict,
                begin: now,
                end: now,
                place,
                last_place: place,
                frames: 0,
            });
        } else {
            self.omitted += 1;
        }
    }

    /// Any other frame.
    #[inline]
    pub fn frame(&mut self, now: Timestamp, place: Place) {
        if let Some(open) = self.cases.last_mut().filter(|last| last.verdict.is_none()) {
            (open.end, open.frames, open.last_place) = (now, open.frames + 1, place);
        }
    }
}
