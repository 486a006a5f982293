//! A frame with its time, channel, direction and place in the source.

use crate::{CanId, ChannelId, Flags, Frame, Timestamp};
use std::fmt;

/// One frame of a capture.
#[derive(PartialEq, Eq, Debug)]
pub struct Record {
    /// The time of the frame (its end on the bus, as most interfaces stamp it).
    pub timestamp: Timestamp,
    /// The frame, or the head of a long one: [`Record::data`] has all of its payload.
    pub frame: Frame,
    /// The channel of the frame.
    pub channel: ChannelId,
    /// Whether the recorder sent or received the frame, if known.
    pub direction: Direction,
    /// The place of the frame in its source.
    pub place: Place,
    /// The rare properties of the record, boxed because few frames have any.
    beside: Option<Box<Beside>>,
}

/// Properties that few records have.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
struct Beside {
    long: Option<Long>,
    comment: Option<String>,
}

/// Whether the recording machine sent or received a frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Direction {
    /// The source does not say.
    #[default]
    Unknown,
    /// The recording machine received the frame.
    Rx,
    /// The recording machine sent the frame.
    Tx,
}

/// A place in a source, as a person would look it up in the file.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Place {
    /// The line of a text file, or the packet, block or message of a binary file, from 1. 0 marks a live frame, which
    /// has no place in a file.
    pub number: u64,
    /// The offset of that line or packet in the (uncompressed) source, in bytes.
    pub offset: u64,
}

/// The parts of a long frame that a [`Frame`] can't hold: the payload of a long CAN FD or a CAN XL frame.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Long {
    /// The whole payload.
    pub data: Vec<u8>,
    /// The header fields of CAN XL.
    pub xl: Option<XlHeader>,
}

/// The header of a CAN XL frame, besides its priority identifier (CiA 610-1).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct XlHeader {
    /// Virtual CAN network.
    pub vcid: u8,
    /// Simple extended content.
    pub sec: bool,
    /// Remote request substitution.
    pub rrs: bool,
    /// Type of the payload.
    pub sdt: u8,
    /// Acceptance field.
    pub af: u32,
}

impl Beside {
    fn long(long: Long) -> Box<Self> {
        Box::new(Self { long: Some(long), comment: None })
    }
}

impl Clone for Record {
    #[inline]
    fn clone(&self) -> Self {
        let Self { timestamp, frame, channel, direction, place, ref beside } = *self;
        Self { timestamp, frame, channel, direction, place, beside: beside.clone() }
    }

    /// Neither frees nor allocates memory, unless a frame is long or has a comment, which is rare.
    #[inline]
    fn clone_from(&mut self, other: &Self) {
        (self.timestamp, self.frame, self.channel) = (other.timestamp, other.frame, other.channel);
        (self.direction, self.place) = (other.direction, other.place);
        if self.beside.is_some() || other.beside.is_some() {
            self.beside.clone_from(&other.beside);
        }
    }
}

impl Record {
    /// A record of a frame that holds its whole payload.
    pub fn new(timestamp: Timestamp, channel: ChannelId, frame: Frame) -> Self {
        Self { timestamp, frame, channel, direction: Direction::Unknown, place: Place::default(), beside: None }
    }

    /// Moves the record to another channel.
    #[inline]
    pub(crate) fn on(self, channel: ChannelId) -> Self {
        Self { channel, ..self }
    }

    /// A record of a CAN FD frame of up to 64 bytes; `None` if CAN FD has no such length.
    pub fn fd(timestamp: Timestamp, channel: ChannelId, id: CanId, flags: Flags, data: &[u8]) -> Option<Self> {
        let frame = Frame::fd(id, flags, data)?;
        let beside = frame.is_head().then(|| Beside::long(Long { data: data.to_vec(), xl: None }));
        Some(Self { beside, ..Self::new(timestamp, channel, frame) })
    }

    /// A record of a CAN XL frame; `None` if it has no data or more than 2048 bytes, or the priority has 29 bits.
    pub fn xl(timestamp: Timestamp, channel: ChannelId, priority: CanId, xl: XlHeader, data: &[u8]) -> Option<Self> {
        priority.as_standard()?;
        let frame = Frame::xl_head(priority, data)?;
        let beside = Some(Beside::long(Long { data: data.to_vec(), xl: Some(xl) }));
        Some(Self { beside, ..Self::new(timestamp, channel, frame) })
    }

    /// Sets the direction.
    pub fn with_direction(mut self, direction: Direction) -> Self {
        self.direction = direction;
        self
    }

    /// Sets the place in the source.
    pub fn at(mut self, number: u64, offset: u64) -> Self {
        self.place = Place { number, offset };
        self
    }

    /// Sets time, channel and direction.
    #[inline]
    pub(crate) fn seen(self, timestamp: Timestamp, channel: ChannelId, direction: Direction, place: Place) -> Self {
        Self { timestamp, channel, direction, place, ..self }
    }

    /// The whole payload. Empty for a remote frame.
    pub fn data(&self) -> &[u8] {
        match self.long() {
            Some(long) => &long.data,
            None => self.frame.data(),
        }
    }

    /// The header of a CAN XL frame.
    pub fn xl_header(&self) -> Option<XlHeader> {
        self.long().and_then(|long| long.xl)
    }

    #[inline]
    fn long(&self) -> Option<&Long> {
        self.beside.as_ref().and_then(|beside| beside.long.as_ref())
    }

    /// The comment in the capture before this frame, in one or several lines. A comment marks, for example, the
    /// beginning of a test case.
    #[inline]
    pub fn comment(&self) -> Option<&str> {
        self.beside.as_ref().and_then(|beside| beside.comment.as_deref())
    }

    /// Adds a comment, cut to [`Record::LONGEST_COMMENT`].
    pub fn with_comment(mut self, comment: &str) -> Self {
        let comment = &comment[..comment.floor_char_boundary(Self::LONGEST_COMMENT)];
        self.beside.get_or_insert_default().comment = Some(comment.to_owned());
        self
    }

    /// Maximum length of a comment in bytes; longer comments are cut.
    pub const LONGEST_COMMENT: usize = 4096;
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "",
            Self::Rx => "Rx",
            Self::Tx => "Tx",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_payloads_are_kept_whole() {
        let id = CanId::standard(1).unwrap();
        let data: Vec<u8> = (0..64).collect();
        let record = Record::fd(Timestamp(1), ChannelId(0), id, Flags::BRS, &data).unwrap();
        assert_eq!(record.data(), data);
        assert_eq!(record.frame.len(), 64);
        assert_eq!(record.frame.data(), &data[..16]);
        assert_eq!(record.frame.dlc(), 15);

        let xl = XlHeader { vcid: 0x45, sdt: 3, af: 0x1234_5678, ..XlHeader::default() };
        let record = Record::xl(Timestamp(1), ChannelId(0), id, xl, &data[..5]).unwrap();
        assert_eq!((record.data(), record.xl_header()), (&data[..5], Some(xl)));
    }

    #[test]
    fn a_copy_in_its_place_is_equal() {
        let id = CanId::standard(1).unwrap();
        let short =
            Record::new(Timestamp(7), ChannelId(3), Frame::full(id, [1; 8])).at(4, 5).with_direction(Direction::Tx);
        let long = Record::fd(Timestamp(1), ChannelId(0), id, Flags::BRS, &[9; 64]).unwrap();
        let mut copy = short.clone();
        for record in [&long, &short, &short, &long, &long] {
            copy.clone_from(record);
            assert_eq!(&copy, record);
        }
        assert_eq!(long.clone(), long);
    }

    #[test]
    fn one_cache_line() {
        assert!(size_of::<Record>() <= 64);
    }
}
