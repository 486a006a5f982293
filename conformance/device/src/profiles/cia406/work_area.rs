//! Work areas: state (6400h), low and high limit (6401h, 6402h), one sub-index for each channel.

use super::Encoder;
use crate::Fault;
use crate::device::Parameters;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_traces::Timestamp;

const OUT_OF_RANGE: u64 = 1 << 0;
const OVERFLOW: u64 = 1 << 1;
const UNDERFLOW: u64 = 1 << 2;

impl Encoder {
    /// The value of 6400h: overflow above the high limit, underflow below the low limit. A position beyond either
    /// limit, or outside 650Ah, is also out of range.
    pub(super) fn work_area(&self, now: Timestamp, sub: u8, parameters: &Parameters) -> Option<u64> {
        let (low, high) = (
            parameters.number(encoder::WORK_AREA_LOW_LIMIT, sub)?,
            parameters.number(encoder::WORK_AREA_HIGH_LIMIT, sub)?,
        );
        if sub == 0 {
            return None;
        }
        let position = self.position(now, parameters);
        let (over, under) = (position > high, position < low);
        let outside = over
            || under && !self.firmware.has(Fault::WorkAreaOutsideOneSided)
            || is_outside_module(position, parameters);
        let bit = |set: bool, bit: u64| if set { bit } else { 0 };
        Some(match () {
            () if self.firmware.has(Fault::WorkAreaStuck) => 0,
            () if self.firmware.has(Fault::WorkAreaBitsSwapped) => {
                bit(outside, OUT_OF_RANGE) | bit(over, UNDERFLOW) | bit(under, OVERFLOW)
            }
            () if self.firmware.has(Fault::WorkAreaInverted) => bit(!outside, OUT_OF_RANGE),
            () => bit(outside, OUT_OF_RANGE) | bit(over, OVERFLOW) | bit(under, UNDERFLOW),
        })
    }
}

/// Whether the position is outside the minimum and maximum of 650Ah. Both are signed; without a maximum above the
/// minimum there is no limit.
fn is_outside_module(position: u64, parameters: &Parameters) -> bool {
    let signed = |sub| parameters.number(encoder::MODULE_IDENTIFICATION, sub).map(|raw| i64::from(raw as u32 as i32));
    let (Some(low), Some(high)) = (signed(2), signed(3)) else { return false };
    let position = i64::try_from(position).unwrap_or(i64::MAX);
    // i32::MAX marks a range that does not fit into 650Ah.
    let bounded = high > low && high != i64::from(i32::MAX);
    bounded && !(low..=high).contains(&position)
}
