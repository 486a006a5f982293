//! Cams: state (6300h), enable (6301h) and polarity (6302h), one bit for each of eight cams and one sub-index for each
//! channel; low limit, high limit and hysteresis of cam N (6310h, 6320h, 6330h + N - 1).

use super::Encoder;
use crate::Fault;
use crate::device::parameters::Parameters;
use canvass_traces::Timestamp;
use std::cell::Cell;

/// Which cams were active when somebody last looked, by channel from 1: their hysteresis begins there.
#[derive(Clone, Debug, Default)]
pub(super) struct Cams(Cell<[u8; CHANNELS]>);

/// More channels have no hysteresis.
const CHANNELS: usize = 4;
const CAMS: u16 = 8;

impl Encoder {
    /// 6300h: a cam is active from its low to its high limit, both included; once active it stays so until the position
    /// is farther outside than its hysteresis.
    pub(super) fn cam_state(&self, now: Timestamp, channel: u8, parameters: &Parameters) -> Option<u64> {
        let enabled = parameters.number(0x6301, channel).filter(|_| channel > 0)?;
        let has = |fault| self.faults.has(fault);
        let enabled = if has(Fault::CamEnableIgnored) { u8::MAX.into() } else { enabled };
        let polarity = if has(Fault::CamPolarityIgnored) { 0 } else { parameters.number_or_zero(0x6302, channel) };
        let position = self.position(now, parameters) as i64;
        let mut memory = self.cams.0.get();
        let before = memory.get(usize::from(channel) - 1).copied().unwrap_or(0);
        let signed = |index| parameters.number_or_zero(index, channel) as u32 as i32;
        let is_active = |cam: u16| {
            let was_active = before >> cam & 1 != 0;
            let slack = if was_active && !has(Fault::CamHysteresisIgnored) {
                parameters.number_or_zero(0x6330 + cam, channel) as i64
            } else {
                0
            };
            let (low, high) = (i64::from(signed(0x6310 + cam)), i64::from(signed(0x6320 + cam)));
            let high = if has(Fault::CamHighLimitIgnored) { i64::from(i32::MAX) } else { high };
            low <= high && (low - slack..=high + slack).contains(&position)
        };
        let active = (0..CAMS).filter(|&cam| enabled >> cam & 1 != 0 && is_active(cam));
        let active = active.fold(0_u8, |bits, cam| bits | 1 << cam);
        if let Some(slot) = memory.get_mut(usize::from(channel) - 1) {
            *slot = active;
        }
        self.cams.0.set(memory);
        Some(if has(Fault::CamStuck) { 0 } else { (u64::from(active) ^ polarity) & enabled })
    }
}
