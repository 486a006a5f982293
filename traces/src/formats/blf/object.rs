//! Objects with CAN frames.

use crate::damage::Flaw;
use crate::formats::asc::LATEST;
use crate::{CanId, ChannelId, Direction, ErrorClass, Flags, Frame, Record, Timestamp};
use memchr::memmem;
use nom::bytes::complete::{tag, take};
use nom::number::complete::{le_u16, le_u32, le_u64, u8};
use nom::{IResult, Parser};
use std::borrow::Cow;

pub(crate) const SIGNATURE: &[u8] = b"LOBJ";
/// The part of the header that all versions have.
pub(crate) const BASE_HEADER: usize = 16;
/// Limit of the size of a parsed object; a CAN object has less than a tenth of this size.
pub(crate) const LARGEST: usize = 64 * 1024;

pub(super) const CAN_MESSAGE: u32 = 1;
const CAN_ERROR: u32 = 2;
pub(crate) const LOG_CONTAINER: u32 = 10;
pub(super) const CAN_ERROR_EXT: u32 = 73;
const CAN_MESSAGE_2: u32 = 86;
pub(super) const CAN_FD_MESSAGE: u32 = 100;
const CAN_FD_MESSAGE_64: u32 = 101;
const CAN_FD_ERROR_64: u32 = 104;
const DATA_LOST_END: u32 = 126;

pub(super) const EXTENDED: u32 = 0x8000_0000;
/// Flag of CAN and CAN FD messages: the frame was sent.
pub(super) const TX: u8 = 0x01;
pub(super) const REMOTE: u8 = 0x80;
/// CAN FD flag of a CAN FD message: the frame has the CAN FD format.
pub(super) const EDL: u8 = 0x01;
pub(super) const BRS: u8 = 0x02;
pub(super) const ESI: u8 = 0x04;
/// Flag of a CAN FD message 64: the frame is remote.
const REMOTE_64: u32 = 0x0010;
const EDL_64: u32 = 0x1000;
const BRS_64: u32 = 0x2000;
const ESI_64: u32 = 0x4000;
/// The class of an error frame without details: `CAN_ERR_BUSERROR`.
const BUS_ERROR: ErrorClass = ErrorClass(0x80);
/// Length of the fixed part of a CAN FD message 64.
const FD_64_FIXED: usize = 40;

/// The fields that the headers of all versions have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BaseHeader {
    pub(crate) header_size: u16,
    pub(crate) version: u16,
    pub(crate) size: u32,
    pub(crate) kind: u32,
}

pub(crate) fn base_header(i: &[u8]) -> IResult<&[u8], BaseHeader> {
    (tag(SIGNATURE), le_u16, le_u16, le_u32, le_u32)
        .map(|(_, header_size, version, size, kind)| BaseHeader { header_size, version, size, kind })
        .parse(i)
}

/// The type of an index of the objects; the count in the file header does not include it.
pub(crate) const RESTORE_POINTS: u32 = 115;
/// The last type that Vector has assigned.
const LAST_KNOWN: u32 = 137;

/// Whether Vector has assigned this type. An unassigned type may be the damaged type of a frame.
pub(crate) const fn is_known(kind: u32) -> bool {
    matches!(kind, 1..=LAST_KNOWN) && !matches!(kind, 26..=28 | 52 | 53 | 108 | 116 | 117 | 135)
}

/// Size of the largest objects of this type that tools write, header included.
const fn usual_size(kind: u32) -> usize {
    match kind {
        CAN_MESSAGE => 48,
        CAN_MESSAGE_2 | CAN_ERROR | CAN_ERROR_EXT | DATA_LOST_END => 80,
        _ => 160,
    }
}

/// The offset of another object inside an unusually large one; the size of the large one is then damaged.
pub(crate) fn hidden_object(header: BaseHeader, object: &[u8]) -> Option<usize> {
    if object.len() <= usual_size(header.kind) {
        return None;
    }
    memmem::find_iter(object, SIGNATURE).find(|&at| {
        let inner = base_header(object.get(at..).unwrap_or_default());
        at > 0 && inner.is_ok_and(|(_, inner)| is_known(inner.kind) && inner.fits())
    })
}

impl BaseHeader {
    /// Whether the sizes in the header are plausible. All objects but containers have a time stamp in their header.
    pub(crate) fn fits(self) -> bool {
        let least = if self.kind == LOG_CONTAINER { BASE_HEADER } else { 2 * BASE_HEADER };
        let small = !is_read(self.kind) || self.size as usize <= LARGEST;
        usize::from(self.header_size) >= least && self.size >= self.header_size.into() && small
    }
}

/// Whether canvass reads objects of this type.
pub(crate) const fn is_read(kind: u32) -> bool {
    matches!(
        kind,
        CAN_MESSAGE
            | CAN_ERROR
            | CAN_ERROR_EXT
            | CAN_MESSAGE_2
            | CAN_FD_MESSAGE
            | CAN_FD_MESSAGE_64
            | CAN_FD_ERROR_64
            | DATA_LOST_END
    )
}

/// The content of an object.
#[derive(Debug)]
pub(crate) enum Content {
    /// A frame on a channel, numbered from 1; its time is relative to the start of the measurement.
    Frame { record: Record, channel: u16 },
    /// The number of events that the recorder reports as lost.
    Lost(u64),
}

/// Reads a whole object of a type that [is read](is_read).
pub(crate) fn content(header: BaseHeader, object: &[u8]) -> Result<Content, Flaw> {
    let short =
        |_| Flaw::malformed(format!("a whole object of type {}", header.kind), format!("{} bytes", object.len()));
    let extended = object.get(BASE_HEADER..).unwrap_or_default();
    let (_, (flags, _, time)) = time_header(extended).map_err(short)?;
    let unit = if flags == 1 { 10_000 } else { 1 };
    let timestamp = time.checked_mul(unit).map(Timestamp);
    let timestamp = timestamp.ok_or_else(|| Flaw::malformed(LATEST, format!("{time} units of {unit} ns")))?;
    let body = object.get(usize::from(header.header_size)..).unwrap_or_default();
    let (frame, channel, direction) = match header.kind {
        CAN_MESSAGE | CAN_MESSAGE_2 => message(body).map_err(short)?.1?,
        CAN_ERROR => error(body).map_err(short)?.1,
        CAN_ERROR_EXT => error_ext(body).map_err(short)?.1,
        CAN_FD_ERROR_64 => fd_error_64(body).map_err(short)?.1,
        CAN_FD_MESSAGE => fd_message(body).map_err(short)?.1?,
        CAN_FD_MESSAGE_64 => fd_message_64(header, body).map_err(short)?.1?,
        _ => return Ok(Content::Lost(lost(body).map_err(short)?.1)),
    };
    let mut record = frame.record()?;
    (record.timestamp, record.direction) = (timestamp, direction);
    Ok(Content::Frame { record, channel })
}

/// Parses flags (1: tens of microseconds, 2: nanoseconds), four bytes that differ between the versions, time stamp.
fn time_header(i: &[u8]) -> IResult<&[u8], (u32, u32, u64)> {
    (le_u32, le_u32, le_u64).parse(i)
}

/// A frame whose length is not checked yet, with its channel and direction.
type Seen<'a> = (Raw<'a>, u16, Direction);

/// A frame as an object describes it.
enum Raw<'a> {
    Frame(Frame),
    Fd { id: CanId, flags: Flags, data: Cow<'a, [u8]> },
}

impl Raw<'_> {
    fn record(self) -> Result<Record, Flaw> {
        match self {
            Self::Frame(frame) => Ok(Record::new(Timestamp::ZERO, ChannelId::default(), frame)),
            Self::Fd { id, flags, data } => Record::fd(Timestamp::ZERO, ChannelId::default(), id, flags, &data)
                .ok_or_else(|| Flaw::malformed("a length that CAN FD has", data.len().to_string())),
        }
    }
}

const fn can_id(id: u32) -> CanId {
    if id & EXTENDED != 0 { CanId::extended_masked(id) } else { CanId::standard_masked(id) }
}

const fn direction(tx: bool) -> Direction {
    if tx { Direction::Tx } else { Direction::Rx }
}

/// A classical frame. A data length code above 8 means eight bytes.
pub(in crate::formats) fn classical(id: CanId, remote: bool, dlc: u8, data: &[u8]) -> Result<Frame, Flaw> {
    if dlc > 15 {
        return Err(Flaw::malformed("a data length code of at most 15", dlc.to_string()));
    }
    let length = dlc.min(8);
    let frame = if remote {
        Frame::remote(id, length)
    } else {
        data.get(..usize::from(length)).and_then(|data| Frame::new(id, data))
    };
    let frame = frame.ok_or_else(|| Flaw::malformed(format!("{length} bytes of data"), format!("{}", data.len())))?;
    Ok(frame.with_raw_dlc(dlc))
}

/// Parses a CAN message: channel, flags, DLC, identifier, eight bytes.
fn message(i: &[u8]) -> IResult<&[u8], Result<Seen<'_>, Flaw>> {
    (le_u16, u8, u8, le_u32, take(8usize))
        .map(|(channel, flags, dlc, id, data)| {
            let frame = classical(can_id(id), flags & REMOTE != 0, dlc, data)?;
            Ok((Raw::Frame(frame), channel, direction(flags & TX != 0)))
        })
        .parse(i)
}

/// An error frame without details.
pub(in crate::formats) fn bus_error() -> Frame {
    error_frame(BUS_ERROR, &[])
}

/// An error frame; the data is cut to eight bytes.
fn error_frame(class: ErrorClass, data: &[u8]) -> Frame {
    let class_alone = || Frame::full(CanId::extended_masked(class.0), [0; 8]);
    Frame::error(class, &data[..data.len().min(8)]).unwrap_or_else(class_alone)
}

/// Parses an error frame: channel, length of the error frame.
fn error(i: &[u8]) -> IResult<&[u8], Seen<'_>> {
    (le_u16, le_u16).map(|(channel, _)| (Raw::Frame(bus_error()), channel, Direction::Unknown)).parse(i)
}

/// Parses an extended error frame: channel, length, flags, ECC, position, DLC, reserved, frame length, identifier,
/// flags, reserved, data.
///
/// If the flags say that a controller reported the error, identifier and data are those of the broken frame. python-can
/// writes no flags, but Linux's class bits as identifier, and detail bytes.
fn error_ext(i: &[u8]) -> IResult<&[u8], Seen<'_>> {
    let (i, (channel, _, flags, _, _, dlc, _, _, id, _, _)) =
        (le_u16, le_u16, le_u32, u8, u8, u8, u8, le_u32, le_u32, le_u16, le_u16).parse(i)?;
    let (i, data) = take(8usize).parse(i)?;
    let class = id & CanId::MAX_EXTENDED;
    let frame = if flags == 0 && class != 0 {
        error_frame(ErrorClass(class), &data[..usize::from(dlc).min(8)])
    } else {
        bus_error()
    };
    Ok((i, (Raw::Frame(frame), channel, Direction::Unknown)))
}

/// Parses a CAN FD error frame: the channel; the rest describes the broken frame.
fn fd_error_64(i: &[u8]) -> IResult<&[u8], Seen<'_>> {
    u8.map(|channel| (Raw::Frame(bus_error()), u16::from(channel), Direction::Unknown)).parse(i)
}

/// Parses a CAN FD message: channel, flags, DLC, identifier, frame length, bit count, CAN FD flags, valid bytes,
/// reserved (40), 64 bytes.
fn fd_message(i: &[u8]) -> IResult<&[u8], Result<Seen<'_>, Flaw>> {
    let (i, (channel, flags, dlc, id, _, _, fd_flags, valid)) =
        (le_u16, u8, u8, le_u32, le_u32, u8, u8, u8).parse(i)?;
    let (i, (_, data)) = (take(5usize), take(64usize)).parse(i)?;
    let direction = direction(flags & TX != 0);
    if fd_flags & EDL == 0 {
        let frame = classical(can_id(id), flags & REMOTE != 0, dlc, data);
        return Ok((i, frame.map(|frame| (Raw::Frame(frame), channel, direction))));
    }
    let flags = fd(fd_flags & BRS != 0, fd_flags & ESI != 0);
    Ok((i, fd_data(data, valid).map(|data| (Raw::Fd { id: can_id(id), flags, data }, channel, direction))))
}

/// The flags of a CAN FD frame.
pub(in crate::formats) fn fd(brs: bool, esi: bool) -> Flags {
    let brs = if brs { Flags::BRS } else { Flags::NONE };
    if esi { brs.with(Flags::ESI) } else { brs }
}

/// The valid bytes, filled up with zeros: the writers of this format may leave out trailing zeros.
fn fd_data(stored: &[u8], valid: u8) -> Result<Cow<'_, [u8]>, Flaw> {
    if valid > 64 {
        return Err(Flaw::malformed("at most 64 bytes of data", valid.to_string()));
    }
    let valid = usize::from(valid);
    Ok(stored.get(..valid).map_or_else(
        || {
            let mut filled = stored.to_vec();
            filled.resize(valid, 0);
            Cow::Owned(filled)
        },
        Cow::Borrowed,
    ))
}

/// Parses a CAN FD message 64: channel, DLC, valid bytes, transmissions, identifier, frame length, flags, two bit
/// rates, two times (32 bits each), bit count (16), direction, offset of extended data or 0, CRC (32), data.
fn fd_message_64(header: BaseHeader, body: &[u8]) -> IResult<&[u8], Result<Seen<'_>, Flaw>> {
    let (i, (channel, dlc, valid, _, id, _, flags)) = (u8, u8, u8, u8, le_u32, le_u32, le_u32).parse(body)?;
    let (i, (_, way, extended_at, _)) = (take(18usize), u8, u8, le_u32).parse(i)?;
    // The offset counts from the beginning of the object.
    let end = match usize::from(extended_at) {
        0 => i.len(),
        at => at.saturating_sub(usize::from(header.header_size) + FD_64_FIXED).min(i.len()),
    };
    let data = i.get(..end).unwrap_or_default();
    let (channel, direction) = (u16::from(channel), direction(way != 0));
    if flags & EDL_64 == 0 {
        let stored = fd_data(data, valid.min(8));
        let frame = stored.and_then(|data| classical(can_id(id), flags & REMOTE_64 != 0, dlc, &data));
        return Ok((&[], frame.map(|frame| (Raw::Frame(frame), channel, direction))));
    }
    let flags = fd(flags & BRS_64 != 0, flags & ESI_64 != 0);
    Ok((&[], fd_data(data, valid).map(|data| (Raw::Fd { id: can_id(id), flags, data }, channel, direction))))
}

/// Parses lost events: queue, time of the first lost event, number of lost events.
fn lost(i: &[u8]) -> IResult<&[u8], u64> {
    (le_u32, le_u64, le_u32).map(|(_, _, number)| u64::from(number)).parse(i)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An object with its header (version 1, nanoseconds).
    fn object(kind: u32, body: &[u8]) -> Vec<u8> {
        let size = (32 + body.len()) as u32;
        let mut object = b"LOBJ\x20\0\x01\0".to_vec();
        object.extend(size.to_le_bytes());
        object.extend(kind.to_le_bytes());
        object.extend([2, 0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0]);
        object.extend(body);
        object
    }

    fn shown(kind: u32, body: &[u8]) -> String {
        let object = object(kind, body);
        let (_, header) = base_header(&object).unwrap();
        match content(header, &object) {
            Ok(Content::Frame { record, channel }) => {
                let (time, direction) = (record.timestamp.nanos(), record.direction);
                let data = record.data().len();
                format!("{time} {channel} {} {direction} {data}", record.frame)
            }
            Ok(Content::Lost(n)) => format!("lost {n}"),
            Err(flaw) => flaw.damage(crate::Place::default()).to_string(),
        }
    }

    #[test]
    fn can_messages() {
        assert_eq!(shown(1, b"\x01\0\0\x02\x3F\x06\0\0\x40\0\xEE\xEE\xEE\xEE\xEE\xEE"), "7 1 63F#4000 Rx 2");
        assert_eq!(shown(86, b"\x02\0\x81\x03\x01\x07\0\x80\0\0\0\0\0\0\0\0xxxxxxxx"), "7 2 00000701#R3 Tx 0");
        assert_eq!(shown(1, b"\x01\0\0\x0C\x01\0\0\0\0\0\0\0\0\0\0\0"), "7 1 001#0000000000000000_C Rx 8");
        assert!(shown(1, b"\x01\0\0\x10\x01\0\0\0\0\0\0\0\0\0\0\0").contains("found \"16\""));
        assert!(shown(1, b"\x01\0\0\x08\x01\0\0\0\0").starts_with("malformed: expected a whole object"));
    }

    #[test]
    fn error_frames() {
        assert_eq!(shown(2, b"\x01\0\x06\0"), "7 1 20000080#  0");
        let mut body = [0; 32];
        (body[0], body[10], body[16], body[25]) = (1, 2, 4, 8);
        assert_eq!(shown(73, &body), "7 1 20000004#0008  2", "as python-can writes Linux's classes");
        body[4] = 1;
        assert_eq!(shown(73, &body), "7 1 20000080#  0", "the controller's report: the identifier is no class");
    }

    #[test]
    fn can_fd_message_64() {
        let fixed = |flags: u16, dlc: u8, valid: u8, extended_at: u8| {
            let mut body = vec![3, dlc, valid, 0, 0x23, 1, 0, 0, 0, 0, 0, 0];
            body.extend(u32::from(flags).to_le_bytes());
            body.extend([0; 18]);
            body.extend([1, extended_at, 0, 0, 0, 0]);
            body
        };
        let with = |mut body: Vec<u8>, data: &[u8]| {
            body.extend(data);
            body
        };
        assert_eq!(
            shown(101, &with(fixed(0x3000, 9, 12, 0), b"0123456789ab")),
            "7 3 123##5303132333435363738396162 Tx 12"
        );
        assert_eq!(shown(101, &with(fixed(0, 2, 2, 0), b"01")), "7 3 123#3031 Tx 2", "a classical frame");
        assert_eq!(shown(101, &with(fixed(0x10, 2, 0, 0), b"")), "7 3 123#R2 Tx 0");
        assert_eq!(shown(101, &with(fixed(0x5000, 8, 8, 76), b"0123extended")), "7 3 123##63031323300000000 Tx 8");
        assert!(shown(101, &with(fixed(0x1000, 9, 13, 0), &[0; 13])).contains("a length that CAN FD has"));
        assert!(shown(101, &with(fixed(0x1000, 9, 65, 0), &[0; 65])).contains("at most 64"));
    }

    #[test]
    fn events_that_the_recorder_lost() {
        assert_eq!(shown(126, b"\0\0\0\0\0\0\0\0\0\0\0\0\x2A\0\0\0"), "lost 42");
    }
}
