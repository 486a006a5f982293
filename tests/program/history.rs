//! Results over several releases: the changes from one to the next, and the release since which a case fails.

use crate::running::run;
use serde_json::Value;
use std::path::Path;

const CASES: &str = "301/boot-up/reset-node,301/heartbeat/period,301/identity/vendor-id";
/// Six releases, in which faults come and go.
const RELEASES: [(&str, &str); 6] = [
    ("1.0", ""),
    ("1.1", "+heartbeat-period-doubled"),
    ("1.2", "+heartbeat-period-doubled+boot-up-twice"),
    ("1.3", "+boot-up-twice"),
    ("1.4", ""),
    ("1.5", "+heartbeat-period-doubled"),
];

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The results of all releases.
fn results(folder: &Path) -> Vec<String> {
    let result = |(release, faults): &(&str, &str)| {
        let file = folder.join(format!("{release}.json")).display().to_string();
        let (bus, report) = (format!("sim:reference-301{faults}"), format!("json={file}"));
        let tested =
            run(&["test", &bus, "--select", CASES, "--note", &format!("release={release}"), "--report", &report]);
        assert!([0, 1].contains(&tested.status), "{}", tested.stderr);
        file
    };
    RELEASES.iter().map(result).collect()
}

#[test]
fn the_first_bad_release_of_each_case_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let files = results(folder.path());
    let page = folder.path().join("history.html").display().to_string();
    let mut args = vec!["history", "--format", "json", "--report"];
    let report = format!("html={page}");
    args.push(&report);
    args.extend(files.iter().map(String::as_str));
    let shown = run(&args);
    assert_eq!(shown.status, 0, "{}", shown.stderr);
    let history = json(&shown.stdout);
    assert_eq!(history["schema"], "canvass/history/1");
    let names: Vec<&str> =
        history["releases"].as_array().unwrap().iter().map(|release| release["name"].as_str().unwrap()).collect();
    assert_eq!(names, RELEASES.map(|release| release.0));
    let case = |id: &str| history["cases"].as_array().unwrap().iter().find(|case| case["id"] == id).unwrap().clone();
    let period = case("301/heartbeat/period");
    assert_eq!((&period["first_bad"], &period["became_bad"]), (&"1.1".into(), &serde_json::json!(["1.1", "1.5"])));
    assert_eq!(period["became_good"], serde_json::json!(["1.3"]));
    assert_eq!(case("301/boot-up/reset-node")["first_bad"], "1.2");
    assert_eq!(case("301/identity/vendor-id")["first_bad"], Value::Null);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("data-case=\"301/heartbeat/period\" data-first-bad=\"1.1\""));
    assert!(page.contains("data-case=\"301/boot-up/reset-node\" data-first-bad=\"1.2\""));
    let text = run(&[&["history"], &files.iter().map(String::as_str).collect::<Vec<_>>()[..]].concat()).stdout;
    assert!(text.contains("bad since 1.1, good again in 1.3, bad again since 1.5"), "{text}");
}

/// A failure that returns after a fix is distinguished from a new failure.
#[test]
fn a_regression_that_returns_is_told_from_a_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let files = results(folder.path());
    let args =
        ["compare", &files[4], &files[5], "--earlier", &files[0], "--earlier", &files[1], "--earlier", &files[2]];
    let compared = run(&[&args[..], &["--format", "json"]].concat());
    assert_eq!(compared.status, 1, "{}", compared.stderr);
    let changes = json(&compared.stdout)["changes"].clone();
    let change = changes.as_array().unwrap().iter().find(|change| change["subject"] == "301/heartbeat/period").unwrap();
    assert_eq!((&change["direction"], &change["returned"]), (&"worse".into(), &"1.2".into()));
    let text = run(&args).stdout;
    assert!(text.contains("again: it was bad in 1.2") && text.contains("1 for the worse, 1 of them again"), "{text}");
    let junit = run(&[&args[..], &["--format", "junit"]].concat()).stdout;
    assert!(junit.contains("type=\"returned\""), "{junit}");
    // Without the earlier releases, the first failure is new.
    let first = run(&["compare", &files[0], &files[1], "--format", "json"]);
    assert!(first.stdout.contains("\"returned\": null") && !first.stdout.contains("\"returned\": \""));
    let history =
        run(&[&["history", "--format", "json"], &files.iter().map(String::as_str).collect::<Vec<_>>()[..]].concat());
    let cases = json(&history.stdout)["cases"].clone();
    let period = cases.as_array().unwrap().iter().find(|case| case["id"] == "301/heartbeat/period").unwrap();
    assert_eq!(period["returned"], serde_json::json!(["1.5"]));
}

#[test]
fn samples_of_a_release_are_told_apart_from_releases() {
    let folder = tempfile::tempdir().unwrap();
    let files = results(folder.path());
    let (good, bad) = (format!("2.0={}", files[0]), format!("2.0={}", files[1]));
    let history = json(&run(&["history", &good, &bad, "--format", "json"]).stdout);
    assert_eq!(history["releases"].as_array().unwrap().len(), 1);
    let flaky = history["cases"].as_array().unwrap().iter().filter(|case| case["flaky"] == true);
    assert_eq!(flaky.map(|case| case["id"].as_str().unwrap()).collect::<Vec<_>>(), ["301/heartbeat/period"]);
    assert_eq!(run(&["history", &good, "--format", "junit"]).status, 2);
    assert_eq!(run(&["history", "Cargo.toml"]).status, 2);
}

/// A case that is tested no longer, a cancelled run, and a document of another version do not pass as a release.
#[test]
fn a_comparison_counts_what_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (old, new) = (path("old.json"), path("new.json"));
    let test = |bus: &str, select: &str, file: &str, more: &[&str]| {
        let report = format!("json={file}");
        run(&[&["test", bus, "--select", select, "--report", &report], more].concat())
    };
    test("sim:reference-301", CASES, &old, &[]);
    test("sim:reference-301", "301/identity/vendor-id", &new, &[]);
    let fewer = run(&["compare", &old, &new]);
    assert_eq!(fewer.status, 1, "{}", fewer.stdout);
    assert!(fewer.stdout.contains("worse  verdict    301/heartbeat/period: pass -> -"), "{}", fewer.stdout);
    assert_eq!(run(&["compare", &old, &new, "--allow-missing"]).status, 0);
    test("sim:reference-301+boot-up-twice", CASES, &new, &["--fail-fast"]);
    let ended = run(&["compare", &new, &new]);
    assert_eq!(ended.status, 1, "{}", ended.stdout);
    assert!(ended.stdout.contains("worse  run        the new run: - -> cancelled"), "{}", ended.stdout);
    let later = std::fs::read_to_string(&old).unwrap().replace("canvass/test/1", "canvass/test/2");
    std::fs::write(&new, later).unwrap();
    let unknown = run(&["compare", &old, &new]);
    assert!(unknown.status == 2 && unknown.stderr.contains("canvass/test/2"), "{}", unknown.stderr);
}

#[test]
fn a_comparison_has_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let files = results(folder.path());
    let mut args = vec!["compare".to_owned(), files[0].clone(), files[2].clone()];
    let formats = ["table", "json", "junit", "html", "markdown"];
    let out = |format: &str| folder.path().join(format!("compared.{format}")).display().to_string();
    args.extend(formats.iter().flat_map(|format| ["--report".to_owned(), format!("{format}={}", out(format))]));
    let compared = run(&args.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(compared.status, 1, "{}", compared.stderr);
    for format in formats {
        let report = std::fs::read_to_string(out(format)).unwrap();
        for told in ["301/heartbeat/period", "301/boot-up/reset-node", "pass", "fail", "2 for the worse"] {
            // JSON and JUnit print the counts in another form.
            let counts = told.starts_with('2') && ["json", "junit"].contains(&format);
            assert!(counts || report.contains(told), "{format} lacks {told}: {report}");
        }
    }
    let junit = std::fs::read_to_string(out("junit")).unwrap();
    assert!(junit.contains("failures=\"2\""), "{junit}");
}
