//! What every protocol state machine does.

use canvass_traces::{Frame, Timestamp};

/// A participant of a bus that does no I/O and reads no clock: time and frames come in by call, frames go out by
/// call. A simulated device is one, and so is everything else that a simulated bus connects.
pub trait Machine: Send {
    /// A frame of another participant was on the bus; it ended at `now`.
    fn handle(&mut self, now: Timestamp, frame: &Frame);

    /// Whether [`Machine::handle`] would do nothing with this frame, as with most of a bus: it need not be called then.
    fn ignores(&self, frame: &Frame) -> bool {
        let _ = frame;
        false
    }

    /// The next frame to send, if there is one. The bus asks whenever it can take a frame, until there is none, and
    /// sends each as arbitration allows.
    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame>;

    /// When [`Machine::handle_timeout`] wants to be called next, if ever.
    fn poll_timeout(&self) -> Option<Timestamp>;

    /// The time that [`Machine::poll_timeout`] named has come.
    fn handle_timeout(&mut self, now: Timestamp);

    /// The bit rate in bit/s at which it takes part, where it is not that of the bus: it then understands nothing that
    /// is sent at another one, and nobody else understands it.
    fn bit_rate(&self) -> Option<u32> {
        None
    }

    /// Off and on again; nothing happens to what has no supply of its own.
    fn power_cycle(&mut self, now: Timestamp) {
        let _ = now;
    }

    /// Another one in the same state, if it can be had: a bus that has one can go back to what it was.
    fn duplicate(&self) -> Option<Box<dyn Machine>> {
        None
    }

    /// Whether a frame that the bus took but has not begun to send shall not be sent any more: a reset, for example,
    /// empties the mailboxes of a CAN controller.
    fn withdraws(&self, pending: &Frame) -> bool {
        let _ = pending;
        false
    }
}
