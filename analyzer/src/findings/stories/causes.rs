//! What follows from what.

use super::groups::Group;
use super::order::rank;
use canvass_traces::Duration;

/// What follows comes within this time after the end of its cause.
const SETTLE: Duration = Duration::from_secs(5);
/// What others do about it comes within this time.
const SOON: Duration = Duration::from_secs(2);
const NONE: Duration = Duration::ZERO;

/// The codes of EMCY that another node or the bus brings about: communication, life guarding or heartbeat, recovered
/// from bus off, and those of a PDO or SYNC with the wrong length.
const MONITORING: [u64; 2] = [0x8130, 0x8100];
const OF_LENGTH: [u64; 4] = [0x8210, 0x8220, 0x8240, 0x8250];
const OF_BUS: [u64; 4] = [0x8110, 0x8120, 0x8140, 0x8100];

/// For each group the one from which it follows.
pub fn of(groups: &[Group<'_>]) -> Vec<Option<usize>> {
    let mut causes: Vec<Option<usize>> = vec![None; groups.len()];
    for (at, effect) in groups.iter().enumerate() {
        let possible = groups
            .iter()
            .enumerate()
            .filter(|(other, cause)| *other != at && cause.channel == effect.channel && follows(effect, cause));
        // The worst of several; of these the one that began last before it.
        let best = possible.min_by_key(|(_, cause)| (rank(cause.rule), effect.first().since(cause.first())));
        causes[at] = best.map(|(cause, _)| cause);
    }
    for at in 0..groups.len() {
        if is_circle(&causes, at) {
            causes[at] = None;
        }
    }
    link(groups, &mut causes);
    causes
}

/// Between a cause and what follows from it there may be something that follows from the one and brings about the other:
/// a node is lost, its consumer notices, sends an EMCY, and leaves operational. All of it stays in the same story.
fn link(groups: &[Group<'_>], causes: &mut [Option<usize>]) {
    let orders: Vec<_> = groups.iter().map(|group| (group.first(), rank(group.rule))).collect();
    for (at, effect) in groups.iter().enumerate() {
        let Some(cause) = causes[at] else { continue };
        let story = root(causes, cause);
        let between = (0..groups.len()).filter(|&other| {
            let is_between = orders[cause] < orders[other] && orders[other] < orders[at];
            let group = &groups[other];
            is_between
                && group.channel == effect.channel
                && follows(effect, group)
                && root(causes, other) == story
                && !leads_to(causes, other, at)
        });
        if let Some(last) = between.max_by_key(|other| orders[*other]) {
            causes[at] = Some(last);
        }
    }
}

/// Whether what is at the one place is among the causes of what is at the other.
fn leads_to(causes: &[Option<usize>], effect: usize, cause: usize) -> bool {
    let chain = std::iter::successors(Some(effect), |at| causes[*at]);
    chain.take(causes.len()).any(|at| at == cause)
}

/// The group from which all of a story follows.
pub fn root(causes: &[Option<usize>], at: usize) -> usize {
    let mut root = at;
    for _ in 0..causes.len() {
        match causes[root] {
            Some(cause) => root = cause,
            None => break,
        }
    }
    root
}

fn is_circle(causes: &[Option<usize>], at: usize) -> bool {
    causes[root(causes, at)].is_some()
}

/// Whether what the one group says follows from what the other says.
fn follows(effect: &Group<'_>, cause: &Group<'_>) -> bool {
    let time = effect.first();
    // Asked for where it matters only: there may be thousands of groups.
    let same = || effect.nodes.iter().any(|node| cause.has(Some(*node)));
    let origin = || effect.findings.iter().any(|finding| cause.has(finding.origin));
    match (cause.rule, effect.rule) {
        ("nodes/lost", effect_rule) => by_loss(effect, effect_rule, cause, same(), origin()),
        ("nodes/heartbeat-ended" | "nodes/no-boot-up", "nodes/consumer-time") => origin(),
        ("nodes/heartbeat-missing", "nodes/consumer-time") => {
            origin() && (cause.covers(time, SOON, SOON) || cause.spans(time, SOON))
        }
        ("nodes/boot-up-without-command" | "nodes/repeated-resets", rule) => {
            by_restart(effect, rule, cause, same(), origin())
        }
        ("nodes/consumer-time" | "nodes/life-guarding", "emcy/raised") => {
            same() && MONITORING.contains(&effect.kind) && cause.covers(time, SOON, SETTLE)
        }
        ("nodes/consumer-time" | "nodes/life-guarding", "nodes/state-lost") => {
            same() && cause.covers(time, SOON, SETTLE)
        }
        ("emcy/raised", "nodes/state-lost") => same() && cause.covers(time, SOON, SOON),
        ("emcy/raised", "emcy/never-cleared") => same() && cause.kind == effect.kind,
        ("emcy/raised", "encoder/alarm" | "encoder/warning") => same() && cause.covers(time, SOON, SETTLE),
        ("emcy/storm", "emcy/raised" | "emcy/contradiction" | "emcy/never-cleared") => same(),
        ("emcy/storm", "bus/load") => cause.spans(time, SOON),
        ("bus/duplicate-node-id", rule) => same() && !rule.starts_with("lss/") && rank(rule) > 0,
        ("bus/two-producers", "pdo/sync-counter" | "pdo/sync-jitter" | "pdo/sync-missing") => true,
        ("bus/two-producers", "pdo/sync-pdo-missing" | "pdo/sync-window" | "pdo/time-jump") => true,
        ("bus/load", rule) => by_load(effect, rule, cause),
        ("pdo/sync-missing", "pdo/sync-pdo-missing" | "pdo/sync-window" | "pdo/sync-counter" | "pdo/sync-jitter") => {
            cause.covers(time, SOON, SETTLE)
        }
        ("pdo/sync-missing", "emcy/raised" | "nodes/state-lost") => cause.covers(time, SOON, SETTLE),
        ("pdo/length", "emcy/raised") => OF_LENGTH.contains(&effect.kind) && cause.spans(time, SOON),
        ("nodes/command-not-obeyed", "nodes/pdo-outside-operational" | "nodes/sdo-in-stopped") => same(),
        ("nodes/command-not-obeyed", "nodes/no-boot-up") => same(),
        ("nodes/state-lost", "nodes/pdo-outside-operational" | "pdo/sync-pdo-missing") => same(),
        ("sdo/impatient-client" | "sdo/unanswered", "sdo/aborted" | "sdo/retries" | "sdo/protocol-violation") => {
            same() && cause.spans(time, SETTLE)
        }
        ("sdo/late", "sdo/retries" | "sdo/protocol-violation") => same() && cause.spans(time, SETTLE),
        ("sdo/late", "sdo/aborted") => same() && cause.spans(time, SOON),
        ("capture/bus-off", "capture/error-frames" | "capture/error-passive") => cause.covers(time, SETTLE, SETTLE),
        ("capture/error-frames", "capture/error-passive") => true,
        _ => false,
    }
}

/// What follows from the loss of a node: of itself nearly everything, of others that they miss it.
fn by_loss(effect: &Group<'_>, rule: &str, cause: &Group<'_>, same: bool, origin: bool) -> bool {
    let time = effect.first();
    match rule {
        "nodes/lost" | "bus/load" | "bus/duplicate-node-id" => false,
        "nodes/consumer-time" => origin && cause.covers(time, SOON, SOON),
        "pdo/sync-missing" => cause.covers(time, SOON, NONE),
        "capture/error-frames" | "capture/error-passive" => cause.covers(time, SETTLE, SETTLE),
        // What it said just before may tell why.
        "emcy/raised" if same => cause.covers(time, SETTLE, SETTLE),
        "emcy/raised" => MONITORING.contains(&effect.kind) && cause.covers(time, NONE, SOON),
        "nodes/state-lost" if !same => cause.covers(time, NONE, SOON),
        _ => same && cause.covers(time, SOON, SETTLE),
    }
}

/// What follows from a restart of a node.
fn by_restart(effect: &Group<'_>, rule: &str, cause: &Group<'_>, same: bool, origin: bool) -> bool {
    let time = effect.first();
    match rule {
        "nodes/lost" | "bus/load" | "bus/duplicate-node-id" => false,
        "nodes/boot-up-without-command" => same && cause.rule == "nodes/repeated-resets",
        "nodes/consumer-time" => origin && cause.spans(time, SETTLE),
        "pdo/sync-missing" => cause.covers(time, SOON, SOON),
        "emcy/raised" if !same => MONITORING.contains(&effect.kind) && cause.covers(time, SOON, SOON),
        _ => same && cause.spans(time, SOON),
    }
}

/// What follows from a bus that is full: everything that comes late.
fn by_load(effect: &Group<'_>, rule: &str, cause: &Group<'_>) -> bool {
    let late = matches!(
        rule,
        "nodes/heartbeat-late"
            | "nodes/heartbeat-jitter"
            | "nodes/heartbeat-missing"
            | "nodes/consumer-time"
            | "nodes/life-guarding"
            | "nodes/guarding-unanswered"
            | "sdo/late"
            | "sdo/retries"
            | "sdo/unanswered"
            | "sdo/impatient-client"
            | "pdo/period"
            | "pdo/jitter"
            | "pdo/sync-missing"
            | "pdo/sync-jitter"
            | "pdo/sync-window"
            | "pdo/sync-pdo-missing"
    );
    let of_bus = rule == "emcy/raised" && (OF_BUS.contains(&effect.kind) || MONITORING.contains(&effect.kind));
    (late || of_bus) && cause.spans(effect.first(), SETTLE)
}
