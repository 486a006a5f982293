use super::hooks;
use crate::{Fault, Firmware};

hooks! {
    consumes_with_time_zero with HeartbeatConsumerTimeZero,
    checks_consumer_entries unless HeartbeatConsumerDoubleAccepted,
    consumes_from_first_only with HeartbeatConsumerFirstOnly,
    rearms_consumer unless HeartbeatConsumerNotRearmed,
    forgets_stored_consumer with HeartbeatConsumerForgetsStored,
    consumes_before_first_heartbeat with HeartbeatConsumerStartsAtOnce,
    reacts_to_return with ConsumerReturnLeaves,
    consumes_from_everyone with HeartbeatConsumerWatchesEveryone,
    hangs_of_consumer_entry with HeartbeatConsumerHangs,
}
