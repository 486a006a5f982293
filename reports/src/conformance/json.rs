//! The result as JSON: `"schema": "canvass/test/1"`.
//!
//! Contract: numbers are numbers, times are integer nanoseconds on the clock of the bus; nothing but the date in
//! `provenance` is of the wall clock, so on the simulated bus two runs give the same bytes. New keys may be added; none changes its meaning within
//! a version.

use super::Run;
use super::told::{Named, Told};
use crate::{escape, provenance};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_bus::StampTrouble;
use canvass_suite::bench::{Exhibit, Measurement, Use};
use canvass_suite::comparison::{Change, Comparison};
use canvass_suite::foreign::ForeignMessages;
use canvass_suite::quarantine::Quarantine;
use canvass_suite::runner::{CaseReport, DeviceIdentity, HostTiming};
use canvass_suite::verdict::{Authority, Kind, Reason};
use canvass_suite::zero_point::Moved;
use canvass_traces::{Direction, hex};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/test/1";

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    bus: &'a str,
    bit_rate: Option<u32>,
    node: u8,
    model: Option<&'a str>,
    device: Device<'a>,
    seed: u64,
    cancelled: bool,
    duration_ns: u64,
    stores: u32,
    notices: &'a [String],
    provenance: serde_json::Value,
    dictionary: Vec<Object>,
    comparison: Option<Compared<'a>>,
    summary: BTreeMap<&'static str, usize>,
    /// Only of a live bus, so that runs on the simulated one stay the same to the byte.
    #[serde(skip_serializing_if = "Option::is_none")]
    host: Option<Host>,
    /// Only where others used the device.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    other_clients: Vec<OtherClient>,
    cases: Vec<Case<'a>>,
}

/// How well the tester's own machine kept up.
#[derive(Serialize)]
struct Host {
    receive_p99_ns: u64,
    receive_max_ns: u64,
    transmit_p99_ns: u64,
    transmit_max_ns: u64,
    lost: u64,
    interruptions: u64,
    interrupted_ns: u64,
    /// Only where they can't be trusted.
    #[serde(skip_serializing_if = "Option::is_none")]
    time_stamps: Option<&'static str>,
}

/// What others sent to the device or for it.
#[derive(Serialize)]
struct OtherClient {
    kind: &'static str,
    id: u16,
    count: u64,
}

impl From<&HostTiming> for Host {
    fn from(host: &HostTiming) -> Self {
        Self {
            receive_p99_ns: host.receive_usually.nanos(),
            receive_max_ns: host.receive_always.nanos(),
            transmit_p99_ns: host.transmit_usually.nanos(),
            transmit_max_ns: host.transmit_always.nanos(),
            lost: host.lost,
            interruptions: host.interruptions,
            interrupted_ns: host.interrupted_for.nanos(),
            time_stamps: host.stamps.map(StampTrouble::name),
        }
    }
}

#[derive(Serialize)]
struct Object {
    index: u16,
    sub: u8,
    data: String,
}

/// The object dictionary before and after.
#[derive(Serialize)]
struct Compared<'a> {
    as_found: bool,
    complete: bool,
    objects: usize,
    changes: Vec<Changed<'a>>,
    commands: &'a [String],
    stored: Vec<Changed<'a>>,
    zero_points: Vec<MovedZeroPoint>,
    behaviour: Vec<String>,
}

#[derive(Serialize)]
struct MovedZeroPoint {
    steps: i64,
    uncertain: bool,
    stored: bool,
    text: String,
}

#[derive(Serialize)]
struct Changed<'a> {
    index: u16,
    sub: u8,
    name: Option<&'a str>,
    r#type: Option<&'static str>,
    nature: &'static str,
    before: Option<String>,
    after: Option<String>,
}

#[derive(Serialize)]
struct Value<'a> {
    name: &'a str,
    unit: &'static str,
    value: u64,
}

#[derive(Serialize)]
struct Device<'a> {
    device_type: Option<u32>,
    vendor_id: Option<u32>,
    product_code: Option<u32>,
    revision_number: Option<u32>,
    serial_number: Option<u32>,
    name: Option<&'a str>,
    hardware_version: Option<&'a str>,
    software_version: Option<&'a str>,
}

#[derive(Serialize)]
struct Case<'a> {
    id: &'static str,
    requirement: &'static str,
    clause: String,
    clause_confidence: &'static str,
    level: &'static str,
    cct: Option<&'static str>,
    cct_forecast: Option<&'static str>,
    verdict: &'static str,
    reason: Option<CaseReason>,
    breaches: Vec<Breach>,
    documented: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    waiver_line: Option<usize>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    repetitions: Vec<&'static str>,
    flaky: bool,
    /// Only where the failure does not count yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    quarantine: Option<Quarantined<'a>>,
    measurements: Vec<Value<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    uses: Vec<Used>,
    notes: &'a [String],
    /// Only where others used the device meanwhile.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    other_clients: Vec<OtherClient>,
    /// Only where the run was recorded: the first and the last frame of the case in the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    recorded: Option<[u64; 2]>,
    evidence: Vec<Frame<'a>>,
    evidence_omitted: u64,
    duration_ns: u64,
}

/// Why a failure does not count yet.
#[derive(Serialize)]
struct Quarantined<'a> {
    until: &'a str,
    owner: &'a str,
    reason: &'a str,
}

/// An object that served a case.
#[derive(Serialize)]
struct Used {
    index: u16,
    sub: u8,
    purpose: &'static str,
}

#[derive(Serialize)]
struct CaseReason {
    duty: String,
    expected: String,
    actual: String,
}

#[derive(Serialize)]
struct Breach {
    subject: String,
    observation: String,
    verdict: &'static str,
    duty: String,
    expected: String,
    actual: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    t: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    documented: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    waiver_line: Option<usize>,
}

#[derive(Serialize)]
struct Frame<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    number: Option<u64>,
    t: u64,
    channel: &'a str,
    id: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    extended: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    remote: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<bool>,
    direction: &'static str,
    data: String,
    text: &'a str,
}

/// Writes the document, indented, with a line end.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let document = Document {
        schema: SCHEMA,
        bus: &run.info.bus,
        bit_rate: run.info.bit_rate,
        node: run.info.node.raw(),
        model: Some(run.info.model.as_str()).filter(|model| !model.is_empty()),
        device: device(&run.info.device),
        seed: run.info.seed,
        cancelled: run.summary.cancelled,
        duration_ns: run.summary.duration.nanos(),
        stores: run.summary.stores,
        notices: &run.notices,
        provenance: provenance::json(&run.provenance),
        dictionary: run.info.dictionary.iter().map(object).collect(),
        comparison: run.comparison.as_ref().map(compared),
        summary: Kind::ALL.into_iter().map(|kind| (kind.name(), run.summary.count(kind))).collect(),
        host: run.summary.host.as_ref().map(Host::from),
        other_clients: run.other_clients.iter().map(other_client).collect(),
        cases: run.cases.iter().map(|report| case(report, &run.info.bus)).collect(),
    };
    let text = serde_json::to_string_pretty(&document).map_err(io::Error::other)?;
    out.write_all(escape::json(&text).as_bytes())?;
    out.write_all(b"\n")
}

fn object((multiplexer, value): &(Multiplexer, Vec<u8>)) -> Object {
    Object { index: multiplexer.index.0, sub: multiplexer.sub.0, data: hex::compact(value).to_string() }
}

fn compared(comparison: &Comparison) -> Compared<'_> {
    Compared {
        as_found: comparison.is_as_found(),
        complete: comparison.is_complete,
        objects: comparison.objects,
        changes: comparison.changes.iter().map(changed).collect(),
        commands: &comparison.commands,
        stored: comparison.stored.iter().map(changed).collect(),
        zero_points: comparison.zero_points.iter().map(zero_point).collect(),
        behaviour: comparison.behaviour.iter().map(ToString::to_string).collect(),
    }
}

fn zero_point(moved: &Moved) -> MovedZeroPoint {
    let (steps, uncertain, stored) = (moved.steps, moved.is_uncertain, moved.is_stored);
    MovedZeroPoint { steps, uncertain, stored, text: moved.to_string() }
}

fn changed(change: &Change) -> Changed<'_> {
    Changed {
        index: change.multiplexer.index.0,
        sub: change.multiplexer.sub.0,
        name: change.name.as_deref(),
        r#type: change.data_type.and_then(DataType::name),
        nature: change.nature.name(),
        before: change.before.as_deref().map(|value| hex::compact(value).to_string()),
        after: change.after.as_deref().map(|value| hex::compact(value).to_string()),
    }
}

fn used(Use { multiplexer, purpose }: &Use) -> Used {
    Used { index: multiplexer.index.0, sub: multiplexer.sub.0, purpose }
}

fn other_client(&ForeignMessages { kind, can_id, count }: &ForeignMessages) -> OtherClient {
    OtherClient { kind: kind.name(), id: can_id, count }
}

fn value(measurement: &Measurement) -> Value<'_> {
    Value { name: &measurement.name, unit: measurement.unit.name(), value: measurement.value }
}

fn device(device: &DeviceIdentity) -> Device<'_> {
    let [vendor_id, product_code, revision_number, serial_number] = device.identity;
    let [name, hardware_version, software_version] = device.names.each_ref().map(Option::as_deref);
    let device_type = device.device_type;
    Device {
        device_type,
        vendor_id,
        product_code,
        revision_number,
        serial_number,
        name,
        hardware_version,
        software_version,
    }
}

fn case<'a>(report: &'a CaseReport, channel: &'a str) -> Case<'a> {
    let reason = |Reason { duty, expected, actual, .. }| CaseReason { duty, expected, actual };
    Case {
        id: report.case.id,
        requirement: report.case.requirement,
        clause: report.case.clause.bare(),
        clause_confidence: report.case.clause.confidence.name(),
        level: report.case.level.name(),
        cct: report.case.cct,
        cct_forecast: super::cct_forecast(report),
        verdict: report.verdict.kind().name(),
        reason: report.verdict.reason().map(reason),
        breaches: Told::all(report).into_iter().filter_map(breach).collect(),
        documented: report.verdict.documented(),
        waiver_line: match report.verdict.authority() {
            Some(Authority::Waiver { line }) => Some(line),
            _ => None,
        },
        repetitions: match report.outcomes.len() {
            0 | 1 => Vec::new(),
            _ => report.outcomes.iter().map(|kind| kind.name()).collect(),
        },
        flaky: report.is_flaky(),
        quarantine: report.quarantine.as_ref().map(quarantined),
        measurements: report.measurements.iter().map(value).collect(),
        uses: report.uses.iter().map(used).collect(),
        notes: &report.notes,
        other_clients: report.foreign.iter().map(other_client).collect(),
        recorded: super::recorded(report),
        evidence: report.evidence.frames().map(|exhibit| frame(exhibit, channel)).collect(),
        evidence_omitted: report.evidence.omitted(),
        duration_ns: report.duration.nanos(),
    }
}

fn quarantined(Quarantine { until, owner, reason, .. }: &Quarantine) -> Quarantined<'_> {
    Quarantined { until, owner, reason }
}

fn breach(told: Told) -> Option<Breach> {
    let waiver_line = told.waiver_line();
    let Named { subject, does } = told.breach?;
    Some(Breach {
        subject,
        observation: does,
        verdict: told.kind.name(),
        duty: told.duty,
        expected: told.expected,
        actual: told.found,
        t: told.seen.map(|seen| seen.0),
        documented: told.excuse.map(|excuse| excuse.documented),
        waiver_line,
    })
}

fn frame<'a>(exhibit: &'a Exhibit, channel: &'a str) -> Frame<'a> {
    let Exhibit { record, text } = exhibit;
    Frame {
        number: Some(record.place.number).filter(|&number| number > 0),
        t: record.timestamp.nanos(),
        channel,
        id: record.frame.id().raw(),
        extended: record.frame.id().is_extended().then_some(true),
        remote: record.frame.is_remote().then_some(true),
        error: record.frame.is_error().then_some(true),
        direction: if record.direction == Direction::Tx { "tx" } else { "rx" },
        data: hex::compact(record.data()).to_string(),
        text,
    }
}
