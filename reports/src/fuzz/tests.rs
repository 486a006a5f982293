//! A hostile device's texts reach no reader unescaped, and the reports contain all parts of a violation.

use super::*;
use crate::document::{Form, Report, Style};
use canvass_analyzer::Multiplexer;
use canvass_bus::Interruptions;
use canvass_fuzzer::{DeviceState, Property, Sequence, Spent, Start, Stimulus, Symptom, Violation};
use canvass_traces::{CanId, Duration, Frame};

const HOSTILE: &str = "<script>alert(1)</script>\u{1b}[2J```\n| x ]]>";

fn run() -> Run {
    let frame = Frame::new(CanId::standard_masked(0x601), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).unwrap();
    let violation = Violation {
        property: Property::LegalSdo,
        rule: "initiate upload",
        expected: HOSTILE.into(),
        actual: HOSTILE.into(),
        abort: None,
        interval: None,
        is_silence: false,
        symptom: Symptom::Frame(frame),
        state: DeviceState::default(),
        at: Timestamp(5),
    };
    let sequence = Sequence { start: Start::Configured, stimuli: vec![Stimulus::settle(frame)] };
    let evidence = vec![Record::new(Timestamp(1), ChannelId(0), frame).with_direction(Direction::Tx)];
    let found = Found::seen(violation, sequence, evidence);
    let kept = Kept { at: Multiplexer::new(0x1015, 0), value: 0xFF00, power_on: 0 };
    let outcome = Outcome {
        executions: 7,
        frames: 8,
        sequences: 2,
        unjudged: 1,
        dead: false,
        is_simulated: false,
        left: Some(FinalState { settings: 9, compared: 9, different: vec![kept] }),
        coverage: Coverage::default(),
        spent: Spent::default(),
        spent_on_violations: Spent::default(),
        violations: vec![found],
        corpus: Vec::new(),
        interruptions: None,
        ended_by: None,
    };
    Run {
        provenance: Provenance::default(),
        bus: HOSTILE.to_owned(),
        bit_rate: None,
        node: NodeId::MIN,
        model: HOSTILE.to_owned(),
        targets: canvass_fuzzer::Target::Sdo.into(),
        allow: [Touch::Nvm].into(),
        seed: 7,
        repeat: HOSTILE.to_owned(),
        cancelled: false,
        sdo_reach: SdoReach { blocks: true, long_values: true },
        reach: LssReach::default(),
        outcome,
        zero_point: None,
        words: vec![Words { sequence: vec![HOSTILE.to_owned()], evidence: vec![HOSTILE.to_owned()] }],
    }
}

const TEXT: Form = Form::Text(Style { color: false, width: None });

fn rendered(form: Form) -> String {
    let mut out = Vec::new();
    run().write(form, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn hostile_words_stay_words() {
    for form in [TEXT, Form::Json, Form::Junit, Form::Markdown, Form::Html, Form::Sarif] {
        let text = rendered(form);
        assert!(!text.contains('\u{1b}'), "{text}");
        assert!(text.contains("PROP-02"), "{text}");
        assert!(text.contains("601#4000100000000000"), "{text}");
    }
    assert!(!rendered(Form::Html).contains("<script>alert"));
    assert!(rendered(Form::Markdown).contains("````"), "a longer fence than any inside");
}

fn moved() -> Moved {
    Moved {
        steps: 307,
        preset: Multiplexer::new(0x6003, 0),
        takes_position: true,
        position: Multiplexer::new(0x6004, 0),
        range: 10_000,
        is_uncertain: false,
        is_denied: false,
        is_stored: false,
    }
}

#[test]
fn what_the_run_leaves_is_told() {
    for form in [TEXT, Form::Markdown, Form::Html] {
        let text = rendered(form);
        assert!(
            text.contains("1 of 9 settings is not as before the run: 1015h:00 holds FF00h instead of 0h"),
            "{text}"
        );
    }
    let mut run = run();
    let left = |run: &Run| super::left(run);
    run.outcome.left = Some(FinalState { settings: 9, compared: 9, different: Vec::new() });
    assert_eq!(left(&run), "the device's settings are as before the run (9 were read)");
    run.outcome.left = Some(FinalState { settings: 9, compared: 4, different: Vec::new() });
    assert_eq!(left(&run), "4 of the device's 9 settings were read again, and are as before the run");
    run.zero_point = Some(moved());
    let told = "; the zero point was moved by +307 steps. To set it right by hand, at rest: read 6004h:00, and give 6003h:00 \
                that value minus 307, modulo 10000";
    assert!(left(&run).ends_with(told), "{}", left(&run));
    run.zero_point = None;
    run.outcome.left = None;
    assert!(left(&run).contains("is not known"));
    run.outcome.is_simulated = true;
    assert_eq!(left(&run), "");
}

/// A run that ended with the loss of the bus is not good, and reports the interruption and its duration.
#[test]
fn a_lost_bus_is_told() {
    let last = Some(format!("{HOSTILE} was disconnected"));
    let interruptions = Interruptions { count: 2, lasted: Duration::from_millis(1_500), last, is_over: false };
    let mut lost = run();
    lost.outcome.interruptions = Some(interruptions);
    lost.outcome.ended_by = Some("the bus was not back within 120 s".to_owned());
    lost.outcome.left = None;
    lost.outcome.violations[0].is_cut_off = true;
    let rendered = |form: Form| {
        let mut out = Vec::new();
        lost.write(form, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    };
    for form in [TEXT, Form::Json, Form::Junit, Form::Markdown, Form::Html, Form::Sarif] {
        let text = rendered(form);
        assert!(text.contains("the bus was not back within 120 s"), "{text}");
        assert!(!text.contains('\u{1b}'), "{text}");
    }
    for form in [TEXT, Form::Junit, Form::Markdown, Form::Html] {
        let text = rendered(form);
        assert!(text.contains("2 interruptions of the bus, for 1.5 s in all so far"), "{text}");
        assert!(text.contains("was seen once, and the bus was lost before it could be repeated"), "{text}");
    }
    assert!(rendered(TEXT).contains("is not known: the bus was lost"));
    assert!(rendered(Form::Junit).contains("<error"), "{}", rendered(Form::Junit));
    let document: serde_json::Value = serde_json::from_str(&rendered(Form::Json)).unwrap();
    let interruptions = &document["interruptions"];
    assert_eq!((&interruptions["count"], &interruptions["over"]), (&2.into(), &false.into()));
    assert_eq!(
        (&interruptions["duration_ns"], &document["violations"][0]["cut_off"]),
        (&1_500_000_000_u64.into(), &true.into())
    );
}

#[test]
fn the_contract_has_its_members() {
    let document: serde_json::Value = serde_json::from_str(&rendered(Form::Json)).unwrap();
    assert_eq!((&document["schema"], &document["seed"]), (&"canvass/fuzz/1".into(), &7.into()));
    let left = serde_json::json!({ "index": 0x1015, "sub": 0, "value": 0xFF00, "power_on": 0 });
    assert_eq!(document["left"], serde_json::json!({ "settings": 9, "compared": 9, "different": [left] }));
    let violation = &document["violations"][0];
    assert_eq!(violation["frames"][0]["data"], "4000100000000000");
    assert_eq!((&violation["confirmed"], &violation["evidence"][0]["t"]), (&false.into(), &1.into()));
    assert!(violation["test"].as_str().unwrap().contains("#[test]"));
    assert!(rendered(TEXT).contains("seen once"));
    assert!(rendered(TEXT).contains("; 1 sequence could not be judged"));
}

/// The results of two runs have the same fingerprints, so that a code host knows the alert again. A violation that did
/// not come back is a warning.
#[test]
fn sarif_has_an_alert_for_each_violation() {
    let results = |confirmed: bool| {
        let mut run = run();
        run.outcome.violations[0].confirmed = confirmed;
        let mut out = Vec::new();
        run.write(Form::Sarif, &mut out).unwrap();
        let sarif: serde_json::Value = serde_json::from_slice(&out).unwrap();
        sarif["runs"][0]["results"].as_array().unwrap().clone()
    };
    let id = format!("fuzz.{}/{}", run().targets, run().outcome.violations[0].violation.defect());
    for (confirmed, level) in [(true, "error"), (false, "warning")] {
        let results = results(confirmed);
        assert_eq!(results.len(), run().outcome.violations.len());
        let fingerprint = &results[0]["partialFingerprints"]["canvass/1"];
        assert_eq!((&results[0]["ruleId"], fingerprint), (&id.clone().into(), &id.clone().into()));
        assert_eq!(results[0]["level"], level);
    }
}
