//! The result as JSON: [`TestResult`].

use super::Run;
use super::defects::{Defect, defects};
use super::told::{Named, Told};
use crate::provenance;
use crate::results::test::{
    Breach, Case, Compared, Frame, HostTiming, Measurement, MovedZeroPoint, ObjectChange, ObjectRead, OtherClient,
    Quarantine, Reason, Use,
};
use crate::results::{self, Contract, TestResult, Verdict};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_bus::StampTrouble;
use canvass_suite::bench::{self, Exhibit};
use canvass_suite::comparison::{Change, Comparison};
use canvass_suite::foreign::ForeignMessages;
use canvass_suite::runner::{self, CaseReport};
use canvass_suite::verdict::{Authority, Kind};
use canvass_suite::zero_point::Moved;
use canvass_suite::{quarantine, verdict};
use canvass_traces::{Direction, hex};
use std::io::{self, Write};

/// Writes the document, indented, with a line end.
///
/// # Errors
/// The errors of `out`.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    results::write(&result(run), out)
}

/// The run as a result.
pub fn result(run: &Run) -> TestResult {
    TestResult {
        schema: TestResult::SCHEMA.into(),
        bus: run.info.bus.clone(),
        bit_rate: run.info.bit_rate,
        node: run.info.node.raw(),
        model: Some(run.info.model.clone()).filter(|model| !model.is_empty()),
        device: (&run.info.device).into(),
        seed: run.info.seed,
        shuffle: run.info.shuffle,
        cancelled: run.summary.cancelled,
        duration_ns: run.summary.duration.nanos(),
        stores: run.summary.stores,
        notices: run.notices.clone(),
        provenance: provenance::json(&run.provenance),
        dictionary: run.info.dictionary.iter().map(object).collect(),
        comparison: run.comparison.as_ref().map(compared),
        summary: Kind::ALL.into_iter().map(|kind| (kind.name().into(), run.summary.count(kind))).collect(),
        defects: defects(run).iter().filter(|defect| defect.is_failure()).map(defect).collect(),
        host: run.summary.host.as_ref().map(host),
        other_clients: run.other_clients.iter().map(other_client).collect(),
        cases: run.cases.iter().map(|report| case(report, &run.info.bus)).collect(),
    }
}

fn defect(defect: &Defect<'_>) -> results::test::Defect {
    let cases = [defect.first].into_iter().chain(defect.others.iter().copied());
    results::test::Defect {
        reason: defect.first.verdict.reason().map(reason),
        cases: cases.map(|report| report.case.id.into()).collect(),
    }
}

fn host(host: &runner::HostTiming) -> HostTiming {
    HostTiming {
        receive_p99_ns: host.receive_usually.nanos(),
        receive_max_ns: host.receive_always.nanos(),
        transmit_p99_ns: host.transmit_usually.nanos(),
        transmit_max_ns: host.transmit_always.nanos(),
        lost: host.lost,
        interruptions: host.interruptions,
        interrupted_ns: host.interrupted_for.nanos(),
        time_stamps: host.stamps.map(|trouble| StampTrouble::name(trouble).into()),
    }
}

fn object((multiplexer, value): &(Multiplexer, Vec<u8>)) -> ObjectRead {
    ObjectRead { index: multiplexer.index.0, sub: multiplexer.sub.0, data: hex::compact(value).to_string() }
}

fn compared(comparison: &Comparison) -> Compared {
    Compared {
        as_found: comparison.is_as_found(),
        complete: comparison.is_complete,
        objects: comparison.objects,
        changes: comparison.changes.iter().map(changed).collect(),
        commands: comparison.commands.clone(),
        stored: comparison.stored.iter().map(changed).collect(),
        zero_points: comparison.zero_points.iter().map(MovedZeroPoint::from).collect(),
        behaviour: comparison.behaviour.iter().map(ToString::to_string).collect(),
    }
}

impl From<&Moved> for MovedZeroPoint {
    fn from(moved: &Moved) -> Self {
        let (steps, uncertain, stored) = (moved.steps, moved.is_uncertain, moved.is_stored);
        Self { steps, uncertain, stored, text: moved.to_string() }
    }
}

fn changed(change: &Change) -> ObjectChange {
    let shown = |value: &Option<Vec<u8>>| value.as_deref().map(|value| hex::compact(value).to_string());
    ObjectChange {
        index: change.multiplexer.index.0,
        sub: change.multiplexer.sub.0,
        name: change.name.clone(),
        r#type: change.data_type.and_then(DataType::name).map(Into::into),
        nature: change.nature.name().into(),
        before: shown(&change.before),
        after: shown(&change.after),
    }
}

fn used(bench::Use { multiplexer, purpose }: &bench::Use) -> Use {
    Use { index: multiplexer.index.0, sub: multiplexer.sub.0, purpose: (*purpose).into() }
}

fn other_client(&ForeignMessages { kind, can_id, count }: &ForeignMessages) -> OtherClient {
    OtherClient { kind: kind.name().into(), id: can_id, count }
}

fn measured(measurement: &bench::Measurement) -> Measurement {
    Measurement { name: measurement.name.clone(), unit: measurement.unit.name().into(), value: measurement.value }
}

fn case(report: &CaseReport, channel: &str) -> Case {
    Case {
        id: report.case.id.into(),
        requirement: report.case.requirement.into(),
        clause: report.case.clause.bare(),
        clause_confidence: report.case.clause.confidence.name().into(),
        level: report.case.level.name().into(),
        cct: report.case.cct.map(Into::into),
        cct_forecast: super::cct_forecast(report).map(Into::into),
        verdict: Verdict(report.verdict.kind()),
        reason: report.verdict.reason().map(reason),
        breaches: Told::all(report).into_iter().filter_map(breach).collect(),
        documented: report.verdict.documented().map(str::to_owned),
        waiver_line: match report.verdict.authority() {
            Some(Authority::Waiver { line }) => Some(line),
            _ => None,
        },
        repetitions: match report.outcomes.len() {
            0 | 1 => Vec::new(),
            _ => report.outcomes.iter().copied().map(Verdict).collect(),
        },
        flaky: report.is_flaky(),
        quarantine: report.quarantine.as_ref().map(quarantined),
        measurements: report.measurements.iter().map(measured).collect(),
        uses: report.uses.iter().map(used).collect(),
        notes: report.notes.clone(),
        other_clients: report.foreign.iter().map(other_client).collect(),
        recorded: super::recorded(report),
        evidence: report.evidence.frames().map(|exhibit| frame(exhibit, channel)).collect(),
        evidence_omitted: report.evidence.omitted(),
        duration_ns: report.duration.nanos(),
    }
}

fn reason(verdict::Reason { duty, expected, actual, .. }: verdict::Reason) -> Reason {
    Reason { duty, expected, actual }
}

fn quarantined(quarantine::Quarantine { until, owner, reason, .. }: &quarantine::Quarantine) -> Quarantine {
    Quarantine { until: until.clone(), owner: owner.clone(), reason: reason.clone() }
}

fn breach(told: Told) -> Option<Breach> {
    let waiver_line = told.waiver_line();
    let Named { subject, does, situation } = told.breach?;
    Some(Breach {
        subject,
        observation: does,
        situation: situation.map(Into::into),
        verdict: Verdict(told.kind),
        duty: told.duty,
        expected: told.expected,
        actual: told.found,
        t: told.seen.map(|seen| seen.0),
        documented: told.excuse.map(|excuse| excuse.documented),
        waiver_line,
    })
}

fn frame(Exhibit { record, text }: &Exhibit, channel: &str) -> Frame {
    Frame {
        number: Some(record.place.number).filter(|&number| number > 0),
        t: record.timestamp.nanos(),
        channel: channel.to_owned(),
        id: record.frame.id().raw(),
        extended: record.frame.id().is_extended().then_some(true),
        remote: record.frame.is_remote().then_some(true),
        error: record.frame.is_error().then_some(true),
        direction: if record.direction == Direction::Tx { "tx" } else { "rx" }.into(),
        data: hex::compact(record.data()).to_string(),
        text: text.clone(),
    }
}
