//! The result as JSON: [`FuzzResult`].

use super::{Run, Words, rust_test, sdo_rows};
use crate::provenance;
use crate::results::fuzz::{
    Coverage, Interruptions, Kept, LssPair, Repetition, SdoPair, SeenFrame, SentFrame, SettingsLeft, Share, Violation,
};
use crate::results::test::MovedZeroPoint;
use crate::results::{self, Contract, FuzzResult};
use canvass_fuzzer::campaign::{self, Found};
use canvass_fuzzer::{FinalState, Start, Stimulus, Then, reproducer};
use canvass_traces::{Direction, Duration, Frame, Record, hex};
use std::io::{self, Write};

/// Writes the document, indented, with a line end.
///
/// # Errors
/// The errors of `out`.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    results::write(&result(run), out)
}

fn result(run: &Run) -> FuzzResult {
    FuzzResult {
        allow: run.allow.iter().map(|touch| touch.name().into()).collect(),
        bit_rate: run.bit_rate,
        bus: run.bus.clone(),
        cancelled: run.cancelled,
        coverage: coverage(run),
        dead: run.outcome.dead,
        ended_by: run.outcome.ended_by.clone(),
        executions: run.outcome.executions,
        frames: run.outcome.frames,
        interruptions: run.outcome.interruptions.as_ref().map(interruptions),
        left: run.outcome.left.as_ref().map(left),
        model: Some(run.model.clone()).filter(|model| !model.is_empty()),
        node: run.node.raw(),
        provenance: provenance::json(&run.provenance),
        repeat: run.repeat.clone(),
        schema: FuzzResult::SCHEMA.into(),
        seed: run.seed,
        sequences: run.outcome.sequences,
        target: run.targets.to_string(),
        unjudged: run.outcome.unjudged,
        version: provenance::VERSION.into(),
        zero_point: run.zero_point.as_ref().map(MovedZeroPoint::from),
        violations: run.violations().map(|(found, words)| violation(run, found, words)).collect(),
    }
}

fn coverage(run: &Run) -> Coverage {
    let sdo = sdo_rows(run).into_iter().map(|(state, command, answers)| {
        let answers = answers.iter().map(|(answer, count)| (answer.name().into(), *count)).collect();
        SdoPair { answers, command: command.into(), state: state.into() }
    });
    let lss = run.coverage().lss_rows().map(|(state, command, answered, count)| LssPair {
        answered,
        command: command.name().into(),
        count,
        state: state.name().into(),
    });
    let (of_sdo, of_lss) = (run.sdo_share(), run.lss_share());
    Coverage {
        lss: Share { pairs: lss.collect(), reachable: of_lss.reachable, reached: of_lss.reached },
        sdo: Share { pairs: sdo.collect(), reachable: of_sdo.reachable, reached: of_sdo.reached },
    }
}

fn left(left: &FinalState) -> SettingsLeft {
    let different = left.different.iter().map(kept).collect();
    SettingsLeft { compared: left.compared, different, settings: left.settings }
}

fn interruptions(told: &canvass_bus::Interruptions) -> Interruptions {
    let (duration_ns, last) = (told.lasted.nanos(), told.last.clone());
    Interruptions { count: told.count, duration_ns, last, over: told.is_over }
}

fn kept(kept: &canvass_fuzzer::Kept) -> Kept {
    Kept { index: kept.at.index.0, power_on: kept.power_on, sub: kept.at.sub.0, value: kept.value }
}

fn violation(run: &Run, found: &Found, words: &Words) -> Violation {
    let violation = &found.violation;
    let start = match found.sequence.start {
        Start::Configured => "configured",
        Start::Unconfigured => "without-node-id",
    };
    let frames = found.sequence.stimuli.iter().zip(&words.sequence);
    let evidence = found.evidence.iter().zip(&words.evidence);
    Violation {
        actual: violation.actual.to_string(),
        clause: violation.clause(),
        confirmed: found.confirmed,
        cut_off: found.is_cut_off,
        device_state: violation.state.to_string(),
        evidence: evidence.map(|(record, words)| seen(record, words)).collect(),
        expected: violation.expected.to_string(),
        frames: frames.map(|(stimulus, words)| sent(stimulus, words)).collect(),
        id: violation.defect().to_string(),
        late_ns: found.late.map(Duration::nanos),
        log: reproducer::log(found),
        needs_earlier: found.needs_earlier,
        property: violation.property.id().into(),
        pytest: reproducer::pytest(found, run.node, run.seed),
        repetitions: found.repetitions.iter().map(repetition).collect(),
        rule: violation.rule.into(),
        start: start.into(),
        state: found.state.iter().map(kept).collect(),
        t: violation.at.nanos(),
        test: rust_test(run, found),
        times: found.times,
        title: violation.property.title().into(),
    }
}

fn repetition(repetition: &campaign::Repetition) -> Repetition {
    Repetition { came: repetition.came.clone(), replay: repetition.replay.name().into(), shows: repetition.shows }
}

fn sent(stimulus: &Stimulus, words: &str) -> SentFrame {
    let (then, wait) = match stimulus.then {
        Then::Settle => ("settle", None),
        Then::AtOnce => ("at-once", None),
        Then::Pause(time) => ("pause", Some(time.nanos())),
    };
    let frame = &stimulus.frame;
    SentFrame {
        data: hex::compact(frame.data()).to_string(),
        dlc: dlc(frame),
        extended: frame.id().is_extended().then_some(true),
        id: frame.id().raw(),
        remote: frame.is_remote().then_some(true),
        text: words.to_owned(),
        then: then.into(),
        wait_ns: wait,
    }
}

fn seen(record: &Record, words: &str) -> SeenFrame {
    let frame = &record.frame;
    SeenFrame {
        data: hex::compact(frame.data()).to_string(),
        direction: if record.direction == Direction::Tx { "tx" } else { "rx" }.into(),
        dlc: dlc(frame),
        extended: frame.id().is_extended().then_some(true),
        id: frame.id().raw(),
        remote: frame.is_remote().then_some(true),
        t: record.timestamp.nanos(),
        text: words.to_owned(),
    }
}

/// The length that a remote frame requests.
fn dlc(frame: &Frame) -> Option<usize> {
    frame.is_remote().then(|| frame.len())
}
