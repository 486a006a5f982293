//! The interface of every protocol state machine.

use canvass_traces::{Frame, Timestamp};

/// A participant of a bus that does no I/O and reads no clock: calls pass the time and frames to it and take frames
/// from it. Simulated devices and all other participants of a simulated bus implement this trait.
pub trait Machine: Send {
    /// Handles a frame of another participant, which ended at `now`.
    fn handle(&mut self, now: Timestamp, frame: &Frame);

    /// Whether [`Machine::handle`] would ignore this frame, as it does most frames of a bus; the bus can then save the
    /// call.
    fn ignores(&self, frame: &Frame) -> bool {
        let _ = frame;
        false
    }

    /// The next frame to send, if there is one. The bus calls this method whenever it can take a frame, until there is
    /// none, and sends each frame by arbitration.
    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame>;

    /// The time of the next call of [`Machine::handle_timeout`], if there is one.
    fn poll_timeout(&self) -> Option<Timestamp>;

    /// Handles the time that [`Machine::poll_timeout`] returned.
    fn handle_timeout(&mut self, now: Timestamp);

    /// The bit rate in bit/s of the participant, if it differs from that of the bus: participants of different bit
    /// rates do not understand each other.
    fn bit_rate(&self) -> Option<u32> {
        None
    }

    /// Switches the supply off and on; a participant without its own supply ignores the call.
    fn power_cycle(&mut self, now: Timestamp) {
        let _ = now;
    }

    /// A copy in the same state, if the machine can be copied: a bus of such machines can return to an earlier state.
    fn duplicate(&self) -> Option<Box<dyn Machine>> {
        None
    }

    /// Whether the bus must not send a waiting frame any more: a reset, for example, empties the mailboxes of a CAN
    /// controller.
    fn withdraws(&self, pending: &Frame) -> bool {
        let _ = pending;
        false
    }
}
