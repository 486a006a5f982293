//! What is told first: what has the worst consequences for a machine.

/// The rules by what they mean for a machine: a node is lost, one restarts, something is wrong with who sends what, a
/// device reports an error, states, process data, transfers.
const RANKS: [&[&str]; 7] = [
    &[
        "nodes/lost",
        "nodes/heartbeat-ended",
        "nodes/no-boot-up",
        "capture/bus-off",
        "pdo/sync-missing",
        "bus/duplicate-node-id",
    ],
    &["nodes/repeated-resets", "nodes/boot-up-without-command"],
    &["bus/two-producers", "bus/overlapping-cob-id", "bus/load", "nodes/consumer-time", "nodes/life-guarding"],
    &["emcy/storm", "pdo/length", "emcy/raised", "encoder/alarm"],
    &[
        "nodes/command-not-obeyed",
        "nodes/state-lost",
        "nodes/heartbeat-missing",
        "nodes/guarding-unanswered",
        "capture/error-frames",
        "capture/error-passive",
        "bus/restricted-cob-id",
    ],
    &["nodes/pdo-outside-operational", "pdo/sync-pdo-missing", "pdo/period", "sdo/unanswered", "sdo/impatient-client"],
    &["sdo/late", "sdo/aborted"],
];

/// The lower, the earlier it is reported.
pub fn rank(rule: &str) -> usize {
    RANKS.iter().position(|rank| rank.contains(&rule)).unwrap_or(RANKS.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::find;

    #[test]
    fn all_of_them_are_rules() {
        for rule in RANKS.into_iter().flatten() {
            assert!(find(rule).is_some(), "{rule}");
        }
    }

    #[test]
    fn a_loss_comes_before_a_restart_and_that_before_an_emcy() {
        let rules = ["nodes/lost", "nodes/boot-up-without-command", "emcy/raised", "nodes/state-lost", "sdo/aborted"];
        assert!(rules.map(rank).is_sorted_by(|a, b| a < b));
    }
}
