use super::hooks;
use crate::{Fault, Firmware};

hooks! {
    keeps_emcy_when_inhibited unless EmcyLostWhenInhibited,
    mutes_inhibited_emcy with EmcyMutedByInhibitTime,
    keeps_emcy_when_stopped unless EmcyLostWhenStopped,
    shows_register_in_emcy unless EmcyRegisterZero,
    repeats_emcy with EmcyRepeated,
    sends_error_reset unless EmcyResetMissing,
    resets_with_old_register with EmcyResetRegisterWrong,
    heeds_emcy_inhibit_time unless EmcyInhibitTimeIgnored,
    sends_emcy_when_invalid with EmcySentWhenInvalid,
    reads_empty_history_as_zero with ErrorHistoryEmptyReadsZero,
    clears_history unless ErrorHistoryNotCleared,
    overflows_history with ErrorHistoryOverflows,
    reverses_history with ErrorHistoryReversed,
    clears_register_when_read with ErrorRegisterReadClears,
    keeps_register_bits with ErrorRegisterStuck,
    sets_generic_bit unless ErrorRegisterGenericMissing,
    reports_temperature unless WarningWithoutEmcy,
    heeds_error_behaviour unless ErrorBehaviourIgnored,
    leaves_stopped_on_error with ErrorBehaviourLeavesStopped,
    leaves_on_any_profile_error with ProfileErrorAlwaysLeaves,
    ignores_profile_errors with ProfileErrorIgnored,
}
