//! The use of each CAN-ID of a bus.

use super::sdo::ChannelIndex;
use crate::NodeId;
use crate::message::PdoNumber;
use crate::wire::flying_master::FlyingMaster;
use crate::wire::{case_marker, emcy, error_control, lss, nmt, pdo, sdo, srdo, sync, time};
use std::collections::{BTreeMap, BTreeSet};

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
    /// No known use. 101h to 180h may be SRDOs.
    Unknown,
}

/// The source of the knowledge about a CAN-ID. A later variant overrides earlier ones.
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
#[derive(Clone)]
pub struct CobIds {
    table: Box<[(Use, Source)]>,
    /// The CAN-IDs with another use than in the predefined connection set, by [`rank`], so that a boot-up checks only
    /// the CAN-IDs of its node.
    moved: BTreeSet<(u32, u16)>,
    /// By CAN-ID: the number of frames that did not fit a learned use, minus the number of frames that did.
    misfits: BTreeMap<u16, u16>,
    /// The number of changes of uses.
    changes: u64,
}

impl Default for CobIds {
    fn default() -> Self {
        Self {
            table: (0..=0x7FF).map(|id| (predefined(id), Source::Predefined)).collect(),
            moved: BTreeSet::new(),
            misfits: BTreeMap::new(),
            changes: 0,
        }
    }
}

impl CobIds {
    /// The use of a CAN-ID and its source.
    #[inline]
    pub fn get(&self, can_id: u16) -> (Use, Source) {
        self.table.get(usize::from(can_id)).copied().unwrap_or((Use::Unknown, Source::Predefined))
    }

    /// The number of changes of uses.
    #[inline]
    pub const fn changes(&self) -> u64 {
        self.changes
    }

    /// The CAN-ID of a use, the lowest if there are several.
    pub fn place(&self, used: Use) -> Option<u16> {
        let home = home(used).filter(|id| self.get(*id).0 == used);
        let moved = self.moved.range((rank(used), 0)..=(rank(used), u16::MAX)).next().map(|moved| moved.1);
        home.into_iter().chain(moved).min()
    }

    /// The CAN-IDs of a node in order, without its further SDO channels.
    pub fn of_node(&self, node: NodeId) -> impl Iterator<Item = (u16, Use, Source)> {
        let mut ids: Vec<u16> = homes(node).chain(self.moved_of(node)).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.into_iter()
            .map(|id| (id, self.get(id)))
            .filter_map(move |(id, (used, source))| (owner(used) == Some(node)).then_some((id, used, source)))
    }

    /// The CAN-IDs to which uses of a node have moved.
    fn moved_of(&self, node: NodeId) -> impl Iterator<Item = u16> {
        let first = u32::from(node.raw()) << NODE;
        self.moved.range((first, 0)..(first + (1 << NODE), 0)).map(|moved| moved.1)
    }

    /// Sets an entry. No other function changes the table.
    fn set(&mut self, can_id: u16, entry: (Use, Source)) {
        let Some(place) = self.table.get_mut(usize::from(can_id)) else { return };
        let before = std::mem::replace(place, entry);
        self.changes += u64::from(before != entry);
        self.moved.remove(&(rank(before.0), can_id));
        if entry != (predefined(can_id), Source::Predefined) && entry.0 != Use::Unknown {
            self.moved.insert((rank(entry.0), can_id));
        }
    }

    /// Sets the use of a CAN-ID, unless a better source has set it.
    pub fn assign(&mut self, can_id: u32, used: Use, source: Source) {
        if let Ok(can_id) = u16::try_from(can_id)
            && self.get(can_id).1 <= source
        {
            self.set(can_id, (used, source));
        }
    }

    /// Removes a use from every CAN-ID but `keep`, because it has moved there or ended.
    ///
    /// A use that the predefined connection set gives to a CAN-ID stays only if a better source confirms it. A node's
    /// first SDO server stays in any case: 1200h is read-only (CiA 301 7.5.2.33), and devices that accept another
    /// value still answer on their default CAN-IDs.
    pub fn release(&mut self, used: Use, keep: Option<u32>) {
        let moved = self.moved.range((rank(used), 0)..=(rank(used), u16::MAX)).map(|moved| moved.1);
        let stays = matches!(used, Use::SdoRequest(_) | Use::SdoResponse(_));
        let ids: Vec<u16> = home(used).filter(|_| !stays).into_iter().chain(moved).collect();
        for id in ids {
            if self.get(id).0 == used && Some(u32::from(id)) != keep {
                let default = predefined(id);
                self.set(
                    id,
                    if default == used { (Use::Unknown, Source::Trace) } else { (default, Source::Predefined) },
                );
            }
        }
    }

    /// Number of misfitting frames that disprove a learned use.
    const DISPROVED: u16 = 100;

    /// Counts whether a frame fits the learned use of its CAN-ID; a disproved use is dropped.
    #[cold]
    pub fn judge(&mut self, can_id: u16, fits: bool) {
        let misfits = self.misfits.entry(can_id).or_default();
        *misfits = if fits { misfits.saturating_sub(1) } else { *misfits + 1 };
        if *misfits == 0 {
            self.misfits.remove(&can_id);
        } else if *misfits >= Self::DISPROVED {
            self.set(can_id, (predefined(can_id), Source::Predefined));
            self.misfits.remove(&can_id);
        }
    }

    /// Whether frames of this CAN-ID have not fitted its use.
    #[inline]
    pub fn is_doubted(&self, can_id: u16) -> bool {
        !self.misfits.is_empty() && self.misfits.contains_key(&can_id)
    }

    /// Restores the uses of the predefined connection set, as a reset of the node does.
    pub fn reset(&mut self, node: NodeId) {
        let ids: Vec<u16> = homes(node).chain(self.moved_of(node)).collect();
        for id in ids {
            self.set(id, (predefined(id), Source::Predefined));
        }
    }
}

/// The lowest bit of the node-ID in a [`rank`].
const NODE: u32 = 20;

/// A sort key for uses; the uses of one node are adjacent.
fn rank(used: Use) -> u32 {
    let node = owner(used).map_or(0, |node| u32::from(node.raw())) << NODE;
    node | match used {
        Use::Emcy(_) => 1,
        Use::ErrorControl(_) => 2,
        Use::Pdo(_, PdoNumber::Transmit(number)) => 1 << 16 | u32::from(number),
        Use::Pdo(_, PdoNumber::Receive(number)) => 2 << 16 | u32::from(number),
        Use::Srdo(_, number, half) => 3 << 16 | u32::from(number) << 1 | half as u32,
        Use::SdoRequest(channel) => 4 << 16 | u32::from(channel.0),
        Use::SdoResponse(channel) => 5 << 16 | u32::from(channel.0),
        Use::Nmt => 3,
        Use::Sync => 4,
        Use::Time => 5,
        Use::LssRequest => 6,
        Use::LssResponse => 7,
        Use::GlobalFailSafe => 8,
        Use::FlyingMaster => 9,
        Use::CaseMarker => 10,
        Use::Unknown => 11,
    }
}

/// The CAN-IDs that the predefined connection set gives to a node.
fn homes(node: NodeId) -> impl Iterator<Item = u16> {
    let ids = (0..16).map(move |function: u16| function << 7 | u16::from(node.raw()));
    ids.filter(move |id| owner(predefined(*id)) == Some(node))
}

/// The CAN-ID that the predefined connection set gives to a use that can move.
fn home(used: Use) -> Option<u16> {
    match used {
        Use::Sync => Some(sync::CAN_ID),
        Use::Time => Some(time::CAN_ID),
        _ => homes(owner(used)?).find(|id| predefined(*id) == used),
    }
}

/// The node that sends the messages of this use, or that serves its default SDO channel.
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

/// Whether no standard defines a use of this CAN-ID.
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
        // NMT has only 000h, and TIME has only 100h.
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

    /// The index of moved uses finds the same CAN-IDs as a search through the whole table.
    #[test]
    fn places_are_those_of_the_table() {
        let mut ids = CobIds::default();
        let mut random = 1_u64;
        let mut next = |below: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) % below
        };
        for _ in 0..20_000 {
            let (id, at) = (next(0x800) as u16, node(1 + next(4) as u8));
            let used = match next(7) {
                0 => Use::Sync,
                1 => Use::Emcy(at),
                2 => Use::Srdo(at, 1 + next(3) as u8, srdo::Half::Inverted),
                3 => Use::SdoRequest(ChannelIndex(next(130) as u16)),
                4 => Use::SdoResponse(ChannelIndex(next(130) as u16)),
                5 => Use::Pdo(at, PdoNumber::Receive(1 + next(6) as u16)),
                _ => Use::Pdo(at, PdoNumber::Transmit(1 + next(6) as u16)),
            };
            let source = if next(2) == 0 { Source::Trace } else { Source::Description };
            match next(8) {
                0 => ids.reset(at),
                1 => ids.release(used, None),
                2 => ids.release(used, Some(u32::from(id))),
                _ => ids.assign(u32::from(id), used, source),
            }
            let in_table = |used| (0..0x800).find(|id| ids.get(*id).0 == used);
            assert_eq!(ids.place(used), in_table(used), "{used:?}");
            let own: Vec<u16> = (0..0x800).filter(|id| owner(ids.get(*id).0) == Some(at)).collect();
            assert_eq!(ids.of_node(at).map(|row| row.0).collect::<Vec<_>>(), own);
        }
        NodeId::all().for_each(|node| ids.reset(node));
        ids.release(Use::Sync, None);
        for channel in [127, 128].map(ChannelIndex) {
            ids.release(Use::SdoRequest(channel), None);
            ids.release(Use::SdoResponse(channel), None);
        }
        ids.release(Use::SdoResponse(ChannelIndex(129)), None);
        assert!(ids.moved.iter().all(|moved| ids.get(moved.1).0 == Use::SdoRequest(ChannelIndex(129))));
    }
}
