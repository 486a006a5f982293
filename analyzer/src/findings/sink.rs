//! The place where rules report findings.

use super::context::Scene;
use super::effect::Rank;
use super::finding::{Exhibit, Finding, Severity};
use super::occurrences::Occurrences;
use super::rule::Metadata;
use super::seen::Evidence;
use crate::network::Bus;
use crate::{Meaning, Multiplexer, NodeId};
use canvass_traces::{ChannelId, Place, Timestamp};
use std::collections::HashMap;

/// All findings so far.
#[derive(Default)]
pub(super) struct Findings {
    list: Vec<Finding>,
    index: HashMap<Key, usize>,
    measures: Vec<u64>,
    /// Number of findings of each rule.
    by_rule: HashMap<&'static str, usize>,
    /// Number of reports left out, by rule.
    omitted: HashMap<&'static str, u64>,
    /// Findings that the current frame made, or made worse.
    pub(super) reported: Vec<Reported>,
}

/// A finding that the current frame made, or made worse.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Reported {
    /// The number of the finding, in the order in which findings were made.
    pub finding: usize,
    /// The id of the finding's rule.
    pub rule: &'static str,
}

/// The properties that make two reports one finding.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    rule: &'static str,
    channel: Option<ChannelId>,
    source: Option<usize>,
    node: Option<NodeId>,
    detail: u64,
}

/// The data of a report, besides its text.
#[derive(Clone, Copy)]
pub struct Report<'e> {
    time: Timestamp,
    until: Option<Timestamp>,
    origin: Option<NodeId>,
    kind: u64,
    object: Option<Multiplexer>,
    node: Option<NodeId>,
    detail: u64,
    measure: u64,
    severity: Option<Severity>,
    lowers: bool,
    rank: Option<Rank>,
    source: Option<usize>,
    place: Option<(Timestamp, Place)>,
    times: u64,
    evidence: [Option<Evidence<'e>>; 4],
}

impl<'e> Report<'e> {
    /// A report of an event at this time.
    pub const fn at(time: Timestamp) -> Self {
        Self {
            time,
            until: None,
            origin: None,
            kind: 0,
            object: None,
            node: None,
            detail: 0,
            measure: 0,
            severity: None,
            lowers: false,
            rank: None,
            source: None,
            place: None,
            times: 1,
            evidence: [None; 4],
        }
    }

    /// Sets the node concerned.
    pub fn node(self, node: impl Into<Option<NodeId>>) -> Self {
        Self { node: node.into(), ..self }
    }

    /// Sets the end of an event that took some time.
    pub const fn until(self, until: Timestamp) -> Self {
        Self { until: Some(until), ..self }
    }

    /// Sets the node that causes the event, if it is not the concerned node.
    pub const fn origin(self, origin: NodeId) -> Self {
        Self { origin: Some(origin), ..self }
    }

    /// Sets the number that distinguishes kinds of findings of one rule, such as an error code.
    pub const fn kind(self, kind: u64) -> Self {
        Self { kind, ..self }
    }

    /// Sets the object concerned, for rules that distinguish findings by object.
    pub fn object(self, object: impl Into<Option<Multiplexer>>) -> Self {
        Self { object: object.into(), ..self }
    }

    /// Distinguishes findings of the same rule and node, such as by object or code.
    pub const fn detail(self, detail: u64) -> Self {
        Self { detail, ..self }
    }

    /// Sets how bad the event is: the finding keeps text and evidence of its worst event.
    pub const fn measure(self, measure: u64) -> Self {
        Self { measure, ..self }
    }

    /// Sets a severity lower than the severity of the rule.
    pub const fn severity(self, severity: Severity) -> Self {
        Self { severity: Some(severity), ..self }
    }

    /// Sets the severity of a reported finding, also if it was higher so far.
    pub const fn lower_to(self, severity: Severity) -> Self {
        Self { severity: Some(severity), lowers: true, ..self }
    }

    /// Sets a rank higher than the rank of the rule.
    pub const fn rank(self, rank: Rank) -> Self {
        Self { rank: Some(rank), ..self }
    }

    /// Sets the source concerned, by its index.
    pub const fn source(self, source: usize) -> Self {
        Self { source: Some(source), ..self }
    }

    /// Sets a place in the capture without a frame.
    pub const fn place(self, time: Timestamp, place: Place) -> Self {
        Self { place: Some((time, place)), ..self }
    }

    /// Replaces the text of a reported finding, without counting another occurrence.
    pub(crate) const fn amend(self) -> Self {
        Self { times: 0, ..self }
    }

    /// Sets the number of occurrences since the last report.
    pub const fn times(self, times: u64) -> Self {
        Self { times, ..self }
    }

    /// Adds a frame as evidence; at most four, in the order of time.
    pub fn evidence(mut self, evidence: impl Into<Option<Evidence<'e>>>) -> Self {
        if let Some(free) = self.evidence.iter_mut().find(|slot| slot.is_none()) {
            *free = evidence.into();
        }
        self
    }
}

/// Takes the reports of one rule.
pub struct Sink<'a> {
    pub(super) findings: &'a mut Findings,
    pub(super) rule: &'static Metadata,
    /// The bus; `None` for rules about whole captures.
    pub(super) bus: Option<(&'a Bus, ChannelId)>,
}

impl<'a> Sink<'a> {
    pub(super) const fn of(findings: &'a mut Findings, rule: &'static Metadata, scene: &Scene<'a>) -> Self {
        Self { findings, rule, bus: Some((scene.bus, scene.channel)) }
    }

    /// Reports an event. `message` is called only for a new finding or a worse occurrence.
    ///
    /// Few frames get here, so this function is kept out of line of the code that every frame runs through.
    #[cold]
    #[inline(never)]
    pub fn report(&mut self, report: Report<'_>, message: impl FnOnce() -> String) {
        let key = Key {
            rule: self.rule.id,
            channel: self.bus.map(|bus| bus.1),
            source: report.source,
            node: report.node,
            detail: report.detail,
        };
        match self.findings.index.get(&key) {
            Some(&at) => self.repeat(at, &report, message),
            None if report.times > 0 => self.add(key, &report, message),
            None => {}
        }
    }

    fn repeat(&mut self, at: usize, report: &Report<'_>, message: impl FnOnce() -> String) {
        let bus = self.bus.map(|bus| bus.0);
        let (Some(finding), Some(worst)) = (self.findings.list.get_mut(at), self.findings.measures.get_mut(at)) else {
            return;
        };
        finding.count += report.times;
        finding.last = finding.last.max(report.time);
        if report.times > 0 {
            let window = (report.time, report.until.unwrap_or(report.time));
            finding.occurrences.add(window.0, window.1);
            if finding.windows.len() < Finding::WINDOWS {
                finding.windows.push(window);
            }
        }
        finding.rank = finding.rank.min(report.rank.unwrap_or(self.rule.rank));
        let severity = report.severity.unwrap_or(self.rule.severity);
        finding.severity = if report.lowers { severity } else { finding.severity.max(severity) };
        if report.measure > *worst || report.times == 0 {
            *worst = report.measure.max(*worst);
            finding.message = message();
            self.findings.reported.push(Reported { finding: at, rule: self.rule.id });
            // The evidence of the first and of the worst occurrence stays.
            finding.evidence.truncate(Finding::EVIDENCE / 2);
            let new: Vec<Exhibit> = exhibits(report, bus).collect();
            for exhibit in new {
                let is_known = finding.evidence.iter().any(|known| same(known, &exhibit));
                if !is_known && finding.evidence.len() < Finding::EVIDENCE {
                    finding.evidence.push(exhibit);
                }
            }
        }
    }

    fn add(&mut self, key: Key, report: &Report<'_>, message: impl FnOnce() -> String) {
        let of_rule = self.findings.by_rule.entry(self.rule.id).or_default();
        if *of_rule >= Findings::MOST_OF_RULE {
            *self.findings.omitted.entry(self.rule.id).or_default() += 1;
            return;
        }
        *of_rule += 1;
        let window = (report.time, report.until.unwrap_or(report.time));
        let mut occurrences = Occurrences::default();
        occurrences.add(window.0, window.1);
        let finding = Finding {
            rule: self.rule,
            severity: report.severity.unwrap_or(self.rule.severity),
            rank: report.rank.unwrap_or(self.rule.rank),
            node: report.node,
            channel: key.channel,
            source: report.source,
            first: report.time,
            last: report.time,
            windows: vec![window],
            occurrences,
            origin: report.origin,
            kind: report.kind,
            object: report.object,
            count: report.times,
            case: None,
            message: message(),
            evidence: exhibits(report, self.bus.map(|bus| bus.0)).collect(),
        };
        self.findings.reported.push(Reported { finding: self.findings.list.len(), rule: self.rule.id });
        self.findings.index.insert(key, self.findings.list.len());
        self.findings.list.push(finding);
        self.findings.measures.push(report.measure);
    }
}

fn same(a: &Exhibit, b: &Exhibit) -> bool {
    (a.time, a.place) == (b.time, b.place) && a.record == b.record
}

fn exhibits(report: &Report<'_>, bus: Option<&Bus>) -> impl Iterator<Item = Exhibit> {
    let frames = report.evidence.into_iter().flatten().map(move |Evidence { record, decoded }| Exhibit {
        time: record.timestamp,
        place: record.place,
        record: Some(record.clone()),
        text: bus.map(|bus| Meaning::new(record, decoded, bus).to_string()).unwrap_or_default(),
    });
    let place = report.place.map(|(time, place)| Exhibit { time, place, record: None, text: String::new() });
    frames.chain(place)
}

impl Findings {
    /// Maximum number of findings of one rule; further ones are counted.
    pub const MOST_OF_RULE: usize = 200;

    /// The findings: the worst first, then by time.
    pub(crate) fn into_sorted(self) -> (Vec<Finding>, Vec<(&'static str, u64)>) {
        let mut list = self.list;
        list.sort_by(|a, b| b.severity.cmp(&a.severity).then(a.first.cmp(&b.first)).then(a.rule.id.cmp(b.rule.id)));
        let mut omitted: Vec<_> = self.omitted.into_iter().collect();
        omitted.sort_unstable();
        (list, omitted)
    }
}
