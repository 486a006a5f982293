//! Cams: states (6300h), which are enabled and turned round (6301h, 6302h), limits (6310h.., 6320h..) and hysteresis
//! (6330h..), one bit or one object for each of eight cams, one sub-index for each channel.

use super::Encoder;
use crate::Fault;
use crate::device::parameters::Parameters;
use canvass_traces::Timestamp;

const CAMS: u16 = 8;

impl Encoder {
    /// 6300h.
    pub(super) fn cam_states(&self, now: Timestamp, sub: u8, parameters: &Parameters) -> Option<u64> {
        let register = |index| parameters.number_or_zero(index, sub) as u8;
        if sub == 0 {
            return None;
        }
        let position = i64::try_from(self.position(now, parameters)).ok()?;
        let before = self.cams.get();
        let active = (0..CAMS).filter(|&cam| {
            let was_active = before & 1 << cam != 0;
            self.is_inside(position, cam, sub, was_active, parameters)
        });
        let active = active.fold(0_u8, |bits, cam| bits | 1 << cam);
        self.cams.set(active);
        let enabled = if self.faults.has(Fault::CamEnableIgnored) { u8::MAX } else { register(0x6301) };
        let turned = if self.faults.has(Fault::CamPolarityIgnored) { 0 } else { register(0x6302) };
        let states = (active ^ turned) & enabled;
        Some(if self.faults.has(Fault::CamStuck) { 0 } else { states.into() })
    }

    /// Whether the position lies in a cam; one that is active ends only beyond its hysteresis.
    fn is_inside(&self, position: i64, cam: u16, sub: u8, was_active: bool, parameters: &Parameters) -> bool {
        let limit = |index: u16| parameters.number(index + cam, sub).map(|raw| i64::from(raw as u32 as i32));
        let (Some(low), Some(high)) = (limit(0x6310), limit(0x6320)) else { return false };
        let hysteresis = match self.faults.has(Fault::CamHysteresisIgnored) {
            true => 0,
            false => parameters.number_or_zero(0x6330 + cam, sub) as i64,
        };
        let wider = if was_active { hysteresis } else { 0 };
        let below = position <= high.saturating_add(wider) || self.faults.has(Fault::CamHighLimitIgnored);
        position >= low.saturating_sub(wider) && below
    }
}
