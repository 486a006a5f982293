//! The meaning of whole values: names of values, and values that a standard composes of several fields.

use super::profile::{known_profile, logical_device};
use crate::identity::{CobId, Multiplexer};
use crate::object;
use crate::wire::pdo::{MappingEntry, Moment, TransmissionType};
use std::fmt;

/// The meaning of a whole value. Displays as text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meaning {
    /// The name of a single value.
    Name(&'static str),
    /// 1000h: the profile and, if the profile names it, the kind of the device (CiA 301, 7.5.2.1).
    DeviceType(u16, Option<&'static str>),
    /// A COB-ID parameter, with the meaning of its bits 31 and 30 (CiA 301, 7.5.2).
    CobId(CobId, [Option<&'static str>; 2]),
    /// The node-ID and the heartbeat time in ms of a consumer (CiA 301, 7.5.2.19).
    HeartbeatConsumer(u8, u16),
    /// The moment at which a TPDO is sent (CiA 301, 7.5.2.37).
    Sent(Moment),
    /// A mapping entry of a PDO or SRDO.
    Mapped(MappingEntry),
    /// The version of the profile and the version of the software: two digits before and two after the point.
    Versions(u16, u16),
}

/// The meaning of an object's value, such as the state that it names; `None` if the value is a quantity or a code without
/// a name.
pub fn meaning(at: Multiplexer, value: i64, profile: Option<u16>) -> Option<Meaning> {
    match at.index.0 {
        0x6000..=0x9FFF => {
            let device = logical_device(at.index, profile?)?;
            device.profile.meaning(Multiplexer { index: device.object, ..at }, value)
        }
        0x1000..=0x1FFF => of_communication(at, u32::try_from(value).ok()?),
        _ => None,
    }
}

/// The meaning of a value in the communication profile (CiA 301, 7.5.2).
fn of_communication(at: Multiplexer, value: u32) -> Option<Meaning> {
    Some(match (at.index.0, at.sub.0) {
        (object::DEVICE_TYPE, 0) => {
            let profile = value as u16;
            Meaning::DeviceType(profile, known_profile(profile)?.device_kind((value >> 16) as u16))
        }
        (object::CONSUMER_HEARTBEAT_TIME, 1..) => match ((value >> 16) as u8, value as u16) {
            (0, _) | (_, 0) => Meaning::Name("unused"),
            (node, time) => Meaning::HeartbeatConsumer(node, time),
        },
        (object::ERROR_BEHAVIOR, 1..) => Meaning::Name(match value {
            0 => "pre-operational",
            1 => "no change of state",
            2 => "stopped",
            _ => return None,
        }),
        (index, 2) if object::is_tpdo_communication(index) => {
            Meaning::Sent(TransmissionType(u8::try_from(value).ok()?).moment())
        }
        (index, 2) if object::is_rpdo_communication(index) => Meaning::Name(match value {
            0..=240 => "acts at the next SYNC",
            254 => "manufacturer-specific event",
            255 => "event of the device profile",
            _ => "reserved",
        }),
        (index, 1..) if object::is_pdo_mapping(index) || matches!(index, 0x1381..=0x13C0) => match value {
            0 => return None,
            _ => Meaning::Mapped(MappingEntry(value)),
        },
        _ => Meaning::CobId(CobId(value), control_bits(at, CobId(value))?),
    })
}

/// The meaning of bits 31 and 30 of a COB-ID parameter; `None` for other objects.
const fn control_bits(at: Multiplexer, cob_id: CobId) -> Option<[Option<&'static str>; 2]> {
    let valid = Some(if cob_id.is_valid() { "valid" } else { "not valid" });
    let rtr = Some(if cob_id.allows_rtr() { "RTR allowed" } else { "no RTR" });
    // In 1005h and 1012h bit 31 does not make the message invalid.
    let (consumes, produces) = (!cob_id.is_valid(), !cob_id.allows_rtr());
    Some(match (at.index.0, at.sub.0) {
        (object::COB_ID_SYNC, 0) => [None, if produces { Some("generates SYNC") } else { None }],
        (object::COB_ID_TIME, 0) => {
            [if consumes { Some("consumes TIME") } else { None }, if produces { Some("produces TIME") } else { None }]
        }
        (object::COB_ID_EMCY, 0) | (object::EMERGENCY_CONSUMER, 1..) | (0x1200..=0x12FF, 1 | 2) => [valid, None],
        (index, 1) if object::is_tpdo_communication(index) => [valid, rtr],
        (index, 1) if object::is_rpdo_communication(index) => [valid, None],
        _ => return None,
    })
}

impl fmt::Display for Meaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Name(name) => f.write_str(name),
            Self::DeviceType(profile, None) => write!(f, "profile {profile}"),
            Self::DeviceType(profile, Some(kind)) => write!(f, "profile {profile}, {kind}"),
            Self::CobId(cob_id, bits) => {
                let digits = if cob_id.is_extended() { 8 } else { 3 };
                write!(f, "CAN-ID {:0digits$X}h", cob_id.can_id())?;
                bits.into_iter().flatten().try_for_each(|bit| write!(f, ", {bit}"))
            }
            Self::HeartbeatConsumer(node, time) => write!(f, "node {node}, {time} ms"),
            Self::Sent(moment) => moment.fmt(f),
            Self::Mapped(entry) => entry.fmt(f),
            Self::Versions(profile, software) => {
                let [[major, minor], [whole, part]] = [profile.to_be_bytes(), software.to_be_bytes()];
                write!(f, "profile {major:X}.{minor:X}, software {whole:X}.{part:02X}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(index: u16, sub: u8, value: i64) -> String {
        meaning(Multiplexer::new(index, sub), value, Some(406)).map(|meaning| meaning.to_string()).unwrap_or_default()
    }

    /// The COB-IDs, types and mappings that the manuals of the encoders print.
    #[test]
    fn communication_parameters_are_composed() {
        assert_eq!(text(0x1800, 1, 0x4000_0180), "CAN-ID 180h, valid, no RTR");
        assert_eq!(text(0x1800, 1, 0x0000_040B), "CAN-ID 40Bh, valid, RTR allowed");
        assert_eq!(text(0x1801, 1, 0x8000_0281), "CAN-ID 281h, not valid, RTR allowed");
        assert_eq!(text(0x1400, 1, 0x8000_0000), "CAN-ID 000h, not valid");
        assert_eq!(text(0x1005, 0, 0x4000_0080), "CAN-ID 080h, generates SYNC");
        assert_eq!(text(0x1005, 0, 0x8000_0080), "CAN-ID 080h");
        assert_eq!(text(0x1012, 0, 0xC000_0100), "CAN-ID 100h, consumes TIME, produces TIME");
        assert_eq!(text(0x1014, 0, 0xBF), "CAN-ID 0BFh, valid");
        assert_eq!(
            [0, 1, 10, 252, 253].map(|kind| text(0x1800, 2, kind)),
            [
                "at the SYNC after an event",
                "at every SYNC",
                "at every 10th SYNC",
                "sampled at SYNC, sent on RTR",
                "sent on RTR",
            ]
        );
        assert_eq!(text(0x1A00, 1, 0x6004_0020), "6004h:00, 32 bits");
        assert_eq!(text(0x1A00, 1, 0), "");
        assert_eq!(text(0x1016, 1, 0x0005_03E8), "node 5, 1000 ms");
        assert_eq!((text(0x1016, 1, 0), text(0x1016, 0, 2)), ("unused".to_owned(), String::new()));
        assert_eq!(
            [0, 1, 2, 3].map(|value| text(0x1029, 2, value)),
            ["pre-operational", "no change of state", "stopped", ""]
        );
    }

    #[test]
    fn values_without_a_meaning_have_none() {
        assert_eq!([text(0x1017, 0, 1000), text(0x1029, 0, 1), text(0x2000, 0, 1), text(0x1000, 0, 0x1234)], [""; 4]);
        assert_eq!(meaning(Multiplexer::new(0x6004, 0), 1, None), None);
    }
}
