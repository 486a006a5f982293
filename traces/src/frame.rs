//! One CAN frame.

use crate::CanId;
use std::fmt;

/// A CAN frame in 24 bytes.
///
/// The frame holds the whole payload of classical frames and of CAN FD frames of up to 16 bytes. Of a longer CAN FD or
/// CAN XL frame it holds the first 16 bytes; the whole payload is in the [`crate::Record`].
///
/// ```
/// use canvass_traces::{CanId, Frame};
///
/// let start_all = Frame::new(CanId::standard(0x000).unwrap(), &[0x01, 0x00]).unwrap();
/// assert_eq!((start_all.to_string(), start_all.dlc()), ("000#0100".to_owned(), 2));
/// let guarding = Frame::remote(CanId::standard(0x705).unwrap(), 1).unwrap();
/// assert!(guarding.is_remote() && guarding.data().is_empty());
/// assert!(Frame::new(CanId::standard(0x123).unwrap(), &[0; 9]).is_none(), "a classical frame has 8 bytes");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[repr(C, align(8))]
pub struct Frame {
    id: CanId,
    kind: FrameKind,
    /// Lower half: [`Flags`]. Upper half: the raw DLC of a classical frame, if it is 9 to 15.
    flags: u8,
    /// Length of the payload, up to 2048; for a remote frame the requested length.
    len: u16,
    /// The payload; bytes beyond it are zero.
    data: [u8; Frame::INLINE],
}

/// The kind of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum FrameKind {
    /// A frame with data.
    Data,
    /// A remote frame, which requests data (RTR).
    Remote,
    /// The controller's report of a bus error; no frame of the bus. The identifier holds the [`ErrorClass`].
    Error,
}

/// The flags of CAN FD and CAN XL frames.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Flags(u8);

impl Flags {
    /// Classical CAN.
    pub const NONE: Self = Self(0);
    /// Bit rate switched for the payload.
    pub const BRS: Self = Self(1);
    /// The sender is error passive.
    pub const ESI: Self = Self(2);
    /// CAN FD format.
    pub const FDF: Self = Self(4);
    /// CAN XL format.
    pub const XLF: Self = Self(8);

    /// The union of both sets of flags.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all flags of `other` are set.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The flags as a number: BRS 1, ESI 2, FDF 4, XLF 8. The first three have the numbers of SocketCAN.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The flags of a number as [`Flags::bits`] gives it; the upper half is ignored.
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & 0x0F)
    }
}

/// The class bits of an error frame, as Linux numbers them (`linux/can/error.h`).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct ErrorClass(pub u32);

impl ErrorClass {
    /// Each class bit with its name.
    pub const NAMES: [(u32, &'static str); 10] = [
        (0x001, "transmit timeout"),
        (0x002, "lost arbitration"),
        (0x004, "controller problem"),
        (0x008, "protocol violation"),
        (0x010, "transceiver status"),
        (0x020, "no acknowledgement"),
        (0x040, "bus off"),
        (0x080, "bus error"),
        (0x100, "controller restarted"),
        (0x200, "error counters"),
    ];
}

impl Frame {
    /// The bit of an identifier that marks an error frame in SocketCAN (`CAN_ERR_FLAG`).
    pub(crate) const ERROR_FLAG: u32 = 0x2000_0000;
    /// Maximum number of payload bytes inside a frame.
    pub(crate) const INLINE: usize = 16;
    /// The lengths that a CAN FD frame can have, by DLC.
    pub const FD_LENGTHS: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

    const fn raw(id: CanId, kind: FrameKind, flags: u8, len: u16) -> Self {
        Self { id, kind, flags, len, data: [0; Self::INLINE] }
    }

    /// A classical data frame; `None` if `data` has more than 8 bytes.
    pub fn new(id: CanId, data: &[u8]) -> Option<Self> {
        if data.len() > 8 {
            return None;
        }
        let mut frame = Self::raw(id, FrameKind::Data, 0, data.len() as u16);
        frame.data[..data.len()].copy_from_slice(data);
        Some(frame)
    }

    /// A classical data frame with all 8 bytes: a quick constructor for SDO and binary readers.
    pub const fn full(id: CanId, data: [u8; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = data;
        Self { id, kind: FrameKind::Data, flags: 0, len: 8, data: [a, b, c, d, e, f, g, h, 0, 0, 0, 0, 0, 0, 0, 0] }
    }

    /// A classical data frame of `len` bytes, at most 8; the rest of `data` must be zero.
    #[inline]
    pub(crate) const fn short(id: CanId, data: [u8; 8], len: usize) -> Self {
        let frame = Self::full(id, data);
        Self { len: if len < 8 { len as u16 } else { 8 }, ..frame }
    }

    /// A remote frame that asks for `len` bytes; `None` above 8.
    pub const fn remote(id: CanId, len: u8) -> Option<Self> {
        if len > 8 { None } else { Some(Self::raw(id, FrameKind::Remote, 0, len as u16)) }
    }

    /// An error frame with its class bits and up to 8 bytes of detail; `None` if `data` is longer.
    pub fn error(class: ErrorClass, data: &[u8]) -> Option<Self> {
        let frame = Self::new(CanId::extended_masked(class.0), data)?;
        Some(Self { kind: FrameKind::Error, ..frame })
    }

    /// A complete CAN FD frame, or its head if `data` has more than 16 bytes; `None` if the length is not one of
    /// [`Frame::FD_LENGTHS`].
    pub fn fd(id: CanId, flags: Flags, data: &[u8]) -> Option<Self> {
        Self::FD_LENGTHS.iter().any(|&l| usize::from(l) == data.len()).then(|| {
            let flags = Flags(flags.0 & 3).with(Flags::FDF);
            Self::head(id, flags, data)
        })
    }

    /// The head of a CAN XL frame; `None` if it has no data or more than 2048 bytes.
    pub(crate) fn xl_head(priority: CanId, data: &[u8]) -> Option<Self> {
        (1..=2048).contains(&data.len()).then(|| Self::head(priority, Flags::XLF, data))
    }

    fn head(id: CanId, flags: Flags, data: &[u8]) -> Self {
        let mut frame = Self::raw(id, FrameKind::Data, flags.0, data.len() as u16);
        let held = data.len().min(Self::INLINE);
        frame.data[..held].copy_from_slice(&data[..held]);
        frame
    }

    /// Sets a raw DLC of 9 to 15 (`len8_dlc` of SocketCAN) in a classical frame of 8 bytes; leaves any other frame
    /// unchanged.
    pub fn with_raw_dlc(mut self, dlc: u8) -> Self {
        if self.len == 8 && (9..=15).contains(&dlc) && self.flags & 0x0F == 0 {
            self.flags = dlc << 4;
        }
        self
    }

    /// The identifier; for an error frame its class bits, see [`Frame::error_class`].
    #[inline]
    pub const fn id(&self) -> CanId {
        self.id
    }

    /// The identifier of a classical data frame with 11 bits, the kind that CANopen uses; else `None`.
    #[inline]
    pub const fn cob_id(&self) -> Option<u16> {
        match self.kind {
            FrameKind::Data if self.flags & 0x0F == 0 => self.id.as_standard(),
            _ => None,
        }
    }

    /// The kind: data, remote or error.
    #[inline]
    pub const fn kind(&self) -> FrameKind {
        self.kind
    }

    /// The first 16 bytes of the payload; empty for a remote frame.
    #[inline]
    pub fn data(&self) -> &[u8] {
        match self.kind {
            FrameKind::Remote => &[],
            _ => &self.data[..usize::from(self.len).min(Self::INLINE)],
        }
    }

    /// The payload of a classical frame as eight bytes, filled up with zeros.
    pub const fn bytes(&self) -> [u8; 8] {
        let [a, b, c, d, e, f, g, h, ..] = self.data;
        [a, b, c, d, e, f, g, h]
    }

    /// Length of the payload in bytes; for a remote frame the requested length.
    #[inline]
    pub const fn len(&self) -> usize {
        self.len as usize
    }

    /// Whether there is no payload.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether the payload is longer than the bytes in the frame.
    pub const fn is_head(&self) -> bool {
        self.len as usize > Self::INLINE
    }

    /// The data length code as on the wire; CAN XL has none and returns its length minus one, cut to 8 bits.
    #[inline]
    pub fn dlc(&self) -> u8 {
        if self.flags & 0xF0 != 0 {
            self.flags >> 4
        } else if self.is_fd() {
            let code = Self::FD_LENGTHS.iter().position(|&l| u16::from(l) == self.len);
            debug_assert!(code.is_some(), "CAN FD has no length of {} bytes", self.len);
            code.unwrap_or(15) as u8
        } else if self.is_xl() {
            (self.len - 1) as u8
        } else {
            self.len as u8
        }
    }

    /// The flags of a CAN FD or CAN XL frame.
    pub const fn flags(&self) -> Flags {
        Flags::from_bits(self.flags)
    }

    /// Whether the frame is a CAN FD frame.
    pub const fn is_fd(&self) -> bool {
        self.flags().contains(Flags::FDF)
    }

    /// Whether the frame is a CAN XL frame.
    pub const fn is_xl(&self) -> bool {
        self.flags().contains(Flags::XLF)
    }

    /// Whether the frame is a remote frame.
    pub const fn is_remote(&self) -> bool {
        matches!(self.kind, FrameKind::Remote)
    }

    /// Whether the frame is an error frame.
    pub const fn is_error(&self) -> bool {
        matches!(self.kind, FrameKind::Error)
    }

    /// The number that SocketCAN's tools print in place of the identifier. For an error frame it consists of the class bits
    /// and the bit `CAN_ERR_FLAG`.
    pub const fn printed_id(&self) -> u32 {
        match self.error_class() {
            Some(class) => Self::ERROR_FLAG | class.0,
            None => self.id.raw(),
        }
    }

    /// The class bits of an error frame.
    pub const fn error_class(&self) -> Option<ErrorClass> {
        match self.kind {
            FrameKind::Error => Some(ErrorClass(self.id.raw())),
            _ => None,
        }
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Frame({self})")
    }
}

/// The traits of embedded-can support only classical frames.
impl embedded_can::Frame for Frame {
    fn new(id: impl Into<embedded_can::Id>, data: &[u8]) -> Option<Self> {
        Frame::new(id.into().into(), data)
    }

    fn new_remote(id: impl Into<embedded_can::Id>, dlc: usize) -> Option<Self> {
        Frame::remote(id.into().into(), u8::try_from(dlc).ok()?)
    }

    fn is_extended(&self) -> bool {
        self.id.is_extended()
    }

    fn is_remote_frame(&self) -> bool {
        self.is_remote()
    }

    fn id(&self) -> embedded_can::Id {
        self.id.into()
    }

    fn dlc(&self) -> usize {
        self.len()
    }

    fn data(&self) -> &[u8] {
        Frame::data(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(raw: u32) -> CanId {
        CanId::standard(raw).unwrap()
    }

    #[test]
    fn twenty_four_bytes() {
        assert_eq!(size_of::<Frame>(), 24);
    }

    #[test]
    fn lengths_that_do_not_exist_are_refused() {
        assert!(Frame::new(id(1), &[0; 9]).is_none());
        assert!(Frame::remote(id(1), 9).is_none());
        assert!(Frame::fd(id(1), Flags::NONE, &[0; 9]).is_none());
        assert!(Frame::xl_head(id(1), &[]).is_none());
        assert!(Frame::xl_head(id(1), &[0; 2049]).is_none());
    }

    #[test]
    fn only_classical_data_of_eleven_bits_is_canopen() {
        assert_eq!(Frame::new(id(0x181), &[1]).unwrap().cob_id(), Some(0x181));
        assert_eq!(Frame::remote(id(0x181), 0).unwrap().cob_id(), None);
        assert_eq!(Frame::fd(id(0x181), Flags::NONE, &[1]).unwrap().cob_id(), None);
        assert_eq!(Frame::new(CanId::extended(0x181).unwrap(), &[1]).unwrap().cob_id(), None);
        assert_eq!(Frame::error(ErrorClass(0x181), &[1]).unwrap().cob_id(), None);
    }

    #[test]
    fn shown_as_candump_shows_them() {
        let shown = |frame: Option<Frame>| frame.unwrap().to_string();
        assert_eq!(shown(Frame::new(id(0x63F), &[0x40, 0, 0x60, 0])), "63F#40006000");
        assert_eq!(shown(Frame::remote(id(0x701), 0)), "701#R");
        assert_eq!(shown(Frame::remote(id(0x701), 3)), "701#R3");
        assert_eq!(shown(Frame::fd(id(0x123), Flags::BRS, &[0xAA, 0xBB])), "123##5AABB");
        assert_eq!(shown(Frame::error(ErrorClass(4), &[0, 8])), "20000004#0008");
        assert_eq!(Frame::full(id(1), [0; 8]).with_raw_dlc(0xC).to_string(), "001#0000000000000000_C");
    }

    #[test]
    fn embedded_can_sees_the_same_frame() {
        use embedded_can::Frame as _;
        let frame = <Frame as embedded_can::Frame>::new(embedded_can::StandardId::new(0x77).unwrap(), &[1, 2]).unwrap();
        assert_eq!(frame, Frame::new(id(0x77), &[1, 2]).unwrap());
        assert_eq!(embedded_can::Frame::dlc(&frame), 2);
        assert!(frame.is_standard() && frame.is_data_frame());
    }
}
