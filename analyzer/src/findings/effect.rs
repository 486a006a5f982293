//! What follows from the findings of a rule, as its `#[rule]` states it.

use canvass_traces::Duration;

/// What follows comes within this time after the end of its cause.
pub const SETTLE: Duration = Duration::from_secs(5);
/// What others do about it comes within this time.
pub const SOON: Duration = Duration::from_secs(2);

/// The codes of EMCY by which a node says that it misses another: life guarding or heartbeat, and communication.
pub const MONITORING: &[u64] = &[0x8130, 0x8100];

/// How grave the findings of a rule are for a machine: what is told first comes first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Rank {
    /// A node is lost, its monitoring or SYNC is gone, the bus is off, or two nodes have one node-ID.
    Loss,
    /// A node restarts.
    Restart,
    /// Something is wrong with who sends what, or how much, or who watches whom.
    Participants,
    /// A device reports an error, or receives what it can't use.
    DeviceError,
    /// A node is not in the state that it should be in, or nobody can tell; or the bus has errors.
    State,
    /// Process data are missing, late or sent in the wrong state; or an SDO server does not answer in time.
    ProcessData,
    /// A transfer is late or fails.
    Transfer,
    /// What alone stops no machine.
    Detail,
}

/// Findings of other rules that may follow from those of a rule, and when they do.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// The ids of these rules, or families that end in `/`; empty: all that no other effect of the same rule names.
    pub rules: &'static [&'static str],
    /// Whose findings they are.
    pub nodes: Nodes,
    /// Of which kind they are.
    pub kinds: Kinds,
    /// When they begin.
    pub time: Time,
    /// Only what is less grave than the cause follows.
    pub less_grave: bool,
}

/// The node of a finding that follows, beside the node of its cause.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Nodes {
    /// Any.
    Any,
    /// The same.
    Same,
    /// Another.
    Other,
    /// The finding originates in the node of its cause.
    Origin,
}

/// The kind of a finding that follows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kinds {
    /// Any.
    Any,
    /// That of its cause.
    Same,
    /// One of these, such as codes of EMCY.
    These(&'static [u64]),
}

/// When a finding that follows begins.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Time {
    /// At any time.
    Any,
    /// Never: these findings do not follow.
    Never,
    /// While the cause is there, up to the first time before that, or up to the second time after it.
    During(Duration, Duration),
    /// Between the first and the last time that the cause was seen, or up to this time before or after that.
    Spanning(Duration),
}

impl Effect {
    /// Findings of these rules.
    pub const fn on(rules: &'static [&'static str]) -> Self {
        Self { rules, nodes: Nodes::Any, kinds: Kinds::Any, time: Time::Any, less_grave: false }
    }

    /// Findings of all rules that no other effect of the same rule names.
    pub const fn on_the_rest() -> Self {
        Self::on(&[])
    }

    /// Findings of these rules do not follow.
    pub const fn never_on(rules: &'static [&'static str]) -> Self {
        Self { time: Time::Never, ..Self::on(rules) }
    }

    /// Those of the same node.
    pub const fn of_same_node(self) -> Self {
        Self { nodes: Nodes::Same, ..self }
    }

    /// Those of other nodes.
    pub const fn of_others(self) -> Self {
        Self { nodes: Nodes::Other, ..self }
    }

    /// Those that originate in the node of the cause.
    pub const fn of_origin(self) -> Self {
        Self { nodes: Nodes::Origin, ..self }
    }

    /// Those of the same kind.
    pub const fn of_same_kind(self) -> Self {
        Self { kinds: Kinds::Same, ..self }
    }

    /// Those with one of these codes of EMCY.
    pub const fn with_codes(self, codes: &'static [u64]) -> Self {
        Self { kinds: Kinds::These(codes), ..self }
    }

    /// Those that are less grave than the cause.
    pub const fn if_less_grave(self) -> Self {
        Self { less_grave: true, ..self }
    }

    /// Those that begin while the cause is there, `early` before it or `settle` after it.
    pub const fn during(self, early: Duration, settle: Duration) -> Self {
        Self { time: Time::During(early, settle), ..self }
    }

    /// Those that begin between the first and the last time that the cause was seen, or `settle` before or after that.
    pub const fn spanning(self, settle: Duration) -> Self {
        Self { time: Time::Spanning(settle), ..self }
    }

    /// Whether it names the rule.
    pub fn names(&self, id: &str) -> bool {
        self.rules.iter().any(|name| if name.ends_with('/') { id.starts_with(name) } else { id == *name })
    }
}
