use super::hooks;
use crate::{Fault, Firmware};
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_traces::Duration;

hooks! {
    heeds_stored_times unless StoredConfigurationIdle,
    stops_heartbeat_at_zero unless HeartbeatNotStopped,
    makes_up_for_heartbeats with HeartbeatBurst,
    shows_stale_state with HeartbeatStateLate,
    sets_toggle_in_heartbeat with HeartbeatToggles,
    delays_first_heartbeat with HeartbeatLateAfterBootUp,
    keeps_heartbeat_over_state_change unless HeartbeatLostOnStateChange,
}

/// A timer that counts in so many milliseconds.
const COARSE: u64 = 64;

impl Firmware {
    /// The time between heartbeats, by 1017h.
    pub(in crate::device) fn heartbeat_period(&self, millis: u64) -> Duration {
        let millis = if self.has(Fault::HeartbeatTimerRounded) { millis.next_multiple_of(COARSE) } else { millis };
        Duration::from_millis(millis).times(if self.has(Fault::HeartbeatPeriodDoubled) { 2 } else { 1 })
    }

    /// The state that a heartbeat shows.
    pub(in crate::device) const fn heartbeat_state(&self, state: State) -> State {
        if self.has(Fault::HeartbeatWrongState) { State::PRE_OPERATIONAL } else { state }
    }

    /// The messages at the end of initialisation.
    pub(in crate::device) fn boot_up_messages(&self) -> impl Iterator<Item = ErrorControl> + use<> {
        let count = match () {
            () if self.has(Fault::BootUpMissing) => 0,
            () if self.has(Fault::BootUpTwice) => 2,
            () => 1,
        };
        let message = match self.has(Fault::BootUpWrongData) {
            true => ErrorControl::heartbeat(State::PRE_OPERATIONAL),
            false => ErrorControl::BOOT_UP,
        };
        std::iter::repeat_n(message, count)
    }
}
