//! The row of a node in the timeline: the states that the node has shown, and its silences.
//!
//! An NMT command does not show the state of a node. A reset is drawn until the node shows a state again. A node that
//! drops out is silent, whatever commands it gets in the meantime.

use canvass_analyzer::NodeId;
use canvass_analyzer::findings::Finding;
use canvass_analyzer::network::Cause;
use canvass_analyzer::statistics::{NodeStatistics, StateChange};
use canvass_analyzer::wire::error_control::State;
use canvass_traces::{ChannelId, Timestamp};

/// The rule that finds nodes that drop out.
const LOST: &str = "nodes/lost";
/// The state of a node that sends nothing though it should.
pub const SILENT: &str = "silent";
/// The state of a node that was reset and has not shown a state since.
pub const RESET: &str = "reset";

/// A state within a range of time.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Span {
    pub from: Timestamp,
    pub to: Timestamp,
    /// The name of an NMT state, [`SILENT`] or [`RESET`].
    pub state: String,
}

/// The silences of a node.
#[derive(Debug, Default)]
pub(crate) struct Silences {
    /// The times from the last frame before a silence to the first frame after it, in the order of time.
    windows: Vec<(Timestamp, Timestamp)>,
    /// Number of further silences whose times are not known.
    pub left_out: u64,
}

impl Silences {
    /// The silences of one node in the findings.
    pub fn of(findings: &[Finding], channel: ChannelId, node: NodeId) -> Self {
        let own = |finding: &&Finding| {
            finding.rule.id == LOST && finding.channel == Some(channel) && finding.node == Some(node)
        };
        let mut silences = Self::default();
        for finding in findings.iter().filter(own) {
            silences.windows.extend(&finding.windows);
            silences.left_out += finding.count.saturating_sub(finding.windows.len() as u64);
        }
        silences.windows.sort_unstable();
        silences
    }
}

/// The name of a state, or [`RESET`] after a reset command.
pub fn name(change: &StateChange) -> String {
    match (change.state, change.cause) {
        (State::BOOT_UP, Cause::Command) => RESET.to_owned(),
        (state, _) => state.to_string(),
    }
}

/// The states of a node. A silence replaces the states that were commanded meanwhile.
pub fn spans(node: &NodeStatistics, silences: &Silences) -> Vec<Span> {
    let mut spans = Vec::new();
    for (at, change) in node.states.iter().enumerate() {
        let next = node.states.get(at + 1).map(|next| next.time);
        let (mut from, to) = (change.time, next.unwrap_or(node.last).max(change.time));
        for (begin, end) in silences.windows.iter().filter(|(begin, end)| *begin < to && *end > change.time) {
            push(&mut spans, from, *begin, &name(change));
            from = from.max(*end);
        }
        push(&mut spans, from, to, &name(change));
    }
    for (begin, end) in &silences.windows {
        push(&mut spans, *begin, *end, SILENT);
    }
    spans.sort_by_key(|span| span.from);
    joined(spans)
}

fn push(spans: &mut Vec<Span>, from: Timestamp, to: Timestamp, state: &str) {
    if from < to {
        spans.push(Span { from, to, state: state.to_owned() });
    }
}

/// Joins neighbouring spans of the same state.
fn joined(spans: Vec<Span>) -> Vec<Span> {
    let mut joined: Vec<Span> = Vec::new();
    for span in spans {
        match joined.last_mut() {
            Some(last) if last.state == span.state && last.to >= span.from => last.to = last.to.max(span.to),
            _ => joined.push(span),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn change(second: u64, state: State, cause: Cause) -> StateChange {
        StateChange { time: Timestamp(second * SECOND), state, cause }
    }

    fn shown(states: Vec<StateChange>, last: u64, windows: &[(u64, u64)]) -> Vec<(u64, u64, String)> {
        let mut node = NodeStatistics::default();
        node.states = states;
        node.last = Timestamp(last * SECOND);
        let at = |second: u64| Timestamp(second * SECOND);
        let windows = windows.iter().map(|(begin, end)| (at(*begin), at(*end))).collect();
        let spans = spans(&node, &Silences { windows, left_out: 0 });
        spans.into_iter().map(|span| (span.from.nanos() / SECOND, span.to.nanos() / SECOND, span.state)).collect()
    }

    fn row(from: u64, to: u64, state: &str) -> (u64, u64, String) {
        (from, to, state.to_owned())
    }

    /// A command to a node that is not there does not change the shown state.
    #[test]
    fn a_silent_node_is_silent_whatever_it_is_told() {
        let states = vec![
            change(1, State::OPERATIONAL, Cause::ErrorControl),
            change(15, State::BOOT_UP, Cause::Command),
            change(18, State::BOOT_UP, Cause::Command),
            change(20, State::PRE_OPERATIONAL, Cause::BootUp),
            change(22, State::OPERATIONAL, Cause::ErrorControl),
        ];
        assert_eq!(
            shown(states, 30, &[(12, 20)]),
            [
                row(1, 12, "operational"),
                row(12, 20, SILENT),
                row(20, 22, "pre-operational"),
                row(22, 30, "operational")
            ]
        );
    }

    #[test]
    fn a_node_that_comes_back_as_it_was_and_one_that_does_not() {
        let states = || vec![change(1, State::OPERATIONAL, Cause::ErrorControl)];
        let there = |to| row(1, to, "operational");
        assert_eq!(
            shown(states(), 30, &[(5, 7), (12, 14)]),
            [there(5), row(5, 7, SILENT), row(7, 12, "operational"), row(12, 14, SILENT), row(14, 30, "operational")]
        );
        assert_eq!(shown(states(), 12, &[(12, 30)]), [there(12), row(12, 30, SILENT)]);
    }

    /// After a reset command the node has not shown a state; only the node itself can send a boot-up message.
    #[test]
    fn a_reset_is_no_boot_up() {
        let states = vec![
            change(1, State::OPERATIONAL, Cause::ErrorControl),
            change(5, State::BOOT_UP, Cause::Command),
            change(6, State::BOOT_UP, Cause::Command),
            change(7, State::PRE_OPERATIONAL, Cause::BootUp),
        ];
        let expected = [row(1, 5, "operational"), row(5, 7, RESET), row(7, 9, "pre-operational")];
        assert_eq!(shown(states, 9, &[]), expected);
    }
}
