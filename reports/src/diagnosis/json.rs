//! The diagnosis as JSON: `"schema": "canvass/diagnose/1"`.
//!
//! Contract: numbers are numbers, times are integer nanoseconds as the capture counts them. New keys may be added; none
//! changes its meaning within a version.

use super::Diagnosed;
use crate::escape::JsonText;
use crate::{provenance, quality};
use canvass_analyzer::findings::{Consequence, Exhibit, Finding, Severity, Story};
use canvass_analyzer::statistics::{
    BusStatistics, CaseName, ErrorEnd, ErrorEpisode, Histogram, NodeStatistics, Peak, TestCase,
};
use canvass_analyzer::{NodeId, Service};
use canvass_traces::hex;
use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::{Map, Value, json};
use std::cell::Cell;
use std::io::{self, Write};

/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/diagnose/1";

/// Writes the document, indented, with a line end.
///
/// # Errors
/// What `out` gives.
pub fn render(diagnosed: &Diagnosed<'_>, out: &mut dyn Write) -> io::Result<()> {
    let results = diagnosed.results;
    let severities = Severity::ALL.map(|severity| (severity.name().to_owned(), json!(diagnosed.count(severity))));
    let nodes = results.buses.iter().flat_map(|(id, bus)| {
        let channel = diagnosed.channel(*id);
        bus.nodes.iter().map(move |(id, figures)| node(*id, &channel, figures, bus))
    });
    let omitted = results.omitted.iter().map(|(rule, count)| ((*rule).to_owned(), json!(count)));
    let buses = results.buses.iter().map(|(id, figures)| bus(&diagnosed.channel(*id), figures));
    // One finding and node after the other: all of them as values would take several times the memory of what they are of.
    let mut json = serde_json::Serializer::pretty(JsonText(&mut *out));
    let mut document = json.serialize_map(None)?;
    document.serialize_entry("buses", &rows(buses))?;
    document.serialize_entry("counts", &counts(diagnosed.by_service()))?;
    document.serialize_entry("findings", &rows(results.findings.iter().map(|found| finding(diagnosed, found))))?;
    document.serialize_entry("findings_omitted", &Value::Object(omitted.collect()))?;
    document.serialize_entry("frames", &diagnosed.frames())?;
    document.serialize_entry("frames_of_unwatched_channels", &results.unwatched)?;
    document.serialize_entry("nodes", &rows(nodes))?;
    document.serialize_entry("provenance", &provenance::json(diagnosed.provenance))?;
    document.serialize_entry("quality", &quality::json(diagnosed.captures, diagnosed.channels))?;
    document.serialize_entry("schema", SCHEMA)?;
    document.serialize_entry("stories", &rows(results.stories.iter().map(story)))?;
    document.serialize_entry("summary", &Value::Object(severities.into_iter().collect()))?;
    document.end()?;
    out.write_all(b"\n")
}

/// An array whose values are made while it is written, once.
struct Rows<I>(Cell<Option<I>>);

fn rows<I: Iterator<Item = Value>>(values: I) -> Rows<I> {
    Rows(Cell::new(Some(values)))
}

impl<I: Iterator<Item = Value>> Serialize for Rows<I> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.take().into_iter().flatten())
    }
}

fn counts(by_service: impl Iterator<Item = (Service, u64)>) -> Value {
    Value::Object(by_service.map(|(service, count)| (service.name().to_owned(), json!(count))).collect())
}

fn of(frames: &[u64; Service::ALL.len()]) -> Value {
    let seen = Service::ALL.into_iter().zip(*frames).filter(|(_, count)| *count > 0);
    counts(seen)
}

/// Places among the findings, from 0.
fn story(story: &Story) -> Value {
    let consequence = |consequence: &Consequence| json!({ "findings": consequence.findings, "of": consequence.of });
    json!({
        "findings": story.head,
        "consequences": story.consequences.iter().map(consequence).collect::<Vec<_>>(),
    })
}

fn finding(diagnosed: &Diagnosed<'_>, finding: &Finding) -> Value {
    let source = finding.source.and_then(|at| diagnosed.captures.get(at)).map(|capture| capture.name);
    json!({
        "rule": finding.rule.id,
        "severity": finding.severity.name(),
        "t": finding.first.nanos(),
        "t_last": finding.last.nanos(),
        "count": finding.count,
        "node": finding.node.map(NodeId::raw),
        "object": finding.object.map(|object| object.to_string()),
        "origin": finding.origin.map(NodeId::raw),
        "case": finding.case.as_ref().map(|name| Value::Object(case_name(name))),
        "channel": finding.channel.map(|id| diagnosed.channel(id)),
        "source": source,
        "title": finding.rule.title,
        "message": finding.message,
        "advice": finding.rule.advice,
        "evidence": evidence(diagnosed, finding),
    })
}

/// The frames that prove a finding, an object each.
pub fn evidence(diagnosed: &Diagnosed<'_>, finding: &Finding) -> Value {
    finding.evidence.iter().map(|shown| exhibit(diagnosed, shown)).collect()
}

fn exhibit(diagnosed: &Diagnosed<'_>, exhibit: &Exhibit) -> Value {
    let mut object = Map::new();
    object.insert("t".into(), json!(exhibit.time.nanos()));
    object.insert("number".into(), json!(exhibit.place.number));
    object.insert("offset".into(), json!(exhibit.place.offset));
    if let Some(record) = &exhibit.record {
        let data = hex::compact(record.data()).to_string();
        object.insert("channel".into(), json!(diagnosed.channel(record.channel)));
        object.insert("id".into(), json!(record.frame.id().raw()));
        object.insert("data".into(), json!(data));
        let kinds = [
            ("extended", record.frame.id().is_extended() && !record.frame.is_error()),
            ("remote", record.frame.is_remote()),
            ("error", record.frame.is_error()),
        ];
        for (name, _) in kinds.into_iter().filter(|kind| kind.1) {
            object.insert(name.into(), json!(true));
        }
        object.insert("text".into(), json!(exhibit.text));
    }
    Value::Object(object)
}

fn node(id: NodeId, channel: &str, node: &NodeStatistics, bus: &BusStatistics) -> Value {
    let identity = &node.identity;
    let state = |change: &canvass_analyzer::statistics::StateChange| json!({ "t": change.time.nanos(), "state": change.state.to_string(), "cause": change.cause.name() });
    json!({
        "node": id.raw(),
        "channel": channel,
        "present": node.present,
        "frames": node.total(),
        "counts": of(&node.frames),
        "rates": rates(&node.frames, bus),
        "bits": node.bits,
        "load_percent": bus.share_of_load(node.bits),
        "peak": peak(&node.peak, bus),
        "first_t": node.first.nanos(),
        "last_t": node.last.nanos(),
        "boot_ups": node.boot_ups,
        "identity": {
            "device_type": identity.device_type,
            "vendor_id": identity.numbers[0],
            "product_code": identity.numbers[1],
            "revision_number": identity.numbers[2],
            "serial_number": identity.numbers[3],
            "name": identity.names[0],
            "hardware_version": identity.names[1],
            "software_version": identity.names[2],
        },
        "states": node.states.iter().map(state).collect::<Vec<_>>(),
        "states_omitted": node.states_omitted,
        "sdo": {
            "completed": node.completed,
            "aborted": node.aborted,
            "response_ns": response_times(&node.responses),
        },
        "emcy": node.emcy.iter().map(|row| json!({
            "code": row.code.0,
            "count": row.count,
            "first_t": row.first.nanos(),
            "last_t": row.last.nanos(),
        })).collect::<Vec<_>>(),
        "errors": node.errors.iter().map(error).collect::<Vec<_>>(),
        "errors_omitted": node.errors_omitted,
    })
}

/// An error from its first EMCY to its end.
fn error(error: &ErrorEpisode) -> Value {
    let end = error.ended.map(|ended| ended.0);
    json!({
        "code": error.code.0,
        "register": error.register.map(|register| register.0),
        "t": error.raised.nanos(),
        "t_end": end.map(|end| end.nanos()),
        "duration_ns": end.map(|end| end.since(error.raised).nanos()),
        "end": error.ended.map(|ended| match ended.1 {
            ErrorEnd::Reported => "reported",
            ErrorEnd::BootUp => "boot-up",
        }),
    })
}

/// The fullest tenth of a second.
fn peak(peak: &Peak, bus: &BusStatistics) -> Value {
    let percent = bus.bit_rate.and_then(|bit_rate| peak.percent(bit_rate));
    json!(percent.map(|(time, percent)| json!({ "t": time.nanos(), "percent": percent })))
}

/// Frames a second by service.
fn rates(frames: &[u64; Service::ALL.len()], bus: &BusStatistics) -> Value {
    let seen = Service::ALL.into_iter().zip(*frames).filter(|(_, count)| *count > 0);
    Value::Object(seen.map(|(service, count)| (service.name().to_owned(), json!(bus.rate(count)))).collect())
}

/// The load that each service makes.
fn loads(bus: &BusStatistics) -> Value {
    let services = Service::ALL.into_iter().zip(bus.bits).zip(&bus.peaks).filter(|((_, bits), _)| *bits > 0);
    let load = |((service, bits), fullest): ((Service, u64), &Peak)| {
        let load = json!({ "bits": bits, "percent": bus.share_of_load(bits), "peak": peak(fullest, bus) });
        (service.name().to_owned(), load)
    };
    Value::Object(services.map(load).collect())
}

fn response_times(times: &Histogram) -> Value {
    let nanos = |percent| times.quantile(percent).map(|time| time.nanos());
    json!({
        "count": times.count(),
        "min": times.min().map(|time| time.nanos()),
        "p50": nanos(50),
        "p95": nanos(95),
        "p99": nanos(99),
        "max": times.max().map(|time| time.nanos()),
    })
}

fn bus(channel: &str, bus: &BusStatistics) -> Value {
    json!({
        "channel": channel,
        "frames": bus.total(),
        "counts": of(&bus.frames),
        "rates": rates(&bus.frames, bus),
        "copies": bus.copies,
        "bits": bus.bits.iter().sum::<u64>(),
        "bit_rate": bus.bit_rate,
        "bit_rate_inferred": bus.is_inferred,
        "first_t": bus.first.nanos(),
        "last_t": bus.last.nanos(),
        "load_percent": bus.mean_load(),
        "peak": bus.peak_load().map(|(time, percent)| json!({ "t": time.nanos(), "percent": percent })),
        "load_by_service": loads(bus),
        "load_over_time": {
            "start_t": bus.load.start().map(|start| start.nanos()),
            "width_ns": bus.load.width().nanos(),
            "bits": bus.load.bins(),
        },
        "test_run": bus.test_run.cases.iter().map(case).collect::<Vec<_>>(),
        "test_run_omitted": bus.test_run.omitted,
    })
}

fn case(case: &TestCase) -> Value {
    let mut told = case_name(&case.name);
    told.insert("verdict".into(), json!(case.verdict.as_deref()));
    told.insert("t".into(), case.begin.nanos().into());
    told.insert("t_last".into(), case.end.nanos().into());
    told.insert("number".into(), case.place.number.into());
    told.insert("number_last".into(), case.last_place.number.into());
    told.insert("frames".into(), case.frames.into());
    Value::Object(told)
}

/// `id`, or `group` and `case` where CiA's test tool marked it.
fn case_name(name: &CaseName) -> Map<String, Value> {
    match name {
        CaseName::Id(id) => Map::from_iter([("id".into(), id.as_ref().into())]),
        CaseName::Numbered { group, case } => {
            Map::from_iter([("group".into(), (*group).into()), ("case".into(), (*case).into())])
        }
    }
}
