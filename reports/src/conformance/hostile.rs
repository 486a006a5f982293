//! All renderings of a run with a device whose names and texts are hostile.

use super::{Reporter, RunReport};
use crate::document::{Form, Style};
use crate::escape;
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::object;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::observation::{Observation, Subject};
use canvass_suite::bench::{Evidence, Exhibit, Measurement, Unit, Use};
use canvass_suite::catalogue;
use canvass_suite::comparison::{Change, Comparison, Nature};
use canvass_suite::quarantine::Quarantine;
use canvass_suite::runner::{CaseReport, DeviceIdentity, RunEvent, RunInfo, Summary};
use canvass_suite::verdict::{Authority, Breach, Excuse, Kind, Reason, Ruled, Verdict};
use canvass_traces::{CanId, ChannelId, Direction, Duration, Frame, Record, Timestamp};

const HOSTILE: &str = "\x1b]0;owned\x07\x1b[2J<script>alert('x')</script>\"'&]]>\u{9b}31m\u{202e}\u{0}\u{ffff}";

/// Sends the events of a run with one case of each verdict to the reporter.
pub fn play(reporter: &mut dyn Reporter) {
    let info = RunInfo {
        bus: "sim:kuebler-sendix-58x8".to_owned(),
        bit_rate: Some(250_000),
        node: NodeId::new(63).unwrap(),
        model: HOSTILE.to_owned(),
        device: DeviceIdentity {
            device_type: Some(0x0002_0196),
            identity: [Some(0x13), Some(0x2001), None, Some(1)],
            names: [Some(HOSTILE.to_owned()), None, Some("=cmd()".to_owned())],
        },
        seed: 7,
        shuffle: None,
        cases: 7,
        dictionary: vec![(Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0), vec![0x1B, 0x5B])],
    };
    reporter.event(&RunEvent::RunStarted(&info)).unwrap();
    let mut summary = Summary::default();
    summary.duration = Duration::from_millis(1_234);
    let cases = catalogue::cases();
    for (number, &kind) in Kind::ALL.iter().enumerate() {
        let case = cases[number];
        reporter.event(&RunEvent::CaseStarted { case, number: number + 1, of: 7 }).unwrap();
        summary.add(kind);
        let (mut evidence, id) = (Evidence::default(), CanId::standard(0x63F).unwrap());
        let record = Record::new(Timestamp(12_345_678), ChannelId(0), Frame::full(id, [0x40, 0, 0x10, 0, 0, 0, 0, 0]));
        evidence.push(Exhibit { record: record.with_direction(Direction::Tx), text: HOSTILE.to_owned() });
        let (verdict, notes) = (verdict(kind), vec![HOSTILE.to_owned()]);
        let report = CaseReport {
            case,
            verdict,
            evidence,
            notes,
            measurements: vec![Measurement { name: HOSTILE.to_owned(), value: 7, unit: Unit::Count }],
            uses: vec![Use { multiplexer: Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), purpose: "written" }],
            foreign: Vec::new(),
            outcomes: vec![kind, Kind::Pass],
            quarantine: (kind == Kind::Error).then(quarantine),
            duration: Duration::from_millis(100),
        };
        reporter.event(&RunEvent::CaseFinished(&report)).unwrap();
    }
    let change = |nature| Change {
        multiplexer: Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0),
        name: Some(HOSTILE.to_owned()),
        data_type: Some(DataType::VISIBLE_STRING),
        nature,
        before: Some(HOSTILE.into()),
        after: None,
    };
    let comparison = Comparison {
        is_complete: true,
        objects: 1,
        changes: vec![change(Nature::Setting), change(Nature::Own)],
        commands: vec![HOSTILE.to_owned()],
        stored: vec![change(Nature::Setting)],
        ..Comparison::default()
    };
    reporter.event(&RunEvent::DictionaryCompared(&comparison)).unwrap();
    reporter.event(&RunEvent::Noticed(HOSTILE)).unwrap();
    reporter.event(&RunEvent::RunFinished(&summary)).unwrap();
}

fn quarantine() -> Quarantine {
    let hostile = || HOSTILE.to_owned();
    Quarantine { line: 3, case: hostile(), owner: hostile(), reason: hostile(), until: hostile() }
}

fn verdict(kind: Kind) -> Verdict {
    let reason = Reason::new(HOSTILE, "the value", HOSTILE);
    let breach = Breach::new(Subject::Device, HOSTILE).expected("the value").found(Observation::named(HOSTILE));
    let excuse = Excuse { documented: HOSTILE.to_owned(), by: Authority::Waiver { line: 3 } };
    let ruled = |breach: Breach, excuse| Verdict::new(vec![Ruled { breach, excuse }], None);
    match kind {
        Kind::Pass => Verdict::pass(),
        Kind::Tolerated => ruled(breach.tolerated(), None),
        Kind::Deviation => ruled(breach, Some(excuse)),
        Kind::Fail => ruled(breach.told(HOSTILE), None),
        Kind::Inconclusive => Verdict::inconclusive(reason),
        Kind::NotApplicable => Verdict::not_applicable(reason),
        Kind::Error => Verdict::error(reason),
    }
}

fn rendered(form: Form) -> String {
    let mut out = Vec::new();
    play(&mut RunReport::new(&mut out, form));
    String::from_utf8(out).unwrap()
}

fn acts(text: &str) -> bool {
    text.contains(|c| c != '\n' && escape::acts(c))
}

#[test]
fn the_terminal_is_not_taken_over() {
    let out = rendered(Form::Text(Style::default()));
    assert!(!acts(&out) && out.contains("\\x1B[2J") && out.contains("\\u{202E}"), "{out}");
    assert!(out.contains("(0.012345678)  63F#4000100000000000  Tx"), "{out}");
}

#[test]
fn the_page_runs_no_foreign_script() {
    let page = rendered(Form::Html);
    assert!(!acts(&page) && !page.contains("<script>alert") && page.contains("&lt;script&gt;alert"));
    // The page contains two scripts: the script that all pages share, and its own. The policy lets no other script run.
    assert_eq!(page.matches("<script").count(), 2);
    let policy = page.split_once("script-src ").unwrap().1.split(';').next().unwrap();
    assert!(policy.matches("sha256-").count() == 2 && !policy.contains("unsafe"), "{policy}");
    assert!(!page.contains("http://") && !page.contains("https://"), "nothing external");
}

#[test]
fn the_junit_counts_are_right() {
    let xml = rendered(Form::Junit);
    let suites: Vec<&str> = xml.split("<testsuite ").skip(1).collect();
    let value = |suite: &str, name: &str| {
        let (_, rest) = suite.split_once(&format!(" {name}=\"")).unwrap();
        rest.split_once('"').unwrap().0.parse::<usize>().unwrap()
    };
    let sum = |name: &str| suites.iter().map(|suite| value(suite, name)).sum::<usize>();
    let counts = ["tests", "failures", "errors", "skipped"].map(sum);
    assert_eq!(counts, [7, 1, 1, 2], "one that could not be run is in quarantine");
    let elements = ["<testcase ", "<failure ", "<error ", "<skipped "];
    assert_eq!(elements.map(|element| xml.matches(element).count()), counts);
    assert!(suites.iter().enumerate().all(|(number, suite)| value(suite, "id") == number));
    // Neither JUnit schema has a place for remarks on a case that passes, so they are in the output of its suite.
    let outputs = suites.iter().filter_map(|suite| suite.split_once("<system-out>"));
    let output: String =
        outputs.filter_map(|(_, rest)| rest.split_once("</system-out>")).map(|parts| parts.0).collect();
    assert!(output.contains("tolerated: ") && output.contains("waiver: "), "{output}");
}

#[test]
fn junit_stays_xml() {
    let xml = rendered(Form::Junit);
    assert!(!acts(&xml));
    // An XML parser that does not know JUnit must reach the end, too.
    let mut reader = quick_xml::Reader::from_str(&xml);
    while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}
}

#[test]
fn json_keeps_the_contract() {
    let text = rendered(Form::Json);
    assert!(!acts(&text));
    assert_eq!(text, rendered(Form::Json), "the same run gives the same bytes");
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["schema"], "canvass/test/1");
    assert_eq!(value["device"]["name"], HOSTILE);
    for kind in Kind::ALL {
        assert_eq!(value["summary"][kind.name()], 1, "{kind}");
    }
    let change = &value["comparison"]["changes"][0];
    assert_eq!(
        (&change["index"], &change["nature"], &change["after"]),
        (&object::MANUFACTURER_DEVICE_NAME.into(), &"setting".into(), &().into())
    );
    assert_eq!(value["comparison"]["as_found"], false);
    let case = &value["cases"][3];
    assert_eq!((&case["verdict"], &case["reason"]["expected"]), (&"fail".into(), &"the value".into()));
    assert!(case["id"].is_string() && case["clause"].is_string() && case["clause_confidence"].is_string());
    assert_eq!(case["duration_ns"], 100_000_000);
    let frame = &case["evidence"][0];
    assert_eq!((&frame["t"], &frame["id"]), (&12_345_678.into(), &0x63F.into()));
    assert_eq!((&frame["data"], &frame["channel"]), (&"4000100000000000".into(), &"sim:kuebler-sendix-58x8".into()));
}

#[test]
fn markdown_is_text() {
    let text = rendered(Form::Markdown);
    // Text between fences is code, in which markup is plain text.
    let outside = text.split("\n```").step_by(2).collect::<String>();
    assert!(!acts(&text) && outside.contains("All cases") && !outside.contains("<script>"), "{text}");
}

#[test]
fn cells_of_a_table_are_safe() {
    let cell = escape::csv_cell("=HYPERLINK(\"http://x\")");
    assert_eq!(cell, "\"'=HYPERLINK(\"\"http://x\"\")\"");
    assert!(!acts(&escape::csv_cell(HOSTILE)));
}
