//! What each CAN-ID of a bus is used for.

use super::sdo::ChannelIndex;
use crate::NodeId;
use crate::message::PdoNumber;
use crate::wire::flying_master::FlyingMaster;
use crate::wire::{case_marker, emcy, error_control, lss, nmt, pdo, sdo, srdo, sync, time};
use std::collections::BTreeMap;

/// The use of a CAN-ID.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Use {
    /// NMT commands.
    Nmt,
    /// SYNC.
    Sync,
    /// TIME.
    Time,
    /// EMCY of a node.
    Emcy(NodeId),
    /// A PDO of a node.
    Pdo(NodeId, PdoNumber),
    /// An SDO channel, client to server.
    SdoRequest(ChannelIndex),
    /// An SDO channel, server to client.
    SdoResponse(ChannelIndex),
    /// Boot-up, heartbeat and guarding of a node.
    ErrorControl(NodeId),
    /// LSS or LMT, master to slaves.
    LssRequest,
    /// LSS or LMT, slave to master.
    LssResponse,
    /// One of the two CAN-IDs of an SRDO of a node, with its number.
    Srdo(NodeId, u8, srdo::Half),
    /// The global fail-safe command.
    GlobalFailSafe,
    /// The services of flying master, by the CAN-ID.
    FlyingMaster,
    /// Case markers of CiA's test tool.
    CaseMarker,
    /// No use is known. 101h to 180h may be SRDOs.
    Unknown,
}

/// Where the use of a CAN-ID is known from. A later one overrules the earlier ones.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Source {
    /// The predefined connection set of CiA 301.
    Predefined,
    /// A device description.
    Description,
    /// SDO traffic in the trace itself.
    Trace,
}

/// The uses of all 11-bit CAN-IDs of one bus.
pub struct CobIds {
    table: Box<[(Use, Source)]>,
    /// How many frames more did not fit a learned use than did, by CAN-ID.
    misfits: BTreeMap<u16, u16>,
}

impl Default for CobIds {
    fn default() -> Self {
        Self { table: (0..=0x7FF).map(|id| (predefined(id), Source::Predefined)).collect(), misfits: BTreeMap::new() }
    }
}

impl CobIds {
    /// The use of a CAN-ID and where it is known from.
    #[inline]
    pub fn get(&self, can_id: u16) -> (Use, Source) {
        self.table.get(usize::from(can_id)).copied().unwrap_or((Use::Unknown, Source::Predefined))
    }

    /// The CAN-ID of a use, the lowest if there are several.
    pub fn place(&self, used: Use) -> Option<u16> {
        self.table.iter().position(|entry| entry.0 == used).and_then(|id| u16::try_from(id).ok())
    }

    /// All CAN-IDs with their uses.
    pub fn iter(&self) -> impl Iterator<Item = (u16, Use, Source)> {
        (0_u16..).zip(&self.table).map(|(id, &(used, source))| (id, used, source))
    }

    /// Sets the use of a CAN-ID, unless a better source said otherwise.
    pub fn assign(&mut self, can_id: u32, used: Use, source: Source) {
        if let Some(entry) = self.table.get_mut(can_id as usize)
            && entry.1 <= source
        {
            *entry = (used, source);
        }
    }

    /// Takes a use off every CAN-ID but `keep`: it has moved there, or ended.
    ///
    /// The CAN-ID that the predefined connection set gives to this very use is left as it is known by default only
    /// where nothing better is known: then it has no use any more.
    pub fn release(&mut self, used: Use, keep: Option<u32>) {
        for (id, entry) in (0_u32..).zip(self.table.iter_mut()) {
            if entry.0 == used && Some(id) != keep {
                let default = predefined(id as u16);
                *entry = if default == used { (Use::Unknown, Source::Trace) } else { (default, Source::Predefined) };
            }
        }
    }

    /// So many frames that do not fit a learned use disprove it.
    const DISPROVED: u16 = 100;

    /// A frame has fitted the learned use of its CAN-ID, or has not: one that is disproved is given up.
    #[cold]
    pub fn judge(&mut self, can_id: u16, fits: bool) {
        let misfits = self.misfits.entry(can_id).or_default();
        *misfits = if fits { misfits.saturating_sub(1) } else { *misfits + 1 };
        if *misfits == 0 {
            self.misfits.remove(&can_id);
        } else if *misfits >= Self::DISPROVED
            && let Some(entry) = self.table.get_mut(usize::from(can_id))
        {
            *entry = (predefined(can_id), Source::Predefined);
            self.misfits.remove(&can_id);
        }
    }

    /// Whether frames of that CAN-ID have not fitted its use.
    #[inline]
    pub fn is_doubted(&self, can_id: u16) -> bool {
        !self.misfits.is_empty() && self.misfits.contains_key(&can_id)
    }

    /// Gives a CAN-ID back to the predefined connection set, as a reset of its node does.
    pub fn reset(&mut self, node: NodeId) {
        for (id, entry) in (0_u16..).zip(self.table.iter_mut()) {
            let default = predefined(id);
            if owner(entry.0) == Some(node) || owner(default) == Some(node) {
                *entry = (default, Source::Predefined);
            }
        }
    }
}

/// The node that sends or serves on such a CAN-ID.
fn owner(used: Use) -> Option<NodeId> {
    match used {
        Use::Emcy(node) | Use::Pdo(node, _) | Use::Srdo(node, ..) | Use::ErrorControl(node) => Some(node),
        Use::SdoRequest(channel) | Use::SdoResponse(channel) => channel.predefined_server(),
        _ => None,
    }
}

/// The predefined connection set (CiA 301), with LSS (CiA 305), flying master (CiA 302-2) and the global fail-safe
/// command (CiA 304).
fn predefined(can_id: u16) -> Use {
    match can_id {
        nmt::CAN_ID => return Use::Nmt,
        sync::CAN_ID => return Use::Sync,
        time::CAN_ID => return Use::Time,
        lss::MASTER_CAN_ID => return Use::LssRequest,
        lss::SLAVE_CAN_ID => return Use::LssResponse,
        srdo::GLOBAL_FAIL_SAFE_CAN_ID => return Use::GlobalFailSafe,
        case_marker::CAN_ID => return Use::CaseMarker,
        id if FlyingMaster::CAN_IDS.contains(&id) => return Use::FlyingMaster,
        _ => {}
    }
    let Some(node) = NodeId::of_cob_id(can_id) else { return Use::Unknown };
    match can_id & !0x7F {
        emcy::CAN_ID_BASE => Use::Emcy(node),
        sdo::REQUEST_BASE => Use::SdoRequest(ChannelIndex::predefined(node)),
        sdo::RESPONSE_BASE => Use::SdoResponse(ChannelIndex::predefined(node)),
        error_control::CAN_ID_BASE => Use::ErrorControl(node),
        base => predefined_pdo(base).map_or(Use::Unknown, |number| Use::Pdo(node, number)),
    }
}

/// Whether no standard gives that CAN-ID to anything.
pub fn is_free(can_id: u16) -> bool {
    predefined(can_id) == Use::Unknown
}

fn predefined_pdo(base: u16) -> Option<PdoNumber> {
    let find = |bases: [u16; 4]| (1..).zip(bases).find(|row| row.1 == base).map(|row| row.0);
    find(pdo::TPDO_BASES).map(PdoNumber::Transmit).or_else(|| find(pdo::RPDO_BASES).map(PdoNumber::Receive))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(raw: u8) -> NodeId {
        NodeId::new(raw).unwrap()
    }

    #[test]
    fn the_predefined_connection_set() {
        let ids = CobIds::default();
        let used = |id| ids.get(id).0;
        assert_eq!(used(0x000), Use::Nmt);
        assert_eq!(used(0x080), Use::Sync);
        assert_eq!(used(0x0BF), Use::Emcy(node(63)));
        assert_eq!(used(0x100), Use::Time);
        assert_eq!(used(0x1BF), Use::Pdo(node(63), PdoNumber::Transmit(1)));
        assert_eq!(used(0x57F), Use::Pdo(node(127), PdoNumber::Receive(4)));
        assert_eq!(used(0x5BF), Use::SdoResponse(ChannelIndex::predefined(node(63))));
        assert_eq!(used(0x63F), Use::SdoRequest(ChannelIndex::predefined(node(63))));
        assert_eq!(used(0x73F), Use::ErrorControl(node(63)));
        assert_eq!(used(0x7E5), Use::LssRequest);
        // Neither NMT nor TIME: only 000h and 100h are.
        assert_eq!((used(0x001), used(0x071)), (Use::GlobalFailSafe, Use::FlyingMaster));
        for id in (0x002..=0x070).chain(0x077..=0x07F).chain(0x101..=0x17F).chain([0x180, 0x580, 0x680, 0x780]) {
            assert_eq!(used(id), Use::Unknown, "{id:03X}");
        }
    }

    #[test]
    fn a_moved_use_leaves_its_old_place_and_comes_back_after_a_reset() {
        let mut ids = CobIds::default();
        let tpdo = Use::Pdo(node(5), PdoNumber::Transmit(1));
        ids.assign(0x10A, tpdo, Source::Trace);
        ids.release(tpdo, Some(0x10A));
        assert_eq!(ids.get(0x10A), (tpdo, Source::Trace));
        assert_eq!(ids.get(0x185).0, Use::Unknown);
        ids.assign(0x10A, Use::Sync, Source::Description);
        assert_eq!(ids.get(0x10A).0, tpdo, "the trace knows better than a description");
        ids.reset(node(5));
        assert_eq!((ids.get(0x10A).0, ids.get(0x185).0), (Use::Unknown, tpdo));
    }
}
