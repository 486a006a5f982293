//! Flying master: masters negotiate which of them is active (CiA 302-2; CAN-IDs 071h to 076h).
//!
//! ```text
//! 071h  identity of the active master          byte 0: priority    byte 1: node-ID
//! 072h  a master asks all for a negotiation   no data
//! 073h  asks for the active master            no data; answered on 071h
//! 074h  a master answers a master detection   no data
//! 075h  asks for devices that can be master   no data; answered on 074h
//! 076h  forces a new negotiation              no data
//! ```

use super::{Malformed, data_frame, named};
use canvass_traces::{CanId, Frame};
use nom::{Parser, number::complete::u8};
use std::fmt;

/// A message of the negotiation. The CAN-ID tells its kind.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum FlyingMaster {
    /// 071h.
    ActiveMaster {
        /// 0 high, 1 medium, 2 low; others are reserved.
        priority: u8,
        /// The node-ID of the active master.
        node: u8,
    },
    /// 072h.
    NegotiationRequest,
    /// 073h.
    ActiveMasterRequest,
    /// 074h.
    MasterDetected,
    /// 075h.
    MasterDetectionRequest,
    /// 076h.
    ForceNegotiation,
}

impl FlyingMaster {
    /// The CAN-IDs of the service.
    pub const CAN_IDS: std::ops::RangeInclusive<u16> = 0x071..=0x076;

    /// Reads the message with this CAN-ID; surplus bytes are ignored.
    ///
    /// # Errors
    /// [`Malformed`] if the CAN-ID is not one of [`FlyingMaster::CAN_IDS`], or 071h with fewer than two bytes.
    pub fn read(can_id: u16, payload: &[u8]) -> Result<Self, Malformed> {
        Ok(match can_id {
            0x071 => return active_master(payload),
            0x072 => Self::NegotiationRequest,
            0x073 => Self::ActiveMasterRequest,
            0x074 => Self::MasterDetected,
            0x075 => Self::MasterDetectionRequest,
            0x076 => Self::ForceNegotiation,
            _ => return Err(Malformed { offset: 0, expected: "a CAN-ID of flying master, 071h to 076h" }),
        })
    }

    /// The CAN-ID of the message.
    pub const fn can_id(self) -> u16 {
        match self {
            Self::ActiveMaster { .. } => 0x071,
            Self::NegotiationRequest => 0x072,
            Self::ActiveMasterRequest => 0x073,
            Self::MasterDetected => 0x074,
            Self::MasterDetectionRequest => 0x075,
            Self::ForceNegotiation => 0x076,
        }
    }

    /// The message as a frame.
    pub fn to_frame(self) -> Frame {
        let id = CanId::standard_masked(u32::from(self.can_id()));
        match self {
            Self::ActiveMaster { priority, node } => data_frame(id, &[priority, node]),
            _ => data_frame(id, &[]),
        }
    }
}

fn active_master(payload: &[u8]) -> Result<FlyingMaster, Malformed> {
    let parsed: nom::IResult<&[u8], FlyingMaster, Malformed> =
        (named("the master's priority", u8), named("the master's node-ID", u8))
            .map(|(priority, node)| FlyingMaster::ActiveMaster { priority, node })
            .parse(payload);
    match parsed {
        Ok((_, message)) => Ok(message),
        Err(nom::Err::Error(error) | nom::Err::Failure(error)) => Err(error.in_payload(payload.len())),
        Err(nom::Err::Incomplete(_)) => Err(Malformed::at_end("more bytes").in_payload(payload.len())),
    }
}

impl fmt::Display for FlyingMaster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::ActiveMaster { priority, node } => {
                let level = match priority {
                    0 => "high",
                    1 => "medium",
                    2 => "low",
                    _ => "reserved",
                };
                write!(f, "active master is node {node}, priority {priority} ({level})")
            }
            Self::NegotiationRequest => f.write_str("negotiation request"),
            Self::ActiveMasterRequest => f.write_str("active master request"),
            Self::MasterDetected => f.write_str("master detected"),
            Self::MasterDetectionRequest => f.write_str("master detection request"),
            Self::ForceNegotiation => f.write_str("force negotiation"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_both_ways() {
        for (can_id, payload, message, text) in [
            (
                0x071,
                &[1, 5][..],
                FlyingMaster::ActiveMaster { priority: 1, node: 5 },
                "active master is node 5, priority 1 (medium)",
            ),
            (0x072, &[], FlyingMaster::NegotiationRequest, "negotiation request"),
            (0x073, &[], FlyingMaster::ActiveMasterRequest, "active master request"),
            (0x074, &[], FlyingMaster::MasterDetected, "master detected"),
            (0x075, &[], FlyingMaster::MasterDetectionRequest, "master detection request"),
            (0x076, &[], FlyingMaster::ForceNegotiation, "force negotiation"),
        ] {
            assert_eq!(FlyingMaster::read(can_id, payload), Ok(message));
            let frame = message.to_frame();
            assert_eq!((frame.cob_id(), frame.data()), (Some(can_id), payload));
            assert_eq!(message.to_string(), text);
        }
    }

    #[test]
    fn a_missing_byte_is_named() {
        assert_eq!(FlyingMaster::read(0x071, &[1]), Err(Malformed { offset: 1, expected: "the master's node-ID" }));
        assert!(FlyingMaster::read(0x077, &[1, 2]).is_err());
    }
}
