//! The cases of a conformance test, as marks cut a capture: comments of `canvass test`, frames on 7FFh of CiA's tool.

use crate::CaseMark;
use crate::room::Room;
use crate::wire::case_marker::CaseMarker;
use canvass_traces::{Place, Timestamp};
use std::fmt;
use std::sync::Arc;

/// The cases of a capture.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct TestRun {
    /// The cases in the order of their begin, at most [`TestRun::MOST`].
    pub cases: Vec<TestCase>,
    /// How many more there were.
    pub omitted: u64,
}

/// What a case is called.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum CaseName {
    /// By `canvass test`.
    Id(Arc<str>),
    /// By CiA's test tool.
    Numbered {
        /// Its group.
        group: u8,
        /// Its number in the group.
        case: u8,
    },
}

/// One case.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TestCase {
    /// Which.
    pub name: CaseName,
    /// The verdict; `None` where the case was not ended.
    pub verdict: Option<Arc<str>>,
    /// When it began.
    pub begin: Timestamp,
    /// When it ended, or the last frame of it was seen.
    pub end: Timestamp,
    /// The place of its first marker, or of its first frame.
    pub place: Place,
    /// The place of its last marker, or of the last frame in it: all from `place` to here is the case.
    pub last_place: Place,
    /// The frames in it, without the markers.
    pub frames: u64,
}

impl TestCase {
    /// Whether its verdict is that it has passed.
    pub fn is_passed(&self) -> bool {
        self.verdict.as_deref() == Some("pass")
    }
}

impl TestRun {
    /// How many cases are kept.
    pub const MOST: usize = 10_000;

    /// A frame of CiA's test tool.
    pub fn marker(&mut self, now: Timestamp, place: Place, marker: CaseMarker, room: &Room) {
        let CaseMarker { group, case, verdict } = marker;
        let (name, verdict) = (CaseName::Numbered { group, case }, verdict.map(|verdict| verdict.to_string().into()));
        match self.open(&name).filter(|_| verdict.is_some()) {
            Some(open) => (open.verdict, open.end, open.last_place) = (verdict, now, place),
            None => self.begin(name, verdict, now, place, room),
        }
    }

    /// The comment before a frame.
    #[cold]
    pub fn comment(&mut self, now: Timestamp, place: Place, comment: &str, room: &Room) {
        for CaseMark { id, verdict } in CaseMark::all(comment) {
            let name = CaseName::Id(id.into());
            let verdict = verdict.map(Arc::from);
            // The frame after the end of a case is none of it.
            match self.open(&name).filter(|_| verdict.is_some()) {
                Some(open) => open.verdict = verdict,
                None if room.take(2 * id.len()) => self.begin(name, verdict, now, place, room),
                None => self.omitted += 1,
            }
        }
    }

    /// The case that is under way, if it is that one.
    fn open(&mut self, name: &CaseName) -> Option<&mut TestCase> {
        self.cases.last_mut().filter(|last| last.verdict.is_none() && last.name == *name)
    }

    /// A begin, or the end of a case whose begin was not recorded.
    fn begin(&mut self, name: CaseName, verdict: Option<Arc<str>>, now: Timestamp, place: Place, room: &Room) {
        // A list that grows takes up to twice the memory of what is in it.
        if self.cases.len() < Self::MOST && room.take(2 * size_of::<TestCase>()) {
            self.cases.push(TestCase { name, verdict, begin: now, end: now, place, last_place: place, frames: 0 });
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

/// `case 301/boot-up/every-time`, `case 7 of group 3`.
impl fmt::Display for CaseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(id) => write!(f, "case {id}"),
            Self::Numbered { group, case } => write!(f, "case {case} of group {group}"),
        }
    }
}
