//! Segmented transfers after their begin.

use super::super::belief::Belief;
use super::super::codes::{self, CodeSet};
use super::awaited::{Awaited, Writing};
use super::initiate::writing;
use super::{LONGEST, Server, State};
use crate::Knowledge;
use canvass_analyzer::wire::sdo::Segment;

impl Server {
    pub(super) fn download_segment(&mut self, segment: Segment, knowledge: &Knowledge, belief: &mut Belief) -> Awaited {
        let State::Download { at, entry, toggle, announced } = self.state else {
            return self.refuse(codes::COMMAND, "a download segment without its transfer", belief);
        };
        if segment.toggle != toggle {
            return Awaited::AbortOrIgnored;
        }
        if self.data.len() < LONGEST {
            self.data.extend_from_slice(segment.data());
        }
        let received = self.data.len() as u32;
        let fixed = knowledge.entry(at).and_then(|known| known.size).map(|size| size as u32);
        let too_long = announced.is_some_and(|size| received > size) || fixed.is_some_and(|size| received > size);
        let too_short = segment.last && announced.is_some_and(|size| received < size);
        if too_long || too_short {
            // Where the length is seen to be wrong before the last segment, it may be refused there or at the end.
            let codes = if too_long { codes::TOO_LONG } else { codes::TOO_SHORT };
            let why = if too_long { "more data than announced" } else { "less data than announced" };
            let wrong = Writing { entry, raw: None, must: codes, may: CodeSet::NONE, why, pdo_rule: false };
            if segment.last {
                belief.aborted = entry;
                self.state = State::Idle;
                return Awaited::ConfirmSegment { toggle, last: Some((at, wrong)) };
            }
            self.state = State::Download { at, entry, toggle: !toggle, announced };
            return Awaited::ConfirmSegment { toggle, last: None };
        }
        if !segment.last {
            self.state = State::Download { at, entry, toggle: !toggle, announced };
            return Awaited::ConfirmSegment { toggle, last: None };
        }
        self.state = State::Idle;
        let writing = writing(at, &self.data, knowledge, belief);
        Awaited::ConfirmSegment { toggle, last: Some((at, writing)) }
    }

    pub(super) fn upload_segment(&mut self, toggle: bool) -> Awaited {
        match self.state {
            State::Upload { toggle: expected, .. } if expected == toggle => Awaited::Segment { toggle },
            State::Upload { .. } => Awaited::AbortOrIgnored,
            _ => {
                self.state = State::Idle;
                Awaited::Abort { codes: codes::COMMAND, at: None, why: "a segment is asked for without its transfer" }
            }
        }
    }
}
