//! Raw data of the sensor: the manufacturer's raw position with its inverse and its checksum (2160h to 2162h), and the
//! profile's raw position (600Bh, 600Ch).

use super::Encoder;
use super::operating::{physical_range, steps_per_unit};
use crate::Fault;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::sdo::crc16;
use canvass_traces::Timestamp;

/// Start value of the checksum, so that leading zeros count.
const CRC_START: u16 = 0x1021;

impl Encoder {
    pub(super) fn raw_value(&self, now: Timestamp, at: Multiplexer) -> Option<u64> {
        let raw = self.raw(now);
        Some(match (at.index.0, at.sub.0) {
            (0x2161, 0) if self.firmware.has(Fault::RawInverseWrong) => raw,
            (0x2161, 0) => !raw,
            (0x2162, 0) => u64::from(self.checksum(raw as u32)),
            (encoder::POSITION_RAW_VALUE, 0) if self.firmware.has(Fault::RawPositionFollowsPreset) => {
                raw.wrapping_add(self.offset as u64)
            }
            (0x2160 | encoder::HIGH_RESOLUTION_RAW_VALUE | encoder::POSITION_RAW_VALUE, 0) => raw,
            _ => return None,
        })
    }

    /// The position in steps over all revolutions, independent of the code sequence. 32-bit objects show the lower
    /// bits.
    fn raw(&self, now: Timestamp) -> u64 {
        let now = if self.firmware.has(Fault::RawPositionStands) { Timestamp::ZERO } else { now };
        self.motion.position(now, steps_per_unit(&self.sheet)).rem_euclid(physical_range(&self.sheet)) as u64
    }

    /// CRC-16 with polynomial 1021h over the bytes of the raw position, in the order of transmission.
    fn checksum(&self, raw: u32) -> u16 {
        let start = if self.firmware.has(Fault::RawCrcStartWrong) { 0xFFFF } else { CRC_START };
        crc16(start, &raw.to_le_bytes())
    }
}
