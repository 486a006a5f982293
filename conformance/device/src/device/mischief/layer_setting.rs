//! LSS messages that a faulty firmware misreads, alters or drops.

use super::{Incoming, Mischief, pass, put};
use crate::Fault;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::lss;
use canvass_traces::{CanId, Frame};

impl Mischief {
    pub(super) fn on_lss(&mut self, frame: &Frame, node: Option<NodeId>, address: [u32; 4]) -> Incoming {
        let mut bytes = frame.bytes();
        self.request = bytes;
        let answer =
            |data: [u8; 8]| Incoming::Answered(Frame::full(CanId::standard_masked(u32::from(lss::SLAVE_CAN_ID)), data));
        let command = bytes[0];
        match command {
            0x04 if self.has(Fault::LssSwitchGlobalIgnored) => return Incoming::Lost,
            0x04 => {
                self.configuring = bytes[1] == 1;
                self.muted |= !self.configuring && node.is_none() && self.has(Fault::UnconfiguredNodeIdWaits);
            }
            0x43 if self.configuring && self.has(Fault::LssSelectiveInConfiguration) => {
                return answer([0x44, 0, 0, 0, 0, 0, 0, 0]);
            }
            0x11 if self.configuring && self.has(Fault::LssNodeIdWithoutEffect) && bytes[1] != 255 => {
                return answer([0x11, 0, 0, 0, 0, 0, 0, 0]);
            }
            0x51 if self.has_yielded(bytes) => return Incoming::Lost,
            0x40..=0x43
                if self.has(Fault::LssSelectiveMismatchIgnored)
                    && bytes[1..5] != address[usize::from(command - 0x40)].to_le_bytes() =>
            {
                return Incoming::Lost;
            }
            0x40..=0x42 if self.has(Fault::LssSelectiveSerialOnly) => {
                put(&mut bytes, address[usize::from(command - 0x40)]);
            }
            0x46..=0x4B if self.has(Fault::LssIdentifyUnchecked) => {
                let part = usize::from(command - 0x46);
                put(&mut bytes, address[if part < 2 { part } else { part / 2 + 1 }]);
            }
            0x51 if self.has(Fault::FastscanIgnoresBits) && bytes[5] != 0x80 => {
                let part = usize::from(bytes[6]);
                put(&mut bytes, address.get(part).copied().unwrap_or_default());
            }
            0x11 | 0x13 | 0x15 | 0x17 | 0x40..=0x43 | 0x46..=0x4C | 0x51 | 0x5A..=0x5E => {}
            _ if self.has(Fault::LssUnknownAnswered) => return answer([command, 0, 0, 0, 0, 0, 0, 0]),
            _ => {}
        }
        pass(Frame::new(frame.id(), bytes.get(..frame.len()).unwrap_or(&bytes)).unwrap_or(*frame))
    }

    /// Whether this firmware stops taking part in Fastscan, because another slave has answered since Fastscan began.
    fn has_yielded(&mut self, request: [u8; 8]) -> bool {
        if request[5] == 0x80 {
            self.yielded = false;
        }
        self.yielded && self.has(Fault::FastscanYieldsToOthers)
    }

    pub(super) fn lss_response(&self, frame: Frame) -> Option<Frame> {
        let mut bytes = frame.bytes();
        let searched = matches!(self.request[0], 0x46..=0x4C);
        match bytes[0] {
            0x44 if self.has(Fault::LssSelectiveUnanswered) => return None,
            0x17 if self.has(Fault::LssStoreUnanswered) => return None,
            0x4F | 0x50 if searched && self.has(Fault::LssIdentifyUnanswered) => return None,
            0x11 if self.has(Fault::LssNodeIdRefused) => bytes[1] = 1,
            0x13 if self.has(Fault::LssBitTimingRefused) => bytes[1] = 1,
            0x5A..=0x5D if self.has(Fault::LssInquirySwapped) => bytes[1..5].reverse(),
            0x5E if self.has(Fault::LssNodeIdInquiredWrong) => bytes[1] = bytes[1].wrapping_add(1),
            _ => {}
        }
        let len = if self.has(Fault::LssShortResponse) { 5 } else { frame.len() };
        Frame::new(frame.id(), bytes.get(..len).unwrap_or(&bytes))
    }
}
