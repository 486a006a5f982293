//! Frames out and in, for cases: what is sent was allowed, and is in the journal.

use super::{Bench, Sent};
use crate::verdict::{Reason, Stop};
use canvass_traces::{CanId, Direction, Duration, Frame, Record, Timestamp};

impl Bench<'_> {
    /// Sends a frame as it is, however wrong.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus does not take it, [`Stop::Inconclusive`] if the run was cancelled, [`Stop::NotApplicable`] if
    /// it would move a zero point or write the memory, and the user has not allowed that.
    pub fn send(&mut self, frame: &Frame) -> Result<Sent, Stop> {
        self.traffic.check_cancelled()?;
        self.check_leave(frame)?;
        self.changes.journal_frame(frame, self.target.node)?;
        self.traffic.send(frame)
    }

    /// Sends up to eight bytes with an 11-bit CAN-ID.
    ///
    /// # Errors
    /// As [`Bench::send`]; [`Stop::Error`] if there are more than eight bytes.
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

    /// Waits for a frame of another participant that `wanted` recognises. Other traffic goes by, answers of the SDO server to
    /// other clients too. `None` when `span` has passed without it.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus fails, [`Stop::Inconclusive`] if the run was cancelled.
    pub fn wait_for<T>(&mut self, span: Duration, wanted: impl FnMut(&Record) -> Option<T>) -> Result<Option<T>, Stop> {
        self.traffic.wait_for(span, wanted)
    }

    /// Lets time pass and returns the frames that the device under test sent meanwhile.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn listen(&mut self, span: Duration) -> Result<Vec<Record>, Stop> {
        self.traffic.listen(span)
    }

    /// What has come since then, of what is kept as evidence.
    pub(crate) fn heard_since(&self, begun: Timestamp) -> Vec<Record> {
        let records = self.evidence().frames().map(|exhibit| &exhibit.record);
        records.filter(|record| record.timestamp >= begun && record.direction == Direction::Rx).cloned().collect()
    }

    /// Takes in what was on the bus up to now, so that a late answer is not taken for that of the next request.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn drain(&mut self) -> Result<(), Stop> {
        self.traffic.drain()
    }
}
