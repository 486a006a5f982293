//! Node-IDs, COB-IDs and object addresses, by the names of CiA 301.

use std::fmt;

/// A node-ID, 1 to 127.
///
/// ```
/// use canvass_analyzer::NodeId;
///
/// assert_eq!(NodeId::new(5), NodeId::of_cob_id(0x585), "the SDO responses of node 5");
/// assert_eq!((NodeId::new(0), NodeId::new(128)), (None, None));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// The lowest node-ID.
    pub const MIN: Self = Self(1);
    /// The highest node-ID.
    pub const MAX: Self = Self(127);

    /// The node-ID with the number `raw`, or `None` outside 1..=127.
    pub const fn new(raw: u8) -> Option<Self> {
        match raw {
            1..=127 => Some(Self(raw)),
            _ => None,
        }
    }

    /// The node-ID in the lower seven bits of a CAN-ID of the predefined connection set; `None` if they are 0.
    pub const fn of_cob_id(cob_id: u16) -> Option<Self> {
        Self::new((cob_id & 0x7F) as u8)
    }

    /// The number, 1 to 127.
    pub const fn raw(self) -> u8 {
        self.0
    }

    /// All node-IDs, in their order.
    pub const ALL: [Self; 127] = {
        let mut all = [Self::MIN; 127];
        let mut at = 0;
        while at < 127 {
            all[at] = Self(at as u8 + 1);
            at += 1;
        }
        all
    };

    /// All node-IDs.
    pub fn all() -> impl Iterator<Item = Self> {
        (1..=127).map(Self)
    }
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

impl fmt::Debug for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "NodeId({})", self.0)
    }
}

/// The value of a COB-ID parameter such as 1005h, 1014h, 1200h:1 or 1800h:1: a CAN-ID and three control bits,
/// whose meaning depends on the object (CiA 301).
///
/// ```
/// use canvass_analyzer::CobId;
///
/// let tpdo1_of_node_5 = CobId(0x4000_0185);
/// assert!(tpdo1_of_node_5.is_valid() && !tpdo1_of_node_5.allows_rtr());
/// assert_eq!(tpdo1_of_node_5.can_id(), 0x185);
/// assert!(CobId(0x0000_0601).is_restricted(), "SDO requests of the default channel");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct CobId(pub u32);

impl CobId {
    /// Bit 31: the PDO, SDO or EMCY does not exist (of 1005h and 1012h: the device consumes it).
    pub const INVALID: u32 = 1 << 31;
    /// Bit 30: no RTR on this PDO (of 1005h and 1012h: the device produces it).
    pub const NO_RTR: u32 = 1 << 30;
    /// Bit 29: a CAN-ID of 29 bits.
    pub const EXTENDED: u32 = 1 << 29;

    /// The CAN-ID without the control bits: 11 or 29 bits, by bit 29.
    pub const fn can_id(self) -> u32 {
        if self.0 & Self::EXTENDED != 0 { self.0 & 0x1FFF_FFFF } else { self.0 & 0x7FF }
    }

    /// Whether bit 31 is clear: the communication object exists.
    pub const fn is_valid(self) -> bool {
        self.0 & Self::INVALID == 0
    }

    /// Whether bit 30 is clear: the PDO may be asked for by a remote frame.
    pub const fn allows_rtr(self) -> bool {
        self.0 & Self::NO_RTR == 0
    }

    /// Whether the CAN-ID has 29 bits.
    pub const fn is_extended(self) -> bool {
        self.0 & Self::EXTENDED != 0
    }

    /// Whether the 11-bit CAN-ID is one that no configurable communication object may use (CiA 301, restricted
    /// CAN-IDs).
    pub const fn is_restricted(self) -> bool {
        !self.is_extended()
            && matches!(self.can_id(),
                0x000..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..=0x7FF)
    }
}

impl fmt::Display for CobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08X}h", self.0)
    }
}

impl fmt::Debug for CobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CobId({self})")
    }
}

/// The index of an object in the object dictionary.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Index(pub u16);

/// The sub-index of an object.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SubIndex(pub u8);

/// Index and sub-index together: the address in an SDO message.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Multiplexer {
    /// The index.
    pub index: Index,
    /// The sub-index.
    pub sub: SubIndex,
}

impl Multiplexer {
    /// The address `index:sub`.
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index: Index(index), sub: SubIndex(sub) }
    }

    /// Reads the three bytes of an SDO message: index low, index high, sub-index.
    pub const fn from_bytes(bytes: [u8; 3]) -> Self {
        Self::new(u16::from_le_bytes([bytes[0], bytes[1]]), bytes[2])
    }

    /// The three bytes in an SDO message.
    pub const fn to_bytes(self) -> [u8; 3] {
        let [low, high] = self.index.0.to_le_bytes();
        [low, high, self.sub.0]
    }
}

/// Writes `6000h`.
impl fmt::Display for Index {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h", self.0)
    }
}

impl fmt::Debug for Index {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Index({self})")
    }
}

/// Writes two hexadecimal digits.
impl fmt::Display for SubIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02X}", self.0)
    }
}

impl fmt::Debug for SubIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SubIndex({self})")
    }
}

const HEX: &[u8; 16] = b"0123456789ABCDEF";

/// Writes `1018h:01`.
impl fmt::Display for Multiplexer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Most lines of a trace name an object, and this is faster than `{:04X}`.
        let mut text = *b"0000h:00";
        for (n, digit) in text[..4].iter_mut().rev().enumerate() {
            *digit = HEX[usize::from(self.index.0 >> (4 * n) & 15)];
        }
        text[6] = HEX[usize::from(self.sub.0 >> 4)];
        text[7] = HEX[usize::from(self.sub.0 & 15)];
        f.write_str(std::str::from_utf8(&text).unwrap_or_default())
    }
}

impl fmt::Debug for Multiplexer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Multiplexer({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn node_ids_are_1_to_127() {
        assert_eq!((NodeId::new(0), NodeId::new(128)), (None, None));
        assert_eq!(NodeId::of_cob_id(0x73F), NodeId::new(63));
        assert_eq!(NodeId::all().count(), 127);
    }

    #[test]
    fn restricted_can_ids_are_as_cia_301_lists_them() {
        let restricted: u32 = (0..=0x7FF).filter(|&id| CobId(id).is_restricted()).count() as u32;
        // 128 + 128 + 127 + 127 + 32 + 255
        assert_eq!(restricted, 797);
        assert!(!CobId(0x080).is_restricted() && !CobId(0x181).is_restricted() && !CobId(0x600).is_restricted());
        assert!(!CobId(CobId::EXTENDED | 1).is_restricted());
    }

    #[test]
    fn multiplexers_are_little_endian() {
        assert_eq!(Multiplexer::from_bytes([0x18, 0x10, 1]), Multiplexer::new(0x1018, 1));
        assert_eq!(Multiplexer::new(0x6000, 0).to_bytes(), [0x00, 0x60, 0x00]);
        assert_eq!(Multiplexer::new(0x1018, 1).to_string(), "1018h:01");
    }
}
