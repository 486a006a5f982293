use super::hooks;
use crate::{Fault, Firmware};

hooks! {
    checks_consumer_entries unless HeartbeatConsumerDoubleAccepted,
    consumes_from_first_only with HeartbeatConsumerFirstOnly,
    rearms_consumer unless HeartbeatConsumerNotRearmed,
    consumes_before_first_heartbeat with HeartbeatConsumerStartsAtOnce,
    consumes_from_everyone with HeartbeatConsumerWatchesEveryone,
}
