//! Effects of a node's restarts.

use crate::findings::effect::{Effect, MONITORING, SETTLE, SOON};

/// The effects of restarts; `on_restarts` tells whether findings about single restarts are among them.
pub const fn effects(on_restarts: Effect) -> [Effect; 7] {
    [
        on_restarts,
        Effect::never_on(&["nodes/lost", "bus/load", "bus/duplicate-node-id", "lss/left-in-configuration"]),
        Effect::on(&["nodes/consumer-time"]).of_origin().spanning(SETTLE),
        Effect::on(&["pdo/sync-missing"]).during(SOON, SOON),
        Effect::on(&["emcy/raised"]).of_same_node().spanning(SOON),
        Effect::on(&["emcy/raised"]).of_others().with_codes(MONITORING).during(SOON, SOON),
        Effect::on_the_rest().of_same_node().spanning(SOON),
    ]
}
