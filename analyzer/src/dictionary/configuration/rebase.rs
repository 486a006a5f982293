//! COB-IDs of a configuration that is written to another node than the one that it was made for.

use super::BadSetting;
use crate::identity::{CobId, Multiplexer, NodeId};
use crate::object;

/// The side of a communication object that a COB-ID parameter stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Side {
    /// The device sends with it: no other device may.
    Sends,
    /// The device only receives it: several devices may.
    Receives,
}

/// The value of a fixed setting for a node. A CAN-ID of the predefined connection set that belongs to the file's own
/// node becomes the node's. A CAN-ID that the device receives, or that is switched off, stays.
pub(super) fn rebased(at: Multiplexer, raw: u64, own: Option<NodeId>, node: NodeId) -> Result<u64, BadSetting> {
    let (Some(of), Some(side), Ok(number)) = (own.filter(|own| *own != node), side(at), u32::try_from(raw)) else {
        return Ok(raw);
    };
    let cob_id = CobId(number);
    let can_id = cob_id.can_id();
    if !cob_id.is_extended() && is_predefined(at.index.0, can_id) && can_id & 0x7F == u32::from(of.raw()) {
        return Ok(u64::from(number - u32::from(of.raw()) + u32::from(node.raw())));
    }
    match side {
        Side::Sends if cob_id.is_valid() && can_id != 0 => Err(BadSetting::Shared { at, can_id, of, node }),
        _ => Ok(raw),
    }
}

/// The side of a parameter with a COB-ID of one device; `None` for other entries, and for SYNC and TIME, whose COB-IDs
/// all devices share.
const fn side(at: Multiplexer) -> Option<Side> {
    match (at.index.0, at.sub.0) {
        (object::COB_ID_EMCY, 0) | (0x1800..=0x19FF, 1) => Some(Side::Sends),
        // Request and response of an SDO channel are between two devices only.
        (0x1200..=0x12FF, 1 | 2) => Some(Side::Sends),
        (0x1400..=0x15FF, 1) | (object::EMERGENCY_CONSUMER, 1..) => Some(Side::Receives),
        _ => None,
    }
}

/// Whether the predefined connection set has the CAN-ID for such an object (CiA 301, 7.3.3): EMCY, PDOs or SDO.
const fn is_predefined(index: u16, can_id: u32) -> bool {
    match index {
        object::COB_ID_EMCY | object::EMERGENCY_CONSUMER => matches!(can_id, 0x081..=0x0FF),
        0x1200..=0x12FF => matches!(can_id, 0x581..=0x5FF | 0x601..=0x67F),
        _ => matches!(can_id, 0x181..=0x57F),
    }
}
