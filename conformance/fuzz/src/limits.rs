//! Checks the effects of a frame before it is sent: the user has to allow each touch.

use super::Knowledge;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::{lss, nmt, sdo};
use canvass_suite::touch::Touch;
use canvass_traces::Frame;
use std::collections::BTreeSet;
use std::fmt;

/// Why a frame is not sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Forbidden {
    /// The frame has an effect that only an option `--allow` of the user permits.
    Touch(Touch),
    /// The frame would replace the device's program, which no option allows.
    Program,
}

impl fmt::Display for Forbidden {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Touch(touch) => write!(f, "{}, which is not allowed", touch.text()),
            Self::Program => f.write_str("writes the device's program"),
        }
    }
}

/// The effect of the frame that the user has not allowed. `None`: the frame may be sent.
pub fn of(frame: &Frame, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Option<Forbidden> {
    let unless = |touch: Touch| (!allow.contains(&touch)).then_some(Forbidden::Touch(touch));
    let id = frame.cob_id()?;
    let data = frame.data();
    if id == lss::MASTER_CAN_ID {
        return match data.first()? {
            0x11 => unless(Touch::NodeId),
            0x13 | 0x15 => unless(Touch::BitRate),
            0x17 => unless(Touch::Nvm),
            _ => None,
        };
    }
    if id == nmt::CAN_ID {
        let own = data.get(1) == Some(&knowledge.node.raw());
        return if own { None } else { unless(Touch::OtherNodes) };
    }
    if id != sdo::REQUEST_BASE + u16::from(knowledge.node.raw()) {
        let is_other = (sdo::REQUEST_BASE..sdo::REQUEST_BASE + 0x80).contains(&id);
        return if is_other { unless(Touch::OtherNodes) } else { None };
    }
    let &[command, low, high, sub, ..] = data else { return None };
    // Initiate download or initiate block download.
    if !matches!(command >> 5, 1 | 6) {
        return None;
    }
    let at = Multiplexer::from_bytes([low, high, sub]);
    writing(at, knowledge, allow).or_else(|| mapping(at, data, knowledge, allow))
}

/// Checks an entry of an RPDO mapping, as a later RPDO writes the mapped object. The value of a segmented download is
/// not known here and may be any object.
fn mapping(at: Multiplexer, request: &[u8], knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Option<Forbidden> {
    if !(0x1600..0x1800).contains(&at.index.0) || at.sub.0 == 0 {
        return None;
    }
    match *request {
        [0x20..=0x3F, _, _, _, _, sub, low, high] if request.first().is_some_and(|command| command & 2 != 0) => {
            writing(Multiplexer::from_bytes([low, high, sub]), knowledge, allow)
        }
        _ => {
            let mut touches = Touch::ALL.into_iter().filter(|touch| touch.is_by_the_tester());
            touches.find(|touch| !allow.contains(touch)).map(Forbidden::Touch)
        }
    }
}

/// The effect of writing the object that the user has not allowed. `None`: the object may be written.
pub fn writing(at: Multiplexer, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Option<Forbidden> {
    let unless = |touch: Touch| (!allow.contains(&touch)).then_some(Forbidden::Touch(touch));
    let services = &knowledge.services;
    match at.index.0 {
        object::STORE_PARAMETERS => unless(Touch::Nvm),
        object::RESTORE_DEFAULT_PARAMETERS => unless(Touch::FactoryDefaults),
        0x1F50..=0x1F57 => Some(Forbidden::Program),
        _ if knowledge.moves_zero_point(at) => unless(Touch::Preset),
        _ if services.bus_save_object == Some(at) => unless(Touch::Nvm),
        _ if services.bus_objects.contains(&at) => unless(Touch::NodeId).or(unless(Touch::BitRate)),
        _ if services.persist_at_once.contains(&at) => unless(Touch::Nvm),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::NodeId;
    use canvass_traces::CanId;

    /// `65 76 61 73` ("save") to 1010h, LSS store and configure, and NMT to all nodes have to be allowed by name.
    #[test]
    fn what_wears_or_moves_a_device_is_allowed_by_name() {
        let knowledge = Knowledge::new(NodeId::new(5).unwrap(), None, None);
        let frame = |id, data: &[u8]| Frame::new(CanId::standard_masked(id), data).unwrap();
        for (id, data, touch) in [
            (0x605, &[0x23, 0x10, 0x10, 0x01, 0x73, 0x61, 0x76, 0x65][..], Touch::Nvm),
            (0x605, &[0xC6, 0x10, 0x10, 0x01, 4, 0, 0, 0], Touch::Nvm),
            (0x605, &[0x23, 0x11, 0x10, 0x01, 0x6C, 0x6F, 0x61, 0x64], Touch::FactoryDefaults),
            (0x605, &[0x23, 0x03, 0x60, 0x00, 1, 0, 0, 0], Touch::Preset),
            (0x605, &[0x21, 0x09, 0x60, 0x00, 8, 0, 0, 0], Touch::Preset),
            (0x7E5, &[0x17, 0, 0, 0, 0, 0, 0, 0], Touch::Nvm),
            (0x7E5, &[0x11, 5, 0, 0, 0, 0, 0, 0], Touch::NodeId),
            (0x7E5, &[0x15, 1, 0, 0, 0, 0, 0, 0], Touch::BitRate),
            (0x000, &[0x81, 0], Touch::OtherNodes),
            (0x000, &[0x81, 6], Touch::OtherNodes),
        ] {
            let frame = frame(id, data);
            assert_eq!(of(&frame, &knowledge, &BTreeSet::new()), Some(Forbidden::Touch(touch)), "{frame}");
            assert_eq!(of(&frame, &knowledge, &BTreeSet::from([touch])), None, "{frame}");
        }
        // 1010h:01 is mapped into RPDO 1, in an expedited and in a segmented download.
        let mapped = frame(0x605, &[0x23, 0x00, 0x16, 0x01, 0x20, 0x01, 0x10, 0x10]);
        assert_eq!(of(&mapped, &knowledge, &BTreeSet::new()), Some(Forbidden::Touch(Touch::Nvm)));
        let unseen = frame(0x605, &[0x21, 0x00, 0x16, 0x01, 4, 0, 0, 0]);
        assert!(of(&unseen, &knowledge, &BTreeSet::from([Touch::NodeId])).is_some());
        let flash = frame(0x605, &[0x21, 0x50, 0x1F, 0x01, 0, 1, 0, 0]);
        assert_eq!(of(&flash, &knowledge, &Touch::ALL.into_iter().collect()), Some(Forbidden::Program));
        for (id, data) in [(0x605, &[0x40, 0x10, 0x10, 0x01, 0, 0, 0, 0][..]), (0x000, &[0x81, 5]), (0x7E5, &[0x04])] {
            assert_eq!(of(&frame(id, data), &knowledge, &BTreeSet::new()), None);
        }
    }
}
