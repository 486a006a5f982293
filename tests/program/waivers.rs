//! Waivers by looking: a run writes entries for what failed, and `canvass waivers check` says what they are good for.

use crate::running::run;
use serde_json::Value;
use std::fs;

/// Devices whose faults show in one case, in many, in times, in values and in the protocol.
const DEVICES: [&str; 6] = [
    "sim:reference-301+sdo-toggle-unchecked",
    "sim:reference-301+sdo-read-only-wrong-code",
    "sim:reference-301+boot-up-twice",
    "sim:reference-301+vendor-id-zero",
    "sim:reference-301+sdo-length-unchecked+boot-up-missing",
    "sim:reference-406+heartbeat-period-doubled",
];

/// With the reasons added, the entries excuse every failure of the next run, and each of them is used.
#[test]
fn entries_for_what_failed_excuse_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    for (number, bus) in DEVICES.iter().enumerate() {
        let (waivers, result) = (path(&format!("{number}.toml")), path(&format!("{number}.json")));
        let report = format!("json={result}");
        let args = ["test", bus, "--date", "2026-11-28T12:00:00+00:00"];
        let first = run(&[&args[..], &["--write-waivers", &waivers, "--report", &report]].concat());
        assert_eq!(first.status, 1, "{bus}: {}", first.stderr);
        let text = fs::read_to_string(&waivers).unwrap();
        assert!(text.contains("expires = 2027-11-28"), "{text}");
        // Without a reason nothing is accepted.
        let refused = run(&["waivers", "check", &waivers, &result]);
        assert!(refused.status == 2 && refused.stderr.contains("expected a reason"), "{}", refused.stderr);
        fs::write(&waivers, text.replace("reason = \"\"", "reason = \"ticket 4711\"")).unwrap();
        let second = run(&[&args[..], &["--waivers", &waivers, "--format", "json"]].concat());
        let second: Value = serde_json::from_str(&second.stdout).unwrap();
        let failed = second["summary"]["fail"].as_u64().unwrap_or(0);
        assert_eq!(failed, 0, "{bus}: {}\n{text}", second["defects"]);
        let checked = run(&["waivers", "check", &waivers, &result]);
        assert_eq!(checked.status, 0, "{}", checked.stdout);
    }
}

/// One behaviour in many cases is one entry.
#[test]
fn an_entry_covers_a_defect_over_cases() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (waivers, result) = (path("waivers.toml"), path("result.json"));
    let report = format!("json={result}");
    let bus = "sim:reference-301+sdo-read-only-wrong-code";
    run(&["test", bus, "--select", "301/sdo", "--write-waivers", &waivers, "--report", &report]);
    let failed = serde_json::from_str::<Value>(&fs::read_to_string(&result).unwrap()).unwrap();
    let failed = failed["summary"]["fail"].as_u64().unwrap();
    let text = fs::read_to_string(&waivers).unwrap();
    assert!(failed > 4 && text.matches("[[waiver]]").count() == 2, "{failed} failed: {text}");
    assert!(text.contains("situation = \"read-only\""), "{text}");
    // An existing file is kept.
    let again = run(&["test", bus, "--select", "301/sdo/download", "--write-waivers", &waivers]);
    assert!(again.status == 2 && again.stderr.contains("--force"), "{}", again.stderr);
}

#[test]
fn what_excuses_nothing_says_what_is_near() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (waivers, result) = (path("waivers.toml"), path("result.json"));
    let report = format!("json={result}");
    run(&["test", "sim:reference-301+vendor-id-zero", "--select", "301/identity", "--report", &report]);
    let found: Value = serde_json::from_str(&fs::read_to_string(&result).unwrap()).unwrap();
    let breach =
        &found["cases"].as_array().unwrap().iter().find(|case| case["verdict"] == "fail").unwrap()["breaches"][0];
    let (object, does) = (breach["subject"].as_str().unwrap(), breach["observation"].as_str().unwrap());
    let entry = |more: &str| format!("[[waiver]]\nreason = \"x\"\n{more}\n");
    let exact = entry(&format!("case = \"301/identity/vendor-id\"\nobject = \"{object}\"\ndoes = \"{does}\""));
    let other = entry(&format!("case = \"301/identity/vendor-id\"\nobject = \"1018:02\"\ndoes = \"{does}\""));
    let wide = entry(&format!("case = \"301/*\"\nobject = \"{object}\"\ndoes = \"{does}\""));
    let over = entry(&format!(
        "case = \"301/identity/vendor-id\"\nobject = \"{object}\"\ndoes = \"{does}\"\nexpires = 2020-01-01"
    ));
    let check = |text: &str| {
        fs::write(&waivers, text).unwrap();
        let checked = run(&["waivers", "check", &waivers, &result, "--format", "json"]);
        let document: Value = serde_json::from_str(&checked.stdout).unwrap_or_else(|_| panic!("{}", checked.stderr));
        (checked.status, document["waivers"][0].clone())
    };
    let (status, used) = check(&exact);
    assert_eq!((status, &used["use"]), (0, &"used".into()), "{used}");
    assert!(used["breaches"].as_u64() > Some(0), "{used}");
    let (status, unused) = check(&other);
    assert_eq!((status, &unused["use"]), (1, &"unused".into()));
    assert!(unused["hint"][0].as_str().unwrap().starts_with(object), "{unused}");
    let (status, too_wide) = check(&wide);
    assert_eq!((status, &too_wide["hint"]), (1, &"its case could be 301/identity/vendor-id".into()));
    assert_eq!(check(&over).1["use"], "expired");
    // A waiver for everything is none.
    fs::write(&waivers, entry("object = \"*\"\ndoes = \"silence\"")).unwrap();
    let refused = run(&["waivers", "check", &waivers, &result]);
    assert!(
        refused.status == 2 && refused.stderr.contains("must not excuse a behaviour everywhere"),
        "{}",
        refused.stderr
    );
    fs::write(&waivers, entry("situation = \"readonly\"\nobject = \"*\"\ndoes = \"silence\"")).unwrap();
    let refused = run(&["waivers", "check", &waivers, &result]);
    assert!(refused.stderr.contains("no situation is called \"readonly\""), "{}", refused.stderr);
}
