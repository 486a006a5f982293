use super::hooks;
use crate::{Fault, Firmware};
use canvass_analyzer::wire::error_control::State;

hooks! {
    toggles_guarding unless GuardingToggleStuck,
    answers_guarding_when_off unless GuardingSilentWhenOff,
    keeps_guarding_toggle_over_reset with GuardingToggleNotReset,
    stops_life_guarding_at_zero unless LifeGuardingNotStopped,
    guards_before_first_request with LifeGuardingStartsAtOnce,
    guards_beside_heartbeat with GuardingBesideHeartbeat,
    reports_lost_master unless LifeGuardingUnreported,
}

impl Firmware {
    /// The factor of the life time, by 100Dh.
    pub(in crate::device) fn life_time_factor(&self, factor: u64) -> u64 {
        let factor = if self.has(Fault::LifeTimeFactorIgnored) { factor.min(1) } else { factor };
        factor + u64::from(self.has(Fault::LifeTimeFactorOffByOne) && factor > 0)
    }

    /// The state that an answer to a guarding request shows.
    pub(in crate::device) const fn guarded_state(&self, state: State) -> State {
        if self.has(Fault::GuardingWrongState) { State::PRE_OPERATIONAL } else { state }
    }
}
