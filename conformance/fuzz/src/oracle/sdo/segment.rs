//! Segmented transfers after their initiation.

use super::super::codes::{self, CodeSet};
use super::super::expected_values::ExpectedValues;
use super::awaited::{Awaited, Writing};
use super::initiate::{all_length_codes, writing};
use super::{LONGEST, Server, TransferState};
use crate::Knowledge;
use canvass_analyzer::wire::sdo::Segment;

impl Server {
    pub(super) fn download_segment(
        &mut self,
        segment: Segment,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
    ) -> Awaited {
        let TransferState::Download { at, entry, toggle, announced } = self.state else {
            return self.refuse(codes::COMMAND, "a download segment without its transfer", expected_values);
        };
        if segment.toggle != toggle {
            return Awaited::AbortOrIgnored;
        }
        if self.data.len() < LONGEST {
            self.data.extend_from_slice(segment.data());
        }
        if !segment.last {
            self.state = TransferState::Download { at, entry, toggle: !toggle, announced };
            return Awaited::ConfirmSegment { toggle, last: None };
        }
        self.state = TransferState::Idle;
        let mut writing = writing(at, &self.data, knowledge, expected_values);
        let (received, announced) = (self.data.len(), announced.map(|size| size as usize));
        let (codes, why) = against_announced(received, announced);
        if !codes.is_empty() {
            // The server decides which of several errors it reports.
            let known = knowledge.entry(at);
            let of_received = all_length_codes(known, Some(received));
            let is_of_length = known.is_some_and(|known| known.writable) && !of_received.is_empty();
            let others = if is_of_length { of_received } else { writing.must };
            let must = codes.or(all_length_codes(known, announced)).or(others);
            writing = Writing { must, why, pdo_rule: false, ..writing };
            expected_values.aborted = entry;
        }
        Awaited::ConfirmSegment { toggle, last: Some((at, writing)) }
    }

    pub(super) fn upload_segment(&mut self, toggle: bool) -> Awaited {
        match self.state {
            TransferState::Upload { toggle: expected, .. } if expected == toggle => Awaited::Segment { toggle },
            TransferState::Upload { .. } => Awaited::AbortOrIgnored,
            _ => {
                self.state = TransferState::Idle;
                Awaited::Abort { codes: codes::COMMAND, at: None, why: "a segment is asked for without its transfer" }
            }
        }
    }
}

/// The codes for a number of bytes that differs from the announced number.
fn against_announced(received: usize, announced: Option<usize>) -> (CodeSet, &'static str) {
    match announced {
        Some(size) if received > size => (codes::TOO_LONG, "more data than announced"),
        Some(size) if received < size => (codes::TOO_SHORT, "less data than announced"),
        _ => (CodeSet::NONE, ""),
    }
}
