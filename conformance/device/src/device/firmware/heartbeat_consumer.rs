use super::hooks;
use crate::{Fault, Firmware};

hooks! {
    consumes_with_time_zero with HeartbeatConsumerTimeZero,
    checks_consumer_entries unless HeartbeatConsumerDoubleAccepted,
    consumes_from_first_only with HeartbeatConsumerFirstOnly,
    rearms_consumer unless HeartbeatConsumerNotRearmed,
    forgets_stored_consumer with HeartbeatConsumerForgetsStored,
    consumes_before_first_heartbeat with HeartbeatConsumerStartsAtOnce,
    consumes_when_stopped unless HeartbeatConsumerDeafWhenStopped,
    is_deaf_to_node_one with HeartbeatConsumerDeafToNodeOne,
    restarts_consumer_by_writes with HeartbeatConsumerRestartedByWrites,
    watches_over_reset with HeartbeatConsumerOutlivesReset,
    reacts_to_return with ConsumerReturnLeaves,
    consumes_from_everyone with HeartbeatConsumerWatchesEveryone,
    hangs_of_consumer_entry with HeartbeatConsumerHangs,
}
