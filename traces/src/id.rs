//! CAN identifiers of 11 and 29 bits.

use std::fmt;

/// A CAN identifier: 11 bits (standard) or 29 bits (extended).
///
/// The order is that of arbitration: the lower value wins the bus; if the first eleven bits are equal, the standard
/// identifier wins (ISO 11898-1).
///
/// ```
/// use canvass_traces::CanId;
///
/// let heartbeat = CanId::standard(0x701).unwrap();
/// assert_eq!((heartbeat.as_standard(), heartbeat.is_extended()), (Some(0x701), false));
/// assert_eq!(CanId::standard(0x800), None, "11 bits");
/// assert_ne!(CanId::extended(0x701).unwrap(), heartbeat);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct CanId(u32);

impl CanId {
    const EXTENDED: u32 = 1 << 31;
    /// The largest 11-bit identifier.
    pub const MAX_STANDARD: u32 = 0x7FF;
    /// The largest 29-bit identifier.
    pub const MAX_EXTENDED: u32 = 0x1FFF_FFFF;

    /// A standard identifier, or `None` above 7FFh.
    pub const fn standard(raw: u32) -> Option<Self> {
        if raw <= Self::MAX_STANDARD { Some(Self(raw)) } else { None }
    }

    /// An extended identifier, or `None` above 1FFF FFFFh.
    pub const fn extended(raw: u32) -> Option<Self> {
        if raw <= Self::MAX_EXTENDED { Some(Self(raw | Self::EXTENDED)) } else { None }
    }

    /// A standard identifier from the lower 11 bits of `raw`; the other bits are ignored.
    pub const fn standard_masked(raw: u32) -> Self {
        Self(raw & Self::MAX_STANDARD)
    }

    /// An extended identifier from the lower 29 bits of `raw`; the other bits are ignored.
    pub const fn extended_masked(raw: u32) -> Self {
        Self(raw & Self::MAX_EXTENDED | Self::EXTENDED)
    }

    /// The identifier's number, without any flag.
    pub const fn raw(self) -> u32 {
        self.0 & Self::MAX_EXTENDED
    }

    /// Whether the identifier has 29 bits.
    pub const fn is_extended(self) -> bool {
        self.0 & Self::EXTENDED != 0
    }

    /// The number of a standard identifier; `None` for 29 bits, which CANopen does not use by default.
    pub const fn as_standard(self) -> Option<u16> {
        if self.is_extended() { None } else { Some(self.0 as u16) }
    }

    /// The bits in the order of arbitration.
    const fn arbitration(self) -> (u32, bool, u32) {
        if self.is_extended() { (self.raw() >> 18, true, self.raw() & 0x3_FFFF) } else { (self.raw(), false, 0) }
    }
}

impl PartialOrd for CanId {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for CanId {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.arbitration().cmp(&other.arbitration())
    }
}

/// Three hexadecimal digits for 11 bits, eight for 29, as candump prints them.
impl fmt::Display for CanId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_extended() { write!(f, "{:08X}", self.raw()) } else { write!(f, "{:03X}", self.raw()) }
    }
}

impl fmt::Debug for CanId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CanId({self})")
    }
}

impl From<embedded_can::Id> for CanId {
    fn from(id: embedded_can::Id) -> Self {
        match id {
            embedded_can::Id::Standard(id) => Self(u32::from(id.as_raw())),
            embedded_can::Id::Extended(id) => Self(id.as_raw() | Self::EXTENDED),
        }
    }
}

impl From<CanId> for embedded_can::Id {
    fn from(id: CanId) -> Self {
        if id.is_extended() {
            embedded_can::ExtendedId::new(id.raw()).unwrap_or(embedded_can::ExtendedId::MAX).into()
        } else {
            embedded_can::StandardId::new(id.raw() as u16).unwrap_or(embedded_can::StandardId::MAX).into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits() {
        assert_eq!(CanId::standard(0x800), None);
        assert_eq!(CanId::extended(0x2000_0000), None);
        assert_eq!(CanId::extended(0x7FF).unwrap().as_standard(), None);
        assert_eq!(CanId::standard(0x7FF).unwrap().as_standard(), Some(0x7FF));
    }

    #[test]
    fn ordered_as_arbitration_orders() {
        let standard = |raw| CanId::standard(raw).unwrap();
        let extended = |raw| CanId::extended(raw).unwrap();
        assert!(standard(0x080) < standard(0x181));
        assert!(standard(0x100) < extended(0x100 << 18), "the dominant IDE bit of the standard frame wins");
        assert!(extended(0x0FF << 18) < standard(0x100), "the first eleven bits decide first");
    }
}
