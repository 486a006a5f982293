//! Flaky cases in quarantine do not count until the last day of the quarantine has passed.

use crate::running::run;
use serde_json::Value;

const BUS: &str = "sim:reference-301+boot-up-twice";
const CASE: &str = "301/boot-up/reset-node";
const FILE: &str =
    "[[quarantine]]\ncase = \"301/boot-up/reset-node\"\nowner = \"Ann\"\nreason = \"ticket 12\"\nuntil = 2027-06-30\n";

/// A run on this day, with reports in every format: its exit status, its output and the reports.
fn tested(day: &str) -> (i32, String, [String; 4]) {
    let folder = tempfile::tempdir().unwrap();
    let waivers = folder.path().join("waivers.toml").display().to_string();
    std::fs::write(&waivers, FILE).unwrap();
    let formats = ["json", "junit", "html", "markdown"];
    let path = |format: &str| folder.path().join(format).display().to_string();
    let date = format!("{day}T12:00:00+00:00");
    let mut args = vec!["test", BUS, "--select", CASE, "--waivers", &waivers, "--date", &date];
    let reports = formats.map(|format| format!("{format}={}", path(format)));
    args.extend(reports.iter().flat_map(|report| ["--report", report]));
    let ended = run(&args);
    (ended.status, ended.stdout, formats.map(|format| std::fs::read_to_string(path(format)).unwrap()))
}

#[test]
fn a_failure_in_quarantine_is_shown_and_does_not_count() {
    let (status, shown, [json, junit, html, markdown]) = tested("2027-06-30");
    assert_eq!(status, 0, "{shown}");
    let told = "in quarantine until 2027-06-30 (Ann): ticket 12";
    for report in [&shown, &junit, &html, &markdown] {
        assert!(report.contains(told), "{report}");
    }
    assert!(
        shown.contains("✗ fail  301/boot-up/reset-node") && shown.contains("1 failed (1 of them in quarantine)"),
        "{shown}"
    );
    assert!(shown.lines().last().unwrap().starts_with("✗ 301/boot-up/reset-node  in quarantine"), "{shown}");
    assert!(junit.contains("failures=\"0\"") && junit.contains("skipped=\"1\""), "{junit}");
    let json: Value = serde_json::from_str(&json).unwrap();
    let case = &json["cases"][0];
    assert_eq!((&case["verdict"], &json["summary"]["fail"]), (&"fail".into(), &1.into()));
    assert_eq!(case["quarantine"], serde_json::json!({ "until": "2027-06-30", "owner": "Ann", "reason": "ticket 12" }));
}

#[test]
fn a_quarantine_that_is_over_holds_nothing() {
    let (status, shown, [json, junit, ..]) = tested("2027-07-01");
    assert_eq!(status, 1, "{shown}");
    assert!(shown.contains("(line 1, Ann) has expired on 2027-06-30: failures of the case count"), "{shown}");
    assert!(junit.contains("failures=\"1\"") && junit.contains("skipped=\"0\""), "{junit}");
    assert!(!json.contains("\"quarantine\": {"), "{json}");
}

/// A comparison shows a case in quarantine too, and does not fail for it; with `--fail-fast` the run goes on.
#[test]
fn what_is_in_quarantine_is_no_regression() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (waivers, old, new) = (path("waivers.toml"), path("old.json"), path("new.json"));
    std::fs::write(&waivers, FILE).unwrap();
    let select = ["--select", "301/boot-up/reset-node,301/identity/vendor-id", "--date", "2027-01-01T00:00:00Z"];
    let result = |bus: &str, file: &str, more: &[&str]| {
        let report = format!("json={file}");
        run(&[&["test", bus, "--report", &report, "--waivers", &waivers], &select[..], more].concat())
    };
    assert_eq!(result("sim:reference-301", &old, &[]).status, 0);
    let failed = result(BUS, &new, &["--fail-fast"]);
    assert_eq!(failed.status, 0, "{}", failed.stdout);
    let compared = run(&["compare", &old, &new]);
    assert_eq!(compared.status, 0, "{}", compared.stdout);
    assert!(compared.stdout.contains("other  verdict    301/boot-up/reset-node: pass -> fail"), "{}", compared.stdout);
    assert!(compared.stdout.contains("in quarantine until 2027-06-30 (Ann); "), "{}", compared.stdout);
}
