//! CAN frames in messages of any schema, recognised by the names of their fields.

use crate::damage::Flaw;
use crate::{CanId, ChannelId, ErrorClass, Flags, Frame, Record, Timestamp};
use std::borrow::Cow;

/// The meaning of a message's field.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Role {
    Id,
    /// A data length code, which most messages use for the length in bytes.
    Dlc,
    Length,
    Data,
    Extended,
    Remote,
    Error,
    Fd,
    Brs,
    Esi,
    Seconds,
    Nanoseconds,
}

impl Role {
    /// The role by the field's name, in any case and with or without underscores.
    pub(crate) fn by_name(name: &str) -> Option<Self> {
        let name: String = name.chars().filter(|&c| c != '_').map(|c| c.to_ascii_lowercase()).collect();
        Some(match name.as_str() {
            "id" | "canid" | "arbitrationid" | "identifier" | "frameid" | "msgid" | "messageid" | "cobid" => Self::Id,
            "dlc" | "candlc" => Self::Dlc,
            "len" | "length" | "datalen" | "datalength" | "size" | "datasize" | "payloadlength" => Self::Length,
            "data" | "payload" | "candata" | "databytes" => Self::Data,
            "isextended" | "extended" | "isextendedid" | "extendedid" | "iseff" | "eff" | "ide" | "isext" | "ext"
            | "isextendedframe" | "extendedframe" => Self::Extended,
            "isrtr" | "rtr" | "isremote" | "remote" | "isremoteframe" | "remoteframe" => Self::Remote,
            "iserror" | "err" | "error" | "iserrorframe" | "errorframe" | "iserr" => Self::Error,
            "isfd" | "fd" | "fdf" | "iscanfd" | "canfd" | "edl" => Self::Fd,
            "brs" | "isbrs" | "bitrateswitch" => Self::Brs,
            "esi" | "isesi" | "errorstateindicator" => Self::Esi,
            _ => return None,
        })
    }

    /// Whether a field with this name is a point in time.
    pub(crate) fn is_time(name: &str) -> bool {
        matches!(name.to_ascii_lowercase().as_str(), "stamp" | "timestamp" | "time")
    }

    /// The part of a point in time that a field with this name holds; `None` if it holds none.
    pub(crate) fn of_time(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "sec" | "secs" | "seconds" => Some(Self::Seconds),
            "nsec" | "nsecs" | "nanosec" | "nanosecs" | "nanos" | "nanoseconds" => Some(Self::Nanoseconds),
            _ => None,
        }
    }
}

/// The frame format that a schema implies, apart from the positions of the fields.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    /// Whether the message's name says CAN FD.
    pub(crate) named_fd: bool,
    /// Maximum number of bytes in the data field, if it is bounded.
    pub(crate) capacity: Option<usize>,
    /// Whether there is a field for the length.
    pub(crate) has_length: bool,
}

impl Shape {
    /// Whether a message with fields for an identifier and data is a CAN frame. A length field, the size of the data,
    /// or the name of the message proves it.
    pub(crate) fn is_can(&self, name: &str) -> bool {
        self.has_length || matches!(self.capacity, Some(8 | 64)) || name.to_ascii_lowercase().contains("can")
    }

    pub(crate) fn is_named_fd(name: &str) -> bool {
        name.to_ascii_lowercase().contains("fd")
    }
}

/// The values of a message's fields.
#[derive(Clone, Debug, Default)]
pub(crate) struct Values<'a> {
    pub(crate) id: u64,
    pub(crate) dlc: Option<u64>,
    pub(crate) length: Option<u64>,
    pub(crate) data: Cow<'a, [u8]>,
    pub(crate) extended: Option<bool>,
    pub(crate) remote: Option<bool>,
    pub(crate) error: Option<bool>,
    pub(crate) fd: Option<bool>,
    pub(crate) brs: bool,
    pub(crate) esi: bool,
    pub(crate) seconds: i64,
    pub(crate) nanoseconds: i64,
}

const EXTENDED: u64 = 0x8000_0000;
const REMOTE: u64 = 0x4000_0000;
const ERROR: u64 = 0x2000_0000;

impl Values<'_> {
    /// Sets a value that is a number; for a truth value, `false` is 0.
    #[inline]
    pub(crate) fn set(&mut self, role: Role, value: i64) {
        match role {
            Role::Id => self.id = value as u64,
            Role::Dlc => self.dlc = Some(value as u64),
            Role::Length => self.length = Some(value as u64),
            Role::Extended => self.extended = Some(value != 0),
            Role::Remote => self.remote = Some(value != 0),
            Role::Error => self.error = Some(value != 0),
            Role::Fd => self.fd = Some(value != 0),
            Role::Brs => self.brs = value != 0,
            Role::Esi => self.esi = value != 0,
            Role::Seconds => self.seconds = value,
            Role::Nanoseconds => self.nanoseconds = value,
            Role::Data => {}
        }
    }

    /// The message's own time stamp, if it is set and plausible.
    fn stamp(&self) -> Option<Timestamp> {
        let seconds = u64::try_from(self.seconds).ok()?;
        let nanoseconds = u64::try_from(self.nanoseconds).ok().filter(|&n| n < 1_000_000_000)?;
        let stamp = seconds.checked_mul(1_000_000_000)?.checked_add(nanoseconds)?;
        (stamp > 0).then_some(Timestamp(stamp))
    }

    /// The frame of the message; its time is the message's own time stamp, else `logged`.
    #[inline]
    pub(crate) fn record(&self, shape: &Shape, logged: Timestamp) -> Result<Record, Flaw> {
        let timestamp = self.stamp().unwrap_or(logged);
        let number = (self.id & u64::from(CanId::MAX_EXTENDED)) as u32;
        if self.error.unwrap_or(self.id & ERROR != 0) {
            let frame = Frame::error(ErrorClass(number), self.payload(self.classical_length()?)?);
            return frame.map(|frame| Record::new(timestamp, ChannelId::default(), frame)).ok_or_else(|| too_long(9));
        }
        let extended = self.extended.unwrap_or(self.id & EXTENDED != 0 || number > CanId::MAX_STANDARD);
        let id = if extended { CanId::extended_masked(number) } else { CanId::standard_masked(number) };
        if self.is_fd(shape) {
            return self.fd_record(id, timestamp);
        }
        let length = self.classical_length()?;
        let frame = if self.remote.unwrap_or(self.id & REMOTE != 0) {
            Frame::remote(id, length as u8)
        } else {
            Frame::new(id, self.payload(length)?)
        };
        frame.map(|frame| Record::new(timestamp, ChannelId::default(), frame)).ok_or_else(|| too_long(length as u64))
    }

    fn is_fd(&self, shape: &Shape) -> bool {
        match self.fd {
            Some(fd) => fd,
            None => shape.named_fd || (self.stated_length() > 8 && shape.capacity.is_none_or(|capacity| capacity > 8)),
        }
    }

    fn stated_length(&self) -> u64 {
        self.length.or(self.dlc).unwrap_or(self.data.len() as u64)
    }

    fn classical_length(&self) -> Result<usize, Flaw> {
        match self.stated_length() {
            length @ 0..=8 => Ok(length as usize),
            length => Err(too_long(length)),
        }
    }

    /// The payload. Bytes beyond `length` are remains of earlier frames.
    fn payload(&self, length: usize) -> Result<&[u8], Flaw> {
        self.data
            .get(..length)
            .ok_or_else(|| Flaw::malformed(format!("data of {length} bytes"), format!("{} bytes", self.data.len())))
    }

    fn fd_record(&self, id: CanId, timestamp: Timestamp) -> Result<Record, Flaw> {
        let length = self.fd_length()?;
        let brs = if self.brs { Flags::BRS } else { Flags::NONE };
        let flags = if self.esi { brs.with(Flags::ESI) } else { brs };
        Record::fd(timestamp, ChannelId::default(), id, flags, self.payload(length)?)
            .ok_or_else(|| Flaw::malformed("a length that CAN FD has", length.to_string()))
    }

    /// The length of a CAN FD frame. A field `dlc` above 8 may be a code or a length: the size of the data decides,
    /// else the field's name.
    fn fd_length(&self) -> Result<usize, Flaw> {
        let stated = self.stated_length();
        if stated > 64 {
            return Err(Flaw::malformed("a length of at most 64", stated.to_string()));
        }
        let stated = stated as usize;
        if self.length.is_some() || self.dlc.is_none() || self.data.len() == stated {
            return Ok(stated);
        }
        Ok(Frame::FD_LENGTHS.get(stated).map_or(stated, |&length| usize::from(length)))
    }
}

fn too_long(length: u64) -> Flaw {
    Flaw::malformed("a length of at most 8", length.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(values: &Values<'_>, shape: &Shape) -> String {
        match values.record(shape, Timestamp(7)) {
            Ok(record) => format!("{} {}", record.timestamp.nanos(), record.frame),
            Err(flaw) => flaw.damage(crate::Place::default()).to_string(),
        }
    }

    fn values(id: u64, dlc: u64, data: &[u8]) -> Values<'_> {
        Values { id, dlc: Some(dlc), data: data.into(), ..Values::default() }
    }

    #[test]
    fn stale_bytes_are_cut_and_identifiers_masked() {
        let shape = Shape { capacity: Some(8), ..Shape::default() };
        assert_eq!(shown(&values(0x63F, 2, &[1, 2, 3, 4, 5, 6, 7, 8]), &shape), "7 63F#0102");
        let standard = Values { extended: Some(false), ..values(0xFFFF_F801, 0, &[0; 8]) };
        assert!(shown(&Values { remote: Some(false), error: Some(false), ..standard }, &shape).ends_with(" 001#"));
        assert_eq!(shown(&values(0x8000_0181, 1, &[9; 8]), &shape), "7 00000181#09", "flags in the identifier");
        assert_eq!(shown(&values(0x800, 0, &[]), &shape), "7 00000800#", "too large for eleven bits");
        assert_eq!(shown(&Values { remote: Some(true), ..values(0x701, 3, &[0; 8]) }, &shape), "7 701#R3");
        assert_eq!(shown(&Values { error: Some(true), ..values(4, 2, &[0, 8, 9]) }, &shape), "7 20000004#0008");
        assert!(shown(&values(1, 9, &[0; 8]), &shape).contains("found \"9\""));
        assert!(shown(&values(1, 8, &[0; 7]), &shape).contains("expected data of 8 bytes"));
    }

    #[test]
    fn time_is_the_stamp_where_it_is_set() {
        let stamped = Values { seconds: 2, nanoseconds: 5, ..values(1, 0, &[]) };
        assert_eq!(shown(&stamped, &Shape::default()), "2000000005 001#");
        assert_eq!(shown(&Values { seconds: -1, ..stamped.clone() }, &Shape::default()), "7 001#");
        assert_eq!(shown(&Values { nanoseconds: 1_000_000_000, ..stamped }, &Shape::default()), "7 001#");
    }

    #[test]
    fn codes_and_lengths_of_can_fd() {
        let shape = Shape { named_fd: true, capacity: Some(64), has_length: true };
        let length = |values: Values<'_>| values.record(&shape, Timestamp(0)).map(|record| record.frame.len()).ok();
        assert_eq!(length(values(1, 9, &[0; 64])), Some(12), "a code: the array says nothing");
        assert_eq!(length(values(1, 12, &[0; 12])), Some(12), "the data has just this length");
        assert_eq!(length(values(1, 12, &[0; 24])), Some(24), "the data has the length of this code");
        assert_eq!(length(Values { dlc: None, length: Some(12), ..values(1, 0, &[0; 64]) }), Some(12));
        assert_eq!(length(Values { dlc: None, length: Some(13), ..values(1, 0, &[0; 64]) }), None);
        assert_eq!(length(values(1, 65, &[0; 64])), None);
    }
}
