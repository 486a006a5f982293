//! Sending and receiving frames in cases. The bench checks that the user allows a frame, and records it in the journal.

use super::{Bench, Sent};
use crate::verdict::{Reason, Stop};
use canvass_traces::{CanId, Direction, Duration, Frame, Record, Timestamp};

impl Bench<'_> {
    /// Sends a frame unchanged, even if it is wrong.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus does not take it, [`Stop::Inconclusive`] if the run was cancelled,
    /// [`Stop::NotApplicable`] if it would move a zero point or write the memory, and the user has not allowed that.
    pub fn send(&mut self, frame: &Frame) -> Result<Sent, Stop> {
        self.traffic.check_cancelled()?;
        self.check_leave(frame)?;
        self.changes.journal_frame(frame, self.target.node)?;
        self.traffic.send(frame)
    }

    /// Sends up to eight bytes with an 11-bit CAN-ID.
    ///
    /// # Errors
    /// The errors of [`Bench::send`]; [`Stop::Error`] if there are more than eight bytes.
    pub fn send_bytes(&mut self, cob_id: u16, bytes: &[u8]) -> Result<Sent, Stop> {
        match Frame::new(CanId::standard_masked(u32::from(cob_id)), bytes) {
            Some(frame) => self.send(&frame),
            None => Err(Stop::Error(Reason::new(
                "the tester sends a classical CAN frame",
                "up to 8 bytes",
                format!("{} bytes", bytes.len()),
            ))),
        }
    }

    /// Waits for a frame of another participant that `wanted` recognises. Skips all other traffic, including answers of
    /// the SDO server to other clients. `None` if `span` passes without such a frame.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus fails, [`Stop::Inconclusive`] if the run was cancelled.
    pub fn wait_for<T>(&mut self, span: Duration, wanted: impl FnMut(&Record) -> Option<T>) -> Result<Option<T>, Stop> {
        self.traffic.wait_for(span, wanted)
    }

    /// Waits for `span` and returns the frames that the device under test sent meanwhile.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub fn listen(&mut self, span: Duration) -> Result<Vec<Record>, Stop> {
        self.traffic.listen(span)
    }

    /// The frames since `begun`, as far as the evidence keeps them.
    pub(crate) fn heard_since(&self, begun: Timestamp) -> Vec<Record> {
        let records = self.evidence().frames().map(|exhibit| &exhibit.record);
        records.filter(|record| record.timestamp >= begun && record.direction == Direction::Rx).cloned().collect()
    }

    /// Takes all frames that are already on the bus, so that a late answer is not taken for the answer to the next
    /// request.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub fn drain(&mut self) -> Result<(), Stop> {
        self.traffic.drain()
    }
}
