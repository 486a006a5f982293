//! The diagnosis as JSON: [`DiagnoseResult`].

use super::Diagnosed;
use crate::results::diagnose::{
    Bus, ByService, CaseName, Consequence, DiagnoseResult, Emcy, ErrorEpisode, Exhibit, Finding, Load, LoadOverTime,
    Node, Peak, ResponseTimes, SdoFigures, StateChange, Story, TestCase,
};
use crate::results::{self, Contract, Device};
use crate::{provenance, quality};
use canvass_analyzer::findings::{self, Severity};
use canvass_analyzer::statistics::{self, BusStatistics, ErrorEnd, Histogram, NodeStatistics};
use canvass_analyzer::{NodeId, Service};
use canvass_traces::hex;
use serde::ser::{Serialize, Serializer};
use std::cell::Cell;
use std::io::{self, Write};

/// Writes the document, indented, with a line end.
///
/// # Errors
/// The errors of `out`.
pub fn render(diagnosed: &Diagnosed<'_>, out: &mut dyn Write) -> io::Result<()> {
    let results = diagnosed.results;
    let nodes = results.buses.iter().flat_map(|(id, bus)| {
        let channel = diagnosed.channel(*id);
        bus.nodes.iter().map(move |(id, figures)| node(*id, &channel, figures, bus))
    });
    let severity = |severity: Severity| (severity.name().into(), diagnosed.count(severity));
    // Findings and nodes are written one by one. All of them as JSON values would take several times the memory of the
    // originals.
    let result: DiagnoseResult<_, _> = DiagnoseResult {
        buses: results.buses.iter().map(|(id, figures)| bus(&diagnosed.channel(*id), figures)).collect(),
        counts: diagnosed.by_service().map(|(service, count)| (service.name().into(), count)).collect(),
        findings: rows(results.findings.iter().map(|found| finding(diagnosed, found))),
        findings_omitted: results.omitted.iter().map(|(rule, count)| ((*rule).into(), *count)).collect(),
        frames: diagnosed.frames(),
        frames_of_unwatched_channels: results.unwatched,
        nodes: rows(nodes),
        provenance: provenance::json(diagnosed.provenance),
        quality: quality::json(diagnosed.captures, diagnosed.channels),
        schema: <DiagnoseResult>::SCHEMA.into(),
        stories: results.stories.iter().map(story).collect(),
        summary: Severity::ALL.into_iter().map(severity).collect(),
    };
    results::write(&result, out)
}

/// An array whose values are made while it is written. It can be written once.
struct Rows<I>(Cell<Option<I>>);

fn rows<I: Iterator<Item: Serialize>>(values: I) -> Rows<I> {
    Rows(Cell::new(Some(values)))
}

impl<I: Iterator<Item: Serialize>> Serialize for Rows<I> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.take().into_iter().flatten())
    }
}

/// The values of the services that were seen.
fn of<T>(frames: &[u64; Service::ALL.len()], of: impl Fn(u64) -> T) -> ByService<T> {
    let seen = Service::ALL.into_iter().zip(*frames).filter(|(_, count)| *count > 0);
    seen.map(|(service, count)| (service.name().into(), of(count))).collect()
}

fn story(story: &findings::Story) -> Story {
    let consequence = |told: &findings::Consequence| Consequence { findings: told.findings.clone(), of: told.of };
    Story { consequences: story.consequences.iter().map(consequence).collect(), findings: story.head.clone() }
}

fn finding(diagnosed: &Diagnosed<'_>, finding: &findings::Finding) -> Finding {
    let source = finding.source.and_then(|at| diagnosed.captures.get(at));
    Finding {
        advice: finding.rule.advice.into(),
        case: finding.case.as_ref().map(case_name),
        channel: finding.channel.map(|id| diagnosed.channel(id)),
        count: finding.count,
        evidence: evidence(diagnosed, finding),
        message: finding.message.clone(),
        node: finding.node.map(NodeId::raw),
        object: finding.object.map(|object| object.to_string()),
        origin: finding.origin.map(NodeId::raw),
        rule: finding.rule.id.into(),
        severity: finding.severity.name().into(),
        source: source.map(|capture| capture.name.to_owned()),
        t: finding.first.nanos(),
        t_last: finding.last.nanos(),
        title: finding.rule.title.into(),
    }
}

/// The frames that prove a finding.
pub fn evidence(diagnosed: &Diagnosed<'_>, finding: &findings::Finding) -> Vec<Exhibit> {
    finding.evidence.iter().map(|shown| exhibit(diagnosed, shown)).collect()
}

fn exhibit(diagnosed: &Diagnosed<'_>, exhibit: &findings::Exhibit) -> Exhibit {
    let record = exhibit.record.as_ref();
    let is = |holds: fn(&canvass_traces::Frame) -> bool| record.filter(|record| holds(&record.frame)).map(|_| true);
    Exhibit {
        channel: record.map(|record| diagnosed.channel(record.channel)),
        data: record.map(|record| hex::compact(record.data()).to_string()),
        error: is(|frame| frame.is_error()),
        extended: is(|frame| frame.id().is_extended() && !frame.is_error()),
        id: record.map(|record| record.frame.id().raw()),
        number: exhibit.place.number,
        offset: exhibit.place.offset,
        remote: is(|frame| frame.is_remote()),
        t: exhibit.time.nanos(),
        text: record.map(|_| exhibit.text.clone()),
    }
}

fn node(id: NodeId, channel: &str, node: &NodeStatistics, bus: &BusStatistics) -> Node {
    Node {
        bits: node.bits,
        boot_ups: node.boot_ups,
        channel: channel.to_owned(),
        counts: of(&node.frames, |count| count),
        emcy: node.emcy.iter().map(emcy).collect(),
        errors: node.errors.iter().map(error).collect(),
        errors_omitted: node.errors_omitted,
        first_t: node.first.nanos(),
        frames: node.total(),
        identity: Device::from(&provenance::identity_of(&node.identity)),
        last_t: node.last.nanos(),
        load_percent: bus.share_of_load(node.bits),
        node: id.raw(),
        peak: peak(&node.peak, bus),
        present: node.present,
        rates: of(&node.frames, |count| bus.rate(count)),
        sdo: SdoFigures {
            aborted: node.aborted,
            completed: node.completed,
            response_ns: response_times(&node.responses),
        },
        states: node.states.iter().map(state).collect(),
        states_omitted: node.states_omitted,
    }
}

fn state(change: &statistics::StateChange) -> StateChange {
    let (cause, state) = (change.cause.name().into(), change.state.to_string());
    StateChange { cause, state, t: change.time.nanos() }
}

fn emcy(row: &statistics::EmcyCount) -> Emcy {
    Emcy { code: row.code.0, count: row.count, first_t: row.first.nanos(), last_t: row.last.nanos() }
}

fn error(error: &statistics::ErrorEpisode) -> ErrorEpisode {
    let end = error.ended.map(|ended| ended.0);
    let ended = |by: ErrorEnd| match by {
        ErrorEnd::Reported => "reported".into(),
        ErrorEnd::BootUp => "boot-up".into(),
    };
    ErrorEpisode {
        code: error.code.0,
        duration_ns: end.map(|end| end.since(error.raised).nanos()),
        end: error.ended.map(|(_, by)| ended(by)),
        register: error.register.map(|register| register.0),
        t: error.raised.nanos(),
        t_end: end.map(|end| end.nanos()),
    }
}

fn peak(peak: &statistics::Peak, bus: &BusStatistics) -> Option<Peak> {
    let (time, percent) = peak.percent(bus.bit_rate?)?;
    Some(Peak { percent, t: time.nanos() })
}

/// The bus load by service.
fn loads(bus: &BusStatistics) -> ByService<Load> {
    let services = Service::ALL.into_iter().zip(bus.bits).zip(&bus.peaks).filter(|((_, bits), _)| *bits > 0);
    let load = |bits, fullest| Load { bits, peak: peak(fullest, bus), percent: bus.share_of_load(bits) };
    services.map(|((service, bits), fullest)| (service.name().into(), load(bits, fullest))).collect()
}

fn response_times(times: &Histogram) -> ResponseTimes {
    let nanos = |percent| times.quantile(percent).map(|time| time.nanos());
    ResponseTimes {
        count: times.count(),
        max: times.max().map(|time| time.nanos()),
        min: times.min().map(|time| time.nanos()),
        p50: nanos(50),
        p95: nanos(95),
        p99: nanos(99),
    }
}

fn bus(channel: &str, bus: &BusStatistics) -> Bus {
    Bus {
        bit_rate: bus.bit_rate,
        bit_rate_inferred: bus.is_inferred,
        bits: bus.bits.iter().sum(),
        channel: channel.to_owned(),
        copies: bus.copies,
        counts: of(&bus.frames, |count| count),
        first_t: bus.first.nanos(),
        frames: bus.total(),
        last_t: bus.last.nanos(),
        load_by_service: loads(bus),
        load_over_time: LoadOverTime {
            bits: bus.load.bins().to_vec(),
            start_t: bus.load.start().map(|start| start.nanos()),
            width_ns: bus.load.width().nanos(),
        },
        load_percent: bus.mean_load(),
        peak: peak(&bus.peak, bus),
        rates: of(&bus.frames, |count| bus.rate(count)),
        test_run: bus.test_run.cases.iter().map(case).collect(),
        test_run_omitted: bus.test_run.omitted,
    }
}

fn case(told: &statistics::TestCase) -> TestCase {
    let CaseName { case, group, id } = case_name(&told.name);
    TestCase {
        case,
        frames: told.frames,
        group,
        id,
        number: told.place.number,
        number_last: told.last_place.number,
        t: told.begin.nanos(),
        t_last: told.end.nanos(),
        verdict: told.verdict.as_deref().map(str::to_owned),
    }
}

fn case_name(name: &statistics::CaseName) -> CaseName {
    match name {
        statistics::CaseName::Id(id) => CaseName { case: None, group: None, id: Some(id.to_string()) },
        statistics::CaseName::Numbered { group, case } => CaseName { case: Some(*case), group: Some(*group), id: None },
    }
}
