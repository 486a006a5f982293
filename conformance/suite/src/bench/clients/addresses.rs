//! The CAN-IDs that concern the device under test, according to its object dictionary.

use crate::bench::foreign::Form;
use crate::foreign::ForeignKind;
use canvass_analyzer::wire::layer_setting::MASTER_CAN_ID;
use canvass_analyzer::wire::{error_control, nmt, pdo, sdo, sync, time};
use canvass_analyzer::{CobId, Multiplexer, NodeId, object};
use std::collections::{BTreeMap, BTreeSet};

/// The CAN-IDs on which the device listens, and the CAN-IDs with which it sends.
#[derive(Clone, Debug)]
pub struct Addresses {
    node: NodeId,
    listens: BTreeMap<u16, ForeignKind>,
    /// CAN-IDs that the device itself may send: their frames do not come from others.
    sends: BTreeSet<u16>,
    makes_sync: bool,
    makes_time: bool,
}

impl Addresses {
    /// The addresses of a device of which only the node-ID is known: the predefined connection set.
    pub fn predefined(node: NodeId) -> Self {
        let mut addresses = Self::of_values(node, std::iter::empty());
        let rpdos = pdo::RPDO_BASES.map(|base| (base + u16::from(node.raw()), ForeignKind::Rpdo));
        addresses.listens.extend(rpdos);
        addresses.listens.extend([(sync::CAN_ID, ForeignKind::Sync), (time::CAN_ID, ForeignKind::Time)]);
        addresses
    }

    /// The addresses of a device with these values in its dictionary. Its first SDO channel has the predefined CAN-IDs.
    pub(crate) fn of_values(node: NodeId, values: impl Iterator<Item = (Multiplexer, u32)>) -> Self {
        let request = sdo::REQUEST_BASE + u16::from(node.raw());
        let listens = BTreeMap::from([(request, ForeignKind::SdoRead)]);
        let mut addresses = Self { node, listens, sends: BTreeSet::new(), makes_sync: false, makes_time: false };
        values.for_each(|(at, value)| addresses.learn(at, value));
        addresses
    }

    /// Adds the addresses that an object holds. Earlier addresses stay: the device may still use them.
    pub fn learn(&mut self, at: Multiplexer, value: u32) {
        let (index, sub) = (at.index.0, at.sub.0);
        let cob_id = CobId(value);
        let can_id = (!cob_id.is_extended()).then_some((value & 0x7FF) as u16);
        let valid = can_id.filter(|_| cob_id.is_valid());
        match (index, sub) {
            (object::COB_ID_SYNC, 0) => {
                self.makes_sync |= value & CobId::NO_RTR != 0;
                self.listen(can_id, ForeignKind::Sync);
            }
            (object::COB_ID_TIME, 0) => {
                self.makes_time |= value & CobId::NO_RTR != 0;
                let consumed = can_id.filter(|_| value & CobId::INVALID != 0);
                self.listen(consumed, ForeignKind::Time);
            }
            (object::CONSUMER_HEARTBEAT_TIME, 1..) => {
                let watched = NodeId::new((value >> 16 & 0xFF) as u8).filter(|_| value & 0xFFFF != 0);
                let id = watched.map(|node| error_control::CAN_ID_BASE + u16::from(node.raw()));
                self.listen(id, ForeignKind::Heartbeat);
            }
            (object::FURTHER_SDO_SERVER_PARAMETER..object::SDO_CLIENT_PARAMETER, 1) => {
                self.listen(valid, ForeignKind::SdoRead);
            }
            (index, 1) if object::is_rpdo_communication(index) => {
                self.listen(valid, ForeignKind::Rpdo);
            }
            (object::COB_ID_EMCY, 0) | (object::FURTHER_SDO_SERVER_PARAMETER..object::SDO_CLIENT_PARAMETER, 2) => {
                self.sends.extend(valid);
            }
            (index, 1) if object::is_tpdo_communication(index) || is_sdo_client(index) => self.sends.extend(valid),
            _ => {}
        }
    }

    /// Adds a CAN-ID with its meaning. A CAN-ID with two meanings keeps the first.
    fn listen(&mut self, can_id: Option<u16>, kind: ForeignKind) {
        if let Some(can_id) = can_id {
            self.listens.entry(can_id).or_insert(kind);
        }
    }

    /// The meaning of a frame of this form and CAN-ID for the device; `None` if the frame does not concern it or is its
    /// own.
    pub fn kind(&self, can_id: u16, form: Form) -> Option<ForeignKind> {
        let guarded = error_control::CAN_ID_BASE + u16::from(self.node.raw());
        match (can_id, form) {
            (_, Form::Remote) => (can_id == guarded).then_some(ForeignKind::Guarding),
            _ if self.sends.contains(&can_id) => None,
            (nmt::CAN_ID, _) => Some(ForeignKind::Nmt),
            (MASTER_CAN_ID, _) => Some(ForeignKind::LayerSetting),
            (_, form) => match self.listens.get(&can_id).copied()? {
                ForeignKind::Sync if self.makes_sync => None,
                ForeignKind::Time if self.makes_time => None,
                ForeignKind::SdoRead if form == Form::SdoWrite => Some(ForeignKind::SdoWrite),
                kind => Some(kind),
            },
        }
    }
}

/// Whether an index belongs to an SDO client parameter.
fn is_sdo_client(index: u16) -> bool {
    (object::SDO_CLIENT_PARAMETER..object::SDO_CLIENT_PARAMETER + 0x80).contains(&index)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node() -> NodeId {
        NodeId::new(63).unwrap()
    }

    fn of(values: &[(u16, u8, u32)]) -> Addresses {
        Addresses::of_values(node(), values.iter().map(|&(index, sub, value)| (Multiplexer::new(index, sub), value)))
    }

    #[test]
    fn a_device_of_which_nothing_is_known_has_the_predefined_connection_set() {
        let kind = |can_id, form| Addresses::predefined(node()).kind(can_id, form);
        for (can_id, form, expected) in [
            (0x000, Form::Data, ForeignKind::Nmt),
            (0x080, Form::Data, ForeignKind::Sync),
            (0x100, Form::Data, ForeignKind::Time),
            (0x23F, Form::Data, ForeignKind::Rpdo),
            (0x53F, Form::Data, ForeignKind::Rpdo),
            (0x63F, Form::Data, ForeignKind::SdoRead),
            (0x63F, Form::SdoWrite, ForeignKind::SdoWrite),
            (0x73F, Form::Remote, ForeignKind::Guarding),
            (0x7E5, Form::SdoWrite, ForeignKind::LayerSetting),
        ] {
            assert_eq!(kind(can_id, form), Some(expected), "{can_id:03X} {form:?}");
        }
        for (can_id, form) in [(0x23E, Form::Data), (0x63E, Form::Data), (0x73F, Form::Data), (0x63F, Form::Remote)] {
            assert_eq!(kind(can_id, form), None, "{can_id:03X} {form:?}");
        }
    }

    #[test]
    fn what_a_device_holds_says_what_it_listens_to() {
        let addresses = of(&[
            (0x1005, 0, 0x81),
            (0x1012, 0, 0x8000_0101),
            (0x1016, 1, 0x0005_03E8),
            (0x1016, 2, 0x0006_0000),
            (0x1201, 1, 0x6A1),
            (0x1201, 2, 0x5A1),
            (0x1400, 1, 0x3A0),
            (0x1401, 1, 0x8000_03A1),
            (0x1402, 1, 0x2000_03A2),
        ]);
        let kind = |can_id| addresses.kind(can_id, Form::Data);
        assert_eq!((kind(0x81), kind(0x101)), (Some(ForeignKind::Sync), Some(ForeignKind::Time)));
        assert_eq!((kind(0x705), kind(0x706)), (Some(ForeignKind::Heartbeat), None), "node 6 is not watched");
        assert_eq!((kind(0x6A1), kind(0x63F)), (Some(ForeignKind::SdoRead), Some(ForeignKind::SdoRead)));
        assert_eq!(addresses.kind(0x6A1, Form::SdoWrite), Some(ForeignKind::SdoWrite));
        assert_eq!((kind(0x3A0), kind(0x3A1), kind(0x3A2)), (Some(ForeignKind::Rpdo), None, None));
        assert_eq!((kind(0x80), kind(0x100), kind(0x23F)), (None, None, None), "it has none of these");
        assert_eq!(of(&[(0x1012, 0, 0x100)]).kind(0x100, Form::Data), None, "it does not consume TIME");
    }

    /// Messages that the device produces, or is configured to produce, need not come from others.
    #[test]
    fn what_a_device_sends_itself_is_not_of_others() {
        let producer = of(&[(0x1005, 0, 0x4000_0080), (0x1012, 0, 0xC000_0100)]);
        assert_eq!((producer.kind(0x80, Form::Data), producer.kind(0x100, Form::Data)), (None, None));
        let mut addresses = Addresses::predefined(node());
        addresses.learn(Multiplexer::new(0x1005, 0), 0x4000_0090);
        assert_eq!(addresses.kind(0x80, Form::Data), None, "it may go on with the CAN-ID of before");
        addresses.learn(Multiplexer::new(0x1800, 1), 0x4000_063F);
        assert_eq!(addresses.kind(0x63F, Form::Data), None);
        addresses.learn(Multiplexer::new(0x1280, 1), 0x23F);
        addresses.learn(Multiplexer::new(0x1801, 1), 0x8000_033F);
        assert_eq!(
            (addresses.kind(0x23F, Form::Data), addresses.kind(0x33F, Form::Data)),
            (None, Some(ForeignKind::Rpdo))
        );
    }
}
