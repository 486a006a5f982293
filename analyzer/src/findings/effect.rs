//! Effects of a rule's findings, as its `#[rule]` states them.

use canvass_traces::Duration;

/// Time limit for an effect after the end of its cause.
pub const SETTLE: Duration = Duration::from_secs(5);
/// Time limit for the reactions of other nodes.
pub const SOON: Duration = Duration::from_secs(2);

/// EMCY codes of a node that misses another: life guarding or heartbeat, and communication.
pub const MONITORING: &[u64] = &[0x8130, 0x8100];

/// The consequence of a rule's findings for a machine; higher ranks are reported first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Rank {
    /// A node is lost, its monitoring or SYNC is gone, the bus is off, or two nodes have one node-ID.
    Loss,
    /// A node restarts.
    Restart,
    /// A wrong sender, a wrong amount of messages, or wrong monitoring.
    Participants,
    /// A device reports an error, or receives unusable messages.
    DeviceError,
    /// A node is in a wrong or unknown state, or the bus has errors.
    State,
    /// Process data are missing, late or sent in the wrong state; or an SDO server does not answer in time.
    ProcessData,
    /// A transfer is late or fails.
    Transfer,
    /// A finding that by itself stops no machine.
    Detail,
}

/// Findings of other rules that may follow from a rule's findings, and when.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// The ids of these rules, or families that end in `/`; empty for all rules that no other effect of the same rule
    /// names.
    pub rules: &'static [&'static str],
    /// The nodes of the following findings.
    pub nodes: Nodes,
    /// The kinds of the following findings.
    pub kinds: Kinds,
    /// The times at which they begin.
    pub time: Time,
    /// Whether only less grave findings follow.
    pub less_grave: bool,
}

/// The node of a following finding, relative to the node of its cause.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Nodes {
    /// Any node.
    Any,
    /// The same node.
    Same,
    /// Another node.
    Other,
    /// Any node, if the finding originates in the node of its cause.
    Origin,
}

/// The kind of a finding that follows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kinds {
    /// Any kind.
    Any,
    /// The kind of its cause.
    Same,
    /// One of these kinds. The kind of an EMCY finding is its error code.
    These(&'static [u64]),
}

/// The time at which a following finding begins.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Time {
    /// At any time.
    Any,
    /// Never: these findings do not follow.
    Never,
    /// During the cause, up to the first time before it, or up to the second time after it.
    During(Duration, Duration),
    /// Between the first and the last time that the cause was seen, or up to this time before or after.
    Spanning(Duration),
}

impl Effect {
    /// The findings of these rules follow.
    pub const fn on(rules: &'static [&'static str]) -> Self {
        Self { rules, nodes: Nodes::Any, kinds: Kinds::Any, time: Time::Any, less_grave: false }
    }

    /// The findings of all rules that no other effect of the same rule names follow.
    pub(crate) const fn on_the_rest() -> Self {
        Self::on(&[])
    }

    /// The findings of these rules do not follow.
    pub(crate) const fn never_on(rules: &'static [&'static str]) -> Self {
        Self { time: Time::Never, ..Self::on(rules) }
    }

    /// Limits the effect to findings of the same node.
    pub(crate) const fn of_same_node(self) -> Self {
        Self { nodes: Nodes::Same, ..self }
    }

    /// Limits the effect to findings of other nodes.
    pub(crate) const fn of_others(self) -> Self {
        Self { nodes: Nodes::Other, ..self }
    }

    /// Limits the effect to findings that originate in the node of the cause.
    pub(crate) const fn of_origin(self) -> Self {
        Self { nodes: Nodes::Origin, ..self }
    }

    /// Limits the effect to findings of the same kind.
    pub(crate) const fn of_same_kind(self) -> Self {
        Self { kinds: Kinds::Same, ..self }
    }

    /// Limits the effect to findings with these EMCY codes.
    pub(crate) const fn with_codes(self, codes: &'static [u64]) -> Self {
        Self { kinds: Kinds::These(codes), ..self }
    }

    /// Limits the effect to findings that are less grave than the cause.
    pub(crate) const fn if_less_grave(self) -> Self {
        Self { less_grave: true, ..self }
    }

    /// Limits the effect to findings that begin during the cause, up to `early` before or `settle` after it.
    pub const fn during(self, early: Duration, settle: Duration) -> Self {
        Self { time: Time::During(early, settle), ..self }
    }

    /// Limits the effect to findings that begin between the first and the last time that the cause was seen, up to
    /// `settle` before or after.
    pub(crate) const fn spanning(self, settle: Duration) -> Self {
        Self { time: Time::Spanning(settle), ..self }
    }

    /// Whether the effect names the rule.
    pub fn names(&self, id: &str) -> bool {
        self.rules.iter().any(|name| if name.ends_with('/') { id.starts_with(name) } else { id == *name })
    }
}
