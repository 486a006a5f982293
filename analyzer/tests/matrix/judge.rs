//! The judge: whether the diagnosis names an incident. It knows what was done, and nothing of the rules.

use super::operator::Incident;
use super::plan::{MS, Plan, SECOND};
use super::play::EPOCH;
use super::sort::Sort;
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::findings::{Diagnosis, Finding, Results, SourceQuality, Thresholds};
use canvass_traces::{Quality, Record};
use std::collections::BTreeSet;
use std::fmt;

/// What was done.
pub struct Truth {
    sort: Sort,
    /// The node; 0 for the bus or all nodes.
    node: u8,
    /// The nodes of all touched frames, and those that a changed identifier or byte names instead.
    nodes: BTreeSet<u8>,
    /// The CAN-IDs of the frames that were changed, and the changed ones.
    can_ids: BTreeSet<u32>,
    /// The CAN-IDs of the frames that follow from them.
    consequences: BTreeSet<u32>,
    since: u64,
    /// The time before `since` whose frames a finding may give as the last that were right.
    slack: u64,
}

/// The verdict on the diagnosis of one incident.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Verdict {
    /// The first story is about the incident.
    First,
    /// The second one is, or a consequence in the first.
    Second,
    /// A later finding is.
    Later,
    /// No finding is; the first finding is about something that was touched, or there is none.
    Missed,
    /// No finding is, and the first one is about something that was not touched.
    Wrong,
}

impl Verdict {
    /// All verdicts, the best first.
    pub const ALL: [Self; 5] = [Self::First, Self::Second, Self::Later, Self::Missed, Self::Wrong];
}

/// The sections of rules that are about a group of sorts.
const SECTIONS: [(&str, &[&str]); 11] = [
    ("nmt", &["nmt", "nodes"]),
    ("error-control", &["nodes", "guarding", "heartbeat"]),
    ("sync", &["sync", "pdo"]),
    ("time", &["time"]),
    ("emcy", &["emcy"]),
    ("pdo", &["pdo"]),
    ("sdo", &["sdo"]),
    ("lss", &["lss"]),
    ("lmt", &["lss", "lmt"]),
    ("node", &["nodes"]),
    ("error", &["capture"]),
];

impl Truth {
    /// What an incident does to a plan.
    pub fn new(plan: &Plan, incident: &Incident, touched: &[usize], sort: Sort) -> Self {
        let (mut can_ids, mut nodes) = (BTreeSet::new(), BTreeSet::from([incident.node]));
        for (place, fate) in &incident.fates {
            let frames = fate.instead.iter().chain(fate.also.iter().map(|(_, frame)| frame));
            for frame in frames.chain([&plan.frames[*place].frame]) {
                can_ids.insert(frame.id().raw());
                nodes.extend(node_of(frame.id().raw()));
                // An NMT command names its node.
                nodes.extend(frame.data().get(1).filter(|_| frame.id().raw() == 0));
            }
        }
        let mut consequences = BTreeSet::new();
        for place in touched {
            nodes.insert(plan.frames[*place].node);
            consequences.insert(plan.frames[*place].frame.id().raw());
        }
        nodes.remove(&0);
        let period = incident.fates.keys().map(|place| plan.frames[*place].period).max().unwrap_or(0);
        let slack = (3 * period).max(SECOND);
        Self { sort, node: incident.node, nodes, can_ids, consequences, since: incident.since, slack }
    }

    /// The service without its side: `sdo` of `sdo-request`.
    fn service(&self) -> &'static str {
        self.sort.group.split('-').next().unwrap_or("")
    }

    fn sections(&self) -> &'static [&'static str] {
        let group = self.service();
        let find = |name: &str| SECTIONS.iter().find(|(group, _)| *group == name).map(|(_, sections)| *sections);
        find(self.sort.group).or_else(|| find(group)).unwrap_or(&[])
    }

    fn is_evident(&self, finding: &Finding, can_ids: &BTreeSet<u32>) -> bool {
        let frames = finding.evidence.iter().filter_map(|exhibit| exhibit.record.as_ref());
        // What happens to a whole node is proven by any of its frames.
        let is_of_node = |id: u32| self.sort == Sort::ALL_OF_A_NODE && id & 0x7F == u32::from(self.node);
        frames.map(|record| record.frame.id().raw()).any(|id| can_ids.contains(&id) || is_of_node(id))
    }

    fn is_in_time(&self, finding: &Finding) -> bool {
        finding.last.nanos() + self.slack >= EPOCH + self.since
    }

    fn is_about_its_node(&self, finding: &Finding) -> bool {
        let mut named = [finding.node, finding.origin].into_iter().flatten().map(NodeId::raw);
        match self.node {
            // A message to all concerns each node.
            0 => true,
            _ => named.any(|node| self.nodes.contains(&node)) || finding.node.is_none(),
        }
    }

    /// Whether the finding names the incident.
    fn is_named_by(&self, finding: &Finding) -> bool {
        let section = finding.rule.id.split('/').next().unwrap_or("");
        let is_evident = self.is_evident(finding, &self.can_ids);
        let is_of_section = match self.node {
            // A message of the bus is named by its own service, not by what follows for a node.
            0 => finding.rule.id.contains(self.service()) || self.service() == "lmt" && section == "lss",
            _ => finding.node.is_some() && self.sections().contains(&section),
        };
        (is_evident || is_of_section) && self.is_about_its_node(finding) && self.is_in_time(finding)
    }

    /// Whether the finding is about something that the incident touched, if only as a consequence.
    fn touches(&self, finding: &Finding) -> bool {
        let mut named = [finding.node, finding.origin].into_iter().flatten().map(NodeId::raw);
        let is_of_nodes = named.any(|node| self.nodes.contains(&node));
        is_of_nodes || self.is_evident(finding, &self.consequences) || self.is_evident(finding, &self.can_ids)
    }
}

impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = self.since as f64 / 1e9;
        write!(f, "{} of node {} from {at:.3} s, CAN-IDs", self.sort.id(), self.node)?;
        self.can_ids.iter().try_for_each(|id| write!(f, " {id:03X}h"))
    }
}

/// The node of a CAN-ID of the predefined connection set.
fn node_of(can_id: u32) -> Option<u8> {
    matches!(can_id, 0x081..0x100 | 0x181..0x780).then_some((can_id & 0x7F) as u8)
}

/// Diagnoses records.
pub fn diagnose(records: &[Record], descriptions: &[(NodeId, KnownDevice)]) -> Results {
    let mut diagnosis = Diagnosis::new(Thresholds::default());
    for (node, device) in descriptions {
        diagnosis.describe(*node, device.clone());
    }
    let mut quality = Quality::default();
    for record in records {
        quality.record(record);
        diagnosis.record(record);
    }
    diagnosis.finish(&[SourceQuality { name: "matrix", quality: &quality }])
}

/// Whether a finding is among those of the network without the incident.
fn was_there(finding: &Finding, before: &[Finding]) -> bool {
    let key = |finding: &Finding| (finding.rule.id, finding.node, finding.origin, finding.object, finding.count);
    // Frames that wait for others come some bits later.
    let is_close = |other: &Finding| finding.first.nanos().abs_diff(other.first.nanos()) < 20 * MS;
    before.iter().any(|other| key(finding) == key(other) && is_close(other))
}

/// The places of the findings, group by group, in the order in which the stories tell them: heads of stories at their
/// numbers, consequences at the next one.
fn places(results: &Results, before: &[Finding]) -> Vec<(usize, usize)> {
    let is_new = |at: &&usize| results.findings.get(**at).is_some_and(|finding| !was_there(finding, before));
    let mut places = Vec::new();
    let mut number = 0;
    for story in &results.stories {
        let heads: Vec<usize> = story.head.iter().filter(is_new).copied().collect();
        let told = story.consequences.iter().flat_map(|consequence| &consequence.findings);
        let consequences: Vec<usize> = told.filter(is_new).copied().collect();
        places.extend(heads.iter().map(|at| (number, *at)));
        places.extend(consequences.iter().map(|at| (number + 1, *at)));
        if !heads.is_empty() || !consequences.is_empty() {
            number += 1;
        }
    }
    places
}

/// The verdict on a diagnosis; `before` has the findings of the network without the incident.
pub fn verdict(results: &Results, before: &[Finding], truth: &Truth) -> Verdict {
    let places = places(results, before);
    let findings = |at: usize| &results.findings[at];
    let named = places.iter().filter(|(_, at)| truth.is_named_by(findings(*at))).map(|(number, _)| *number).min();
    match named {
        Some(0) => Verdict::First,
        Some(1) => Verdict::Second,
        Some(_) => Verdict::Later,
        None if places.first().is_some_and(|(_, at)| !truth.touches(findings(*at))) => Verdict::Wrong,
        None => Verdict::Missed,
    }
}

/// The findings in words, in their order.
pub fn shown(results: &Results, before: &[Finding]) -> Vec<String> {
    places(results, before).iter().map(|(number, at)| show(*number, &results.findings[*at])).collect()
}

/// A finding in words.
pub fn show(number: usize, finding: &Finding) -> String {
    let node = finding.node.map_or("bus".to_owned(), |node| format!("node {}", node.raw()));
    let at = finding.first.nanos().saturating_sub(EPOCH) as f64 / 1e9;
    format!(
        "{number}: {at:.3} s {} {:?} {node} x{}: {}",
        finding.rule.id, finding.severity, finding.count, finding.message
    )
}
