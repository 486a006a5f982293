//! Liberties in time: how long SDO answers, starts and stores take.

use super::{Liberties, Liberty};
use crate::models::Timing;

/// The longest time until an SDO answer with any liberty, in microseconds.
const SLOWEST_ANSWER_US: u64 = 900_000;

/// Changes the times of a model by its liberties.
pub(super) fn apply(timing: &mut Timing, liberties: Liberties) {
    if liberties.has(Liberty::AnswersVary) {
        timing.sdo_response_us = 1_000;
        timing.sdo_response_jitter_us = SLOWEST_ANSWER_US - 1_000;
    }
    if liberties.has(Liberty::AnswersIn900Ms) {
        timing.sdo_response_us = SLOWEST_ANSWER_US;
        timing.sdo_response_jitter_us = 0;
    }
    if liberties.has(Liberty::RestartIn5S) {
        timing.boot_ms = 5_000;
    }
    if liberties.has(Liberty::StoreIn3S) {
        timing.store_ms = 3_000;
    }
    if liberties.has(Liberty::TransferWithoutTimeout) {
        timing.sdo_timeout_ms = u64::from(u32::MAX);
    }
}
