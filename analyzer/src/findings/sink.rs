//! Where rules report what they find.

use super::context::Scene;
use super::finding::{Exhibit, Finding, Severity};
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
    /// How many findings of each rule there are.
    by_rule: HashMap<&'static str, usize>,
    /// How many were left out, by rule.
    omitted: HashMap<&'static str, u64>,
    /// Those whose words and evidence are of the frame that is being looked at.
    pub(super) reported: Vec<Reported>,
}

/// A finding that has just been made, or was never worse.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Reported {
    /// Which one, in the order in which they were made.
    pub finding: usize,
    /// The id of its rule.
    pub rule: &'static str,
}

/// What makes two reports the same finding.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    rule: &'static str,
    channel: Option<ChannelId>,
    source: Option<usize>,
    node: Option<NodeId>,
    detail: u64,
}

/// What a rule reports, beside its words.
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
    source: Option<usize>,
    place: Option<(Timestamp, Place)>,
    times: u64,
    evidence: [Option<Evidence<'e>>; 4],
}

impl<'e> Report<'e> {
    /// Something that was seen at that time.
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
            source: None,
            place: None,
            times: 1,
            evidence: [None; 4],
        }
    }

    /// The node that it is about.
    pub fn node(self, node: impl Into<Option<NodeId>>) -> Self {
        Self { node: node.into(), ..self }
    }

    /// When it was over, where it took some time.
    pub const fn until(self, until: Timestamp) -> Self {
        Self { until: Some(until), ..self }
    }

    /// The node that it comes from, where that is another one than it is about.
    pub const fn origin(self, origin: NodeId) -> Self {
        Self { origin: Some(origin), ..self }
    }

    /// What tells kinds of the same rule apart that are worth telling apart, such as a code.
    pub const fn kind(self, kind: u64) -> Self {
        Self { kind, ..self }
    }

    /// The object that it is about, where findings are distinguished by that.
    pub fn object(self, object: impl Into<Option<Multiplexer>>) -> Self {
        Self { object: object.into(), ..self }
    }

    /// Tells findings of the same rule and node apart, such as by object or code.
    pub const fn detail(self, detail: u64) -> Self {
        Self { detail, ..self }
    }

    /// How bad it is: of a finding that repeats, words and evidence are those of the worst time.
    pub const fn measure(self, measure: u64) -> Self {
        Self { measure, ..self }
    }

    /// Less severe than the rule.
    pub const fn severity(self, severity: Severity) -> Self {
        Self { severity: Some(severity), ..self }
    }

    /// A whole capture, by its place among those read.
    pub const fn source(self, source: usize) -> Self {
        Self { source: Some(source), ..self }
    }

    /// A place in the capture at which there is no frame to show.
    pub const fn place(self, time: Timestamp, place: Place) -> Self {
        Self { place: Some((time, place)), ..self }
    }

    /// Adds words to a finding that was reported; it does not happen once more.
    pub const fn amend(self) -> Self {
        Self { times: 0, ..self }
    }

    /// Something that has happened so often since it was last reported.
    pub const fn times(self, times: u64) -> Self {
        Self { times, ..self }
    }

    /// A frame that proves it; at most four, in the order of time.
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
    /// `None` for rules about whole captures.
    pub(super) bus: Option<(&'a Bus, ChannelId)>,
}

impl<'a> Sink<'a> {
    pub(super) const fn of(findings: &'a mut Findings, rule: &'static Metadata, scene: &Scene<'a>) -> Self {
        Self { findings, rule, bus: Some((scene.bus, scene.channel)) }
    }

    /// Reports that something was found. The words are asked for only if they are new or the worst so far.
    ///
    /// Nearly no frame gets here: what leads here is to lie apart from what every frame runs through.
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
        if finding.windows.len() < Finding::WINDOWS && report.times > 0 {
            finding.windows.push((report.time, report.until.unwrap_or(report.time)));
        }
        finding.severity = finding.severity.max(report.severity.unwrap_or(self.rule.severity));
        if report.measure > *worst || report.times == 0 {
            *worst = report.measure.max(*worst);
            finding.message = message();
            self.findings.reported.push(Reported { finding: at, rule: self.rule.id });
            // The first time stays as evidence, and the worst.
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
        let finding = Finding {
            rule: self.rule,
            severity: report.severity.unwrap_or(self.rule.severity),
            node: report.node,
            channel: key.channel,
            source: report.source,
            first: report.time,
            last: report.time,
            windows: vec![(report.time, report.until.unwrap_or(report.time))],
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
    /// How many different findings of one rule are kept; more are counted.
    pub const MOST_OF_RULE: usize = 200;

    /// The findings: the worst first, then by time.
    pub fn into_sorted(self) -> (Vec<Finding>, Vec<(&'static str, u64)>) {
        let mut list = self.list;
        list.sort_by(|a, b| b.severity.cmp(&a.severity).then(a.first.cmp(&b.first)).then(a.rule.id.cmp(b.rule.id)));
        let mut omitted: Vec<_> = self.omitted.into_iter().collect();
        omitted.sort_unstable();
        (list, omitted)
    }
}
