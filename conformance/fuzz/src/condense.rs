//! Reduces many frames to the frames that, according to the standard, determine the state of a device: the last NMT
//! command, and the last value written to each object.

use super::Knowledge;
use super::stimulus::Stimulus;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_analyzer::wire::sdo::REQUEST_BASE;
use std::collections::BTreeSet;

/// The effect of a frame. A later frame with the same effect makes an earlier frame superfluous.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Effect {
    State,
    /// The value of the object with this multiplexer.
    Value([u8; 3]),
}

/// Selects the frames that determine the state of the device for later frames. After each selected frame the device
/// gets time to answer.
pub(super) fn condense(sent: &[Stimulus], knowledge: &Knowledge) -> Vec<Stimulus> {
    let mut later = BTreeSet::new();
    let mut condensed = Vec::new();
    for stimulus in sent.iter().rev() {
        if commanded(stimulus, knowledge).is_some_and(Command::is_reset) {
            // The reset undoes all earlier frames.
            break;
        }
        if effect(stimulus, knowledge).is_some_and(|effect| later.insert(effect)) {
            condensed.push(Stimulus::settle(stimulus.frame));
        }
    }
    condensed.reverse();
    condensed
}

fn effect(stimulus: &Stimulus, knowledge: &Knowledge) -> Option<Effect> {
    if commanded(stimulus, knowledge).is_some() {
        return Some(Effect::State);
    }
    let request = REQUEST_BASE + u16::from(knowledge.node.raw());
    match *stimulus.frame.data() {
        // Expedited download.
        [command, low, high, sub, _, _, _, _] if command & 0xF2 == 0x22 => {
            Some(Effect::Value([low, high, sub])).filter(|_| stimulus.frame.cob_id() == Some(request))
        }
        _ => None,
    }
}

/// The NMT command in a frame, if it is addressed to the device or to all nodes.
fn commanded(stimulus: &Stimulus, knowledge: &Knowledge) -> Option<Command> {
    let frame = &stimulus.frame;
    let Ok(message) = Nmt::read(frame.data()) else { return None };
    let is_command = frame.cob_id() == Some(nmt::CAN_ID) && frame.len() == 2;
    let is_own = message.node == 0 || message.node == knowledge.node.raw();
    let is_known = message.command.is_reset()
        || matches!(message.command, Command::START | Command::STOP | Command::ENTER_PRE_OPERATIONAL);
    (is_command && is_own && is_known).then_some(message.command)
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::NodeId;
    use canvass_traces::{CanId, Frame};

    /// The last start and the last value of 1017h remain. Frames before a reset are left out.
    #[test]
    fn what_a_later_frame_undoes_goes() {
        let knowledge = Knowledge::new(NodeId::new(5).unwrap(), None, None);
        let stimulus = |id, data: &[u8]| Stimulus::settle(Frame::new(CanId::standard_masked(id), data).unwrap());
        let write = |value| stimulus(0x605, &[0x2B, 0x17, 0x10, 0, value, 0, 0, 0]);
        let read = stimulus(0x605, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
        let (start, stop, other) = (stimulus(0, &[1, 5]), stimulus(0, &[2, 0]), stimulus(0, &[2, 6]));
        let early = [write(9), stimulus(0, &[0x81, 5])];
        let late = [start, write(1), stop, read, write(2), start, other];
        assert_eq!(condense(&[&early[..], &late].concat(), &knowledge), [write(2), start]);
        assert_eq!(condense(&[read, other], &knowledge), []);
    }
}
