//! Groups of findings of one kind: of one rule and one node, or of several nodes if their findings are one event.

use crate::NodeId;
use crate::findings::effect::Rank;
use crate::findings::finding::{Finding, Severity};
use crate::findings::registry::is_of_profile;
use crate::findings::rule::Metadata;
use canvass_traces::{ChannelId, Duration, Timestamp};

/// Findings of one kind.
pub struct Group<'a> {
    /// The rule.
    pub rule: &'static Metadata,
    /// The number that distinguishes kinds of findings of one rule, such as an abort code.
    pub kind: u64,
    pub channel: Option<ChannelId>,
    pub severity: Severity,
    /// The nodes, each once.
    pub nodes: Vec<NodeId>,
    pub findings: Vec<&'a Finding>,
    /// The indexes of the group's findings.
    pub places: Vec<usize>,
}

/// Events of several nodes within this time are one event.
const TOGETHER: Duration = Duration::from_secs(2);

impl Group<'_> {
    /// The earliest first occurrence.
    pub fn first(&self) -> Timestamp {
        self.findings.iter().map(|finding| finding.first).min().unwrap_or_default()
    }

    /// The latest occurrence.
    pub fn last(&self) -> Timestamp {
        self.findings.iter().map(|finding| finding.last).max().unwrap_or_default()
    }

    /// The rank of the gravest finding.
    pub fn rank(&self) -> Rank {
        self.findings.iter().map(|finding| finding.rank).min().unwrap_or(self.rule.rank)
    }

    /// Whether an occurrence covers this time, or ended up to `settle` before it, or begins up to `early` after it.
    pub fn covers(&self, time: Timestamp, early: Duration, settle: Duration) -> bool {
        let mut spans = self.findings.iter().flat_map(|finding| finding.occurrences.spans());
        spans.any(|(begin, end)| time + early >= begin && time <= end + settle)
    }

    /// Whether the time is between the first and the last occurrence, or up to `settle` outside.
    pub fn spans(&self, time: Timestamp, settle: Duration) -> bool {
        time + settle >= self.first() && time <= self.last() + settle
    }

    /// Whether one of the findings concerns this node.
    pub fn has(&self, node: Option<NodeId>) -> bool {
        node.is_some_and(|node| self.nodes.contains(&node))
    }

    fn takes(&self, finding: &Finding) -> bool {
        let same = (self.rule.id, self.kind, self.channel, self.severity)
            == (finding.rule.id, finding.kind, finding.channel, finding.severity);
        let own = match finding.node {
            None => self.nodes.is_empty(),
            Some(node) => self.nodes.contains(&node) || self.is_together(finding),
        };
        same && own && finding.source == self.findings.first().and_then(|first| first.source)
    }

    /// Whether a finding of another node belongs to the group: it is the same event or, if times prove nothing, the
    /// same fault.
    fn is_together(&self, finding: &Finding) -> bool {
        let apart = self.first().since(finding.first).max(finding.first.since(self.first()));
        match self.rule.id.split('/').next() {
            Some("emcy") => false,
            Some("nodes") => apart <= TOGETHER,
            _ => !is_of_profile(self.rule.id),
        }
    }
}

/// All findings in groups.
pub fn of(findings: &[Finding]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for (place, finding) in findings.iter().enumerate() {
        let group = match groups.iter_mut().position(|group| group.takes(finding)) {
            Some(at) => &mut groups[at],
            None => {
                groups.push(Group {
                    rule: finding.rule,
                    kind: finding.kind,
                    channel: finding.channel,
                    severity: finding.severity,
                    nodes: Vec::new(),
                    findings: Vec::new(),
                    places: Vec::new(),
                });
                let last = groups.len() - 1;
                &mut groups[last]
            }
        };
        if let Some(node) = finding.node.filter(|node| !group.nodes.contains(node)) {
            group.nodes.push(node);
        }
        group.findings.push(finding);
        group.places.push(place);
    }
    groups
}
