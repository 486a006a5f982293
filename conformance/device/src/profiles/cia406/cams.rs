//! Cams: state (6300h), enable (6301h) and polarity (6302h), one bit for each of eight cams and one sub-index for each
//! channel; low limit, high limit and hysteresis of cam N (6310h, 6320h, 6330h + N - 1).

use super::Encoder;
use crate::Fault;
use crate::device::Parameters;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_traces::Timestamp;
use std::cell::Cell;

/// The cams that were active when they were last evaluated, by channel from 1. An active cam ends only beyond its
/// hysteresis.
#[derive(Clone, Debug, Default)]
pub(super) struct Cams(Cell<[u8; CHANNELS]>);

/// Number of channels with hysteresis.
const CHANNELS: usize = 4;
const CAMS: u16 = 8;

impl Encoder {
    /// The value of 6300h. A cam is active from its low to its high limit, both included. An active cam stays active
    /// until the position is outside by more than the hysteresis.
    pub(super) fn cam_state(&self, now: Timestamp, channel: u8, parameters: &Parameters) -> Option<u64> {
        let slot = usize::from(channel.checked_sub(1)?);
        let register = |index| parameters.number_or_zero(index, channel) as u8;
        let enabled = if self.firmware.has(Fault::CamEnableIgnored) { u8::MAX } else { register(encoder::CAM_ENABLE) };
        let polarity = if self.firmware.has(Fault::CamPolarityIgnored) { 0 } else { register(encoder::CAM_POLARITY) };
        let position = self.position(now, parameters) as i64;
        let mut memory = self.cams.0.get();
        let before = memory.get(slot).copied().unwrap_or(0);
        let is_active = |cam| self.is_inside(position, cam, channel, before >> cam & 1 != 0, parameters);
        let active = (0..CAMS).filter(|&cam| enabled >> cam & 1 != 0 && is_active(cam));
        let active = active.fold(0_u8, |bits, cam| bits | 1 << cam);
        if let Some(slot) = memory.get_mut(slot) {
            *slot = active;
        }
        self.cams.0.set(memory);
        Some(if self.firmware.has(Fault::CamStuck) { 0 } else { ((active ^ polarity) & enabled).into() })
    }

    /// Whether the position is inside a cam; an active cam ends only beyond its hysteresis.
    fn is_inside(&self, position: i64, cam: u16, channel: u8, was_active: bool, parameters: &Parameters) -> bool {
        let limit = |index: u16| i64::from(parameters.number_or_zero(index + cam, channel) as u32 as i32);
        let (low, high) = (limit(encoder::CAM_LOW_LIMIT), limit(encoder::CAM_HIGH_LIMIT));
        let hysteresis = match was_active && !self.firmware.has(Fault::CamHysteresisIgnored) {
            true => parameters.number_or_zero(encoder::CAM_HYSTERESIS + cam, channel) as i64,
            false => 0,
        };
        let below = position <= high + hysteresis || self.firmware.has(Fault::CamHighLimitIgnored);
        low <= high && position >= low - hysteresis && below
    }
}
