//! The release since which a case is bad, whatever happened in between.

use super::*;
use crate::document::{Form, Report, Style};
use serde_json::json as value;

const HOSTILE: &str = "<script>alert(1)</script>\u{1b}[2J|";

fn result(verdicts: &[(&str, &str)]) -> TestResult {
    let case = |(id, verdict): &(&str, &str)| {
        value!({ "id": id, "verdict": verdict, "reason": null, "duration_ns": 7_000_000,
                 "measurements": [{ "name": "period", "unit": "ns", "value": 3_000_000 }] })
    };
    let document = value!({
        "schema": "canvass/test/1",
        "device": { "software_version": HOSTILE },
        "cases": verdicts.iter().map(case).collect::<Vec<_>>(),
    });
    crate::results::read(&document.to_string()).unwrap()
}

fn history() -> History {
    let release = |name: &str, results: &[&[(&str, &str)]]| Release {
        name: name.to_owned(),
        results: results.iter().map(|verdicts| result(verdicts)).collect(),
    };
    History::of(&[
        release("1.0", &[&[("a", "pass"), ("b", "fail"), ("gone", "pass")]]),
        release("1.1", &[&[("a", "fail"), ("b", "pass")], &[("a", "pass"), ("b", "pass")]]),
        release(HOSTILE, &[&[("a", "fail"), ("b", "pass"), ("new", "pass")]]),
        release("1.3", &[&[("a", "pass"), ("b", "fail"), ("new", "error")]]),
    ])
}

fn course(id: &str) -> Course {
    let history = history();
    history.cases.iter().find(|row| row.id == id).unwrap().course()
}

#[test]
fn the_first_bad_release_of_each_case_is_found() {
    let a = course("a");
    assert_eq!((a.first_bad, a.became_bad, a.became_good), (Some(1), vec![1], vec![3]));
    assert!(a.returned.is_empty(), "bad once");
    assert_eq!(course("b").returned, [3], "bad, fixed, bad again");
    let b = course("b");
    assert_eq!((b.first_bad, b.became_bad, b.became_good), (Some(0), vec![0, 3], vec![1]));
    let new = course("new");
    assert_eq!((new.first_bad, new.new_in, new.gone_in), (Some(3), Some(2), None));
    assert_eq!((course("gone").gone_in, course("gone").first_bad), (Some(1), None));
}

#[test]
fn samples_that_differ_are_flaky_and_the_worst_counts() {
    let history = history();
    let cell = &history.cases[0].cells[1];
    assert_eq!((cell.kind(), cell.flaky, cell.duration_ns), (Some(Kind::Fail), true, Some(7_000_000)));
    assert!(!history.cases[0].cells[2].flaky);
}

#[test]
fn every_format_tells_it_and_harms_nobody() {
    let history = history();
    // On a terminal and in JSON, markup is plain text.
    let text = Form::Text(Style::default());
    for (form, is_markup) in [(text, false), (Form::Json, false), (Form::Markdown, true), (Form::Html, true)] {
        let mut out = Vec::new();
        history.write(form, &mut out).unwrap();
        let shown = String::from_utf8(out).unwrap();
        assert!(shown.contains("1.1") && shown.contains("1.3") && shown.contains("gone"), "{shown}");
        assert!(!shown.contains(['\u{1b}']), "{shown}");
        assert!(!is_markup || !shown.contains("<script>alert"), "{shown}");
    }
    let mut out = Vec::new();
    history.json(&mut out).unwrap();
    let document: serde_json::Value = serde_json::from_slice(&out).unwrap();
    assert_eq!(
        (&document["cases"][0]["first_bad"], &document["cases"][1]["became_bad"][1]),
        (&"1.1".into(), &"1.3".into())
    );
}
