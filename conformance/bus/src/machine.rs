//! The interface of every protocol state machine.

use canvass_traces::{Frame, Timestamp};

/// A participant of a bus that does no I/O and reads no clock: time and frames come in by call, frames go out by
/// call. Simulated devices and all other participants of a simulated bus implement it.
pub trait Machine: Send {
    /// Handles a frame of another participant, which ended at `now`.
    fn handle(&mut self, now: Timestamp, frame: &Frame);

    /// Whether [`Machine::handle`] would ignore this frame, as most frames of a bus; the call can then be saved.
    fn ignores(&self, frame: &Frame) -> bool {
        let _ = frame;
        false
    }

    /// The next frame to send, if there is one. The bus calls this whenever it can take a frame, until there is none,
    /// and sends each frame by arbitration.
    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame>;

    /// The time of the next call of [`Machine::handle_timeout`], if there is one.
    fn poll_timeout(&self) -> Option<Timestamp>;

    /// Handles the time that [`Machine::poll_timeout`] named.
    fn handle_timeout(&mut self, now: Timestamp);

    /// The bit rate in bit/s of the participant, if it differs from that of the bus: participants of different bit
    /// rates do not understand each other.
    fn bit_rate(&self) -> Option<u32> {
        None
    }

    /// Switches the supply off and on; a participant without a supply of its own ignores it.
    fn power_cycle(&mut self, now: Timestamp) {
        let _ = now;
    }

    /// A copy in the same state, if the machine can be copied: a bus of copyable machines can return to an earlier
    /// state.
    fn duplicate(&self) -> Option<Box<dyn Machine>> {
        None
    }

    /// Whether a frame that waits in the bus must not be sent any more: a reset, for example, empties the mailboxes
    /// of a CAN controller.
    fn withdraws(&self, pending: &Frame) -> bool {
        let _ = pending;
        false
    }
}
