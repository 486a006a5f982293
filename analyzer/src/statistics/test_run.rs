//! The cases of a conformance test, as delimited by marks in a capture: comments of `canvass test`, frames on 7FFh of
//! CiA's tool.

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
    /// Number of further cases.
    pub omitted: u64,
}

/// The name of a case.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum CaseName {
    /// The id in `canvass test`.
    Id(Arc<str>),
    /// The numbers in CiA's test tool.
    Numbered {
        /// The group of the case.
        group: u8,
        /// The number of the case in the group.
        case: u8,
    },
}

/// One case.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TestCase {
    /// The name of the case.
    pub name: CaseName,
    /// The verdict; `None` if the end of the case is missing.
    pub verdict: Option<Arc<str>>,
    /// Time of the begin.
    pub begin: Timestamp,
    /// Time of the end, or of the last frame in the case.
    pub end: Timestamp,
    /// The place of the first marker, or of the first frame in the case.
    pub place: Place,
    /// The place of the last marker, or of the last frame in the case.
    pub last_place: Place,
    /// Number of frames in the case, without markers.
    pub frames: u64,
}

impl TestCase {
    /// Whether the verdict of the case is a pass.
    pub fn is_passed(&self) -> bool {
        self.verdict.as_deref() == Some("pass")
    }
}

impl TestRun {
    /// Maximum number of cases that are kept.
    pub const MOST: usize = 10_000;

    /// Handles a marker frame of CiA's test tool.
    pub fn marker(&mut self, now: Timestamp, place: Place, marker: CaseMarker, room: &Room) {
        let CaseMarker { group, case, verdict } = marker;
        let (name, verdict) = (CaseName::Numbered { group, case }, verdict.map(|verdict| verdict.to_string().into()));
        match self.open(&name).filter(|_| verdict.is_some()) {
            Some(open) => (open.verdict, open.end, open.last_place) = (verdict, now, place),
            None => self.begin(name, verdict, now, place, room),
        }
    }

    /// Handles the comment before a frame.
    #[cold]
    pub fn comment(&mut self, now: Timestamp, place: Place, comment: &str, room: &Room) {
        for CaseMark { id, verdict } in CaseMark::all(comment) {
            let name = CaseName::Id(id.into());
            let verdict = verdict.map(Arc::from);
            // The mark of an end comes before a frame that no longer belongs to the case, so the end and the last place
            // stay.
            match self.open(&name).filter(|_| verdict.is_some()) {
                Some(open) => open.verdict = verdict,
                None if room.take(2 * id.len()) => self.begin(name, verdict, now, place, room),
                None => self.omitted += 1,
            }
        }
    }

    /// The open case, if it has this name.
    fn open(&mut self, name: &CaseName) -> Option<&mut TestCase> {
        self.cases.last_mut().filter(|last| last.verdict.is_none() && last.name == *name)
    }

    /// Adds a case: at its begin marker, or at its end marker if the capture has no begin marker of it.
    fn begin(&mut self, name: CaseName, verdict: Option<Arc<str>>, now: Timestamp, place: Place, room: &Room) {
        // A growing list takes up to twice the memory of its content.
        if self.cases.len() < Self::MOST && room.take(2 * size_of::<TestCase>()) {
            self.cases.push(TestCase { name, verdict, begin: now, end: now, place, last_place: place, frames: 0 });
        } else {
            self.omitted += 1;
        }
    }

    /// Handles any other frame.
    #[inline]
    pub fn frame(&mut self, now: Timestamp, place: Place) {
        if let Some(open) = self.cases.last_mut().filter(|last| last.verdict.is_none()) {
            (open.end, open.frames, open.last_place) = (now, open.frames + 1, place);
        }
    }
}

/// Writes `case 301/boot-up/every-time`, `case 7 of group 3`.
impl fmt::Display for CaseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(id) => write!(f, "case {id}"),
            Self::Numbered { group, case } => write!(f, "case {case} of group {group}"),
        }
    }
}
