//! The report on a device that differs from its description.

use super::Verification;
use crate::document::{Form, Report, Style};
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::dictionary::survey::compare::compare;
use canvass_analyzer::dictionary::survey::{Answer, Survey};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Index, Multiplexer, NodeId};

const EDS: &str = "[2000]\nParameterName=Set|up\nDataType=5\nAccessType=rw\nDefaultValue=5\nHighLimit=9\n[2001]\n\
                   ParameterName=\x1b[31mred\nDataType=7\nAccessType=const\nDefaultValue=0x12345678\n";
const STYLE: Form = Form::Text(Style { color: false, width: Some(80) });

impl Verification {
    fn written(&self, form: Form) -> String {
        let mut out = Vec::new();
        self.write(form, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }
}

fn verification(first: &[u8], second: Answer, as_delivered: bool) -> Verification {
    let description = DeviceDescription::read(EDS.as_bytes()).unwrap();
    let answers = [(Multiplexer::new(0x2000, 0), Answer::Value(first.to_vec())), (Multiplexer::new(0x2001, 0), second)];
    let survey = Survey::from_iter(answers);
    let (read, existing) = survey.counts();
    Verification {
        file: "a\x07.eds".to_owned(),
        bus: "can0".to_owned(),
        node: NodeId::MIN,
        as_delivered,
        read,
        existing,
        given_up: None,
        mismatches: compare(&description, &survey, NodeId::MIN),
    }
}

fn constant() -> Answer {
    Answer::Value(vec![0x78, 0x56, 0x34, 0x12])
}

#[test]
fn what_may_be_configured_is_told_and_does_not_count() {
    let one = verification(&[6], constant(), false);
    assert_eq!((one.differences().count(), one.explicable().count()), (0, 1));
    let text = one.written(STYLE);
    let rows = "│ 2000h:00 Set|up ┆ setting (may be configuration) ┆ 5         ┆ 6     │";
    assert!(text.contains(rows), "{text}");
    assert!(text.contains("\nsetting: not as delivered: "), "{text}");
    assert!(text.ends_with("2 entries read, no differences, 1 value that may be configuration or state\n"), "{text}");
    let delivered = verification(&[6], constant(), true);
    assert_eq!((delivered.differences().count(), delivered.explicable().count()), (1, 0));
    assert!(delivered.written(STYLE).ends_with("2 entries read, 1 difference\n"));
    let same = verification(&[5], constant(), true);
    assert!(same.written(STYLE).ends_with("node 1 on can0: 2 entries read, no differences\n"));
    assert_eq!(same.written(STYLE).lines().count(), 1);
}

#[test]
fn markdown_tells_what_each_difference_means() {
    let one = verification(&[12], Answer::Aborted(AbortCode::NO_OBJECT), false).written(Form::Markdown);
    let row =
        "| 2000h:00 Set\\|up | limits | at most 9 | 12 | a tool shows the value as wrong, and can't write it back |";
    assert!(one.contains(row), "{one}");
    assert!(one.contains("## May be configuration or state"), "{one}");
    let given_up = Verification { given_up: Some(Index(0x1100)), ..verification(&[5], constant(), false) };
    assert!(given_up.written(Form::Markdown).contains("from 1100h on nothing was looked at"));
    assert!(given_up.written(STYLE).contains("from 1100h on nothing was looked at"));
}

#[test]
fn texts_of_files_and_devices_do_not_act() {
    let one = verification(&[5], Answer::Value(vec![0x1B; 3]), false);
    for text in [one.written(STYLE), one.written(Form::Markdown), one.written(Form::Json)] {
        assert!(!text.contains(['\x1b', '\x07']), "{text}");
    }
}

#[test]
fn json_has_numbers_as_numbers() {
    let json = verification(&[12], Answer::Aborted(AbortCode::NO_OBJECT), false).written(Form::Json);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["schema"], "canvass/eds-verify/1");
    assert_eq!(json["summary"], serde_json::json!({ "differences": 2, "may_be_configuration_or_state": 1 }));
    let [limits, setting, missing] = [0, 1, 2].map(|at| json["differences"][at].clone());
    assert_eq!(
        (&limits["kind"], &limits["described"]["high"], &limits["found"]),
        (&"limits".into(), &9.into(), &12.into())
    );
    assert_eq!((&setting["weight"], &setting["counts"]), (&"may-be-configuration".into(), &false.into()));
    assert_eq!((&missing["index"], &missing["sub"]), (&0x2001.into(), &serde_json::Value::Null));
    assert_eq!(missing["found"]["abort"], 0x0602_0000);
}
