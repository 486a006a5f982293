//! SRDO: safety-relevant data, sent twice (CiA 304, EN 50325-5), and the global fail-safe command.
//!
//! ```text
//! odd CAN-ID 101h..17Fh:  the data
//! the even one after it:  the same data with every bit inverted
//! 001h:                   global fail-safe command
//! 1301h..1340h:05, :06:   the two CAN-IDs; :01 no SRDO (0), the node sends it (1), the node receives it (2)
//! 1381h..13C0h:           the mapping: odd sub-indexes the data, even ones the inverted data
//! ```
//!
//! The pair of node n (1 to 64) is 0FFh + 2n and 100h + 2n. CAN-IDs 101h to 180h may as well carry a PDO, so that
//! only the inverted twin makes a frame an SRDO.

use crate::NodeId;
use std::fmt;

/// The CAN-ID of the global fail-safe command.
pub(crate) const GLOBAL_FAIL_SAFE_CAN_ID: u16 = 0x001;
/// The CAN-IDs of the predefined pairs.
pub const CAN_IDS: std::ops::RangeInclusive<u16> = 0x101..=0x180;
/// The CAN-ID of the data of node 0; twice the node-ID is added.
pub const CAN_ID_BASE: u16 = 0x0FF;

/// The number of the SRDO whose communication parameters have this index.
pub const fn of_communication_index(index: u16) -> Option<u8> {
    match index {
        0x1301..=0x1340 => Some((index - 0x1300) as u8),
        _ => None,
    }
}

/// The index of the mapping parameters of an SRDO.
pub const fn mapping_index(number: u8) -> u16 {
    0x1380 + number as u16
}

/// A pair of CAN-IDs, by the node of the predefined set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Pair(u8);

/// The half of a pair.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Half {
    /// The data.
    Normal,
    /// The inverted data.
    Inverted,
}

/// One frame of an SRDO.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Srdo {
    /// The number of the SRDO from 1, if its parameters (1301h and the following) are known.
    pub number: Option<u8>,
    /// The half.
    pub half: Half,
    /// The relation to the other half.
    pub fit: Fit,
}

/// The relation between the data and the inverted data.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Fit {
    /// Every bit is inverted.
    Inverse,
    /// The inverted frame is not the inverse of the data.
    Different,
    /// The other frame did not come, or came too late.
    Alone,
}

impl Pair {
    /// The pair of a CAN-ID and its half; `None` outside [`CAN_IDS`].
    pub fn of(can_id: u16) -> Option<(Self, Half)> {
        let half = if can_id % 2 == 1 { Half::Normal } else { Half::Inverted };
        CAN_IDS.contains(&can_id).then(|| (Self(((can_id - CAN_ID_BASE) / 2) as u8), half))
    }

    /// The pair of a node in the predefined set, which covers 64 nodes.
    pub const fn of_node(node: NodeId) -> Option<Self> {
        if node.raw() <= 64 { Some(Self(node.raw())) } else { None }
    }

    /// The node of the predefined set, 1 to 64.
    pub const fn node(self) -> Option<NodeId> {
        NodeId::new(self.0)
    }

    /// The index, 0 to 63.
    pub const fn position(self) -> usize {
        self.0 as usize - 1
    }

    /// The CAN-ID of a half.
    pub const fn can_id(self, half: Half) -> u16 {
        let normal = CAN_ID_BASE + 2 * self.0 as u16;
        match half {
            Half::Normal => normal,
            Half::Inverted => normal + 1,
        }
    }
}

/// Whether two payloads are each other's inverse. Empty payloads prove nothing, so they do not count as inverse.
pub(crate) fn is_inverse(normal: &[u8], inverted: &[u8]) -> bool {
    !normal.is_empty() && normal.len() == inverted.len() && normal.iter().zip(inverted).all(|(a, b)| *a == !*b)
}

impl fmt::Display for Srdo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.number {
            Some(number) => write!(f, "SRDO {number} ")?,
            None => f.write_str("SRDO ")?,
        }
        f.write_str(match self.half {
            Half::Normal => "data",
            Half::Inverted => "inverted data",
        })?;
        f.write_str(match (self.half, self.fit) {
            (_, Fit::Inverse) | (Half::Normal, Fit::Alone) => "",
            (_, Fit::Different) => ", not the inverse of the data",
            (Half::Inverted, Fit::Alone) => ", without the data before it",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_the_predefined_set() {
        let node = |raw| NodeId::new(raw).unwrap();
        assert_eq!(Pair::of(0x101), Some((Pair::of_node(node(1)).unwrap(), Half::Normal)));
        assert_eq!(Pair::of(0x102), Some((Pair::of_node(node(1)).unwrap(), Half::Inverted)));
        assert_eq!(Pair::of(0x180), Some((Pair::of_node(node(64)).unwrap(), Half::Inverted)));
        assert_eq!((Pair::of(0x100), Pair::of(0x181), Pair::of_node(node(65))), (None, None, None));
        for can_id in CAN_IDS {
            let (pair, half) = Pair::of(can_id).unwrap();
            assert_eq!(pair.can_id(half), can_id);
            assert!(pair.position() < 64 && pair.node().is_some());
        }
    }

    #[test]
    fn only_the_inverse_makes_a_pair() {
        assert!(is_inverse(&[0x00, 0xA5], &[0xFF, 0x5A]));
        assert!(!is_inverse(&[0x00, 0xA5], &[0xFF, 0x5B]));
        assert!(!is_inverse(&[0x00], &[0xFF, 0xFF]));
        assert!(!is_inverse(&[], &[]));
    }
}
