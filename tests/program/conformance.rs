//! `canvass test` and `canvass send` as a user runs them.

use crate::running::run;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

const ENCODER: &str = "sim:kuebler-sendix-58x8";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Every case of the catalogue is reported. All cases that the device's description and the permissions allow have run,
/// and none fails.
#[test]
fn the_simulated_encoder_passes() {
    let tested = run(&["test", ENCODER, "--format", "json"]);
    assert_eq!(tested.status, 0, "{}", tested.stderr);
    let report = json(&tested.stdout);
    assert_eq!(report["schema"], "canvass/test/1");
    let ids = |rows: &Value| -> BTreeSet<String> {
        rows.as_array().unwrap().iter().map(|row| row["id"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(ids(&report["cases"]), ids(&json(&run(&["list", "cases", "--format", "json"]).stdout)));
    let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
    for case in report["cases"].as_array().unwrap() {
        let verdict = case["verdict"].as_str().unwrap();
        *counts.entry(verdict).or_default() += 1;
        assert!(["pass", "deviation", "not_applicable"].contains(&verdict), "{case}");
        assert_eq!(case["reason"].is_null(), verdict == "pass", "{case}");
        let confidence = case["clause_confidence"].as_str().unwrap();
        assert!(["cited", "attested", "derived", "known", "unknown"].contains(&confidence), "{case}");
    }
    for (verdict, count) in report["summary"].as_object().unwrap() {
        assert_eq!(count.as_u64(), Some(counts.remove(verdict.as_str()).unwrap_or(0)), "{verdict}");
    }
    assert!(counts.is_empty(), "not in the summary: {counts:?}");
    // Exactly the cases that the dry run does not rule out have run.
    let forecast = run(&["test", ENCODER, "--dry-run"]).stdout;
    let may_run: Vec<&str> = forecast.lines().filter(|line| !line.contains("  (")).map(str::trim).collect();
    for id in may_run {
        let case = report["cases"].as_array().unwrap().iter().find(|case| case["id"] == id);
        assert_ne!(case.unwrap()["verdict"], "not_applicable", "{id}");
    }
}

#[test]
fn two_runs_give_the_same_bytes() {
    let once = || run(&["test", ENCODER, "--format", "json", "--seed", "7"]).stdout;
    let first = once();
    let report = json(&first);
    let reset = report["cases"].as_array().unwrap().iter().find(|case| case["id"] == "301/boot-up/reset-node");
    assert_eq!(reset.unwrap()["verdict"], "pass");
    assert_eq!(first, once());
}

#[test]
fn a_faulty_firmware_fails_with_reason_and_frames() {
    let address = format!("{ENCODER}+sdo-toggle-unchecked");
    let tested = run(&["test", &address, "--format", "json"]);
    assert_eq!(tested.status, 1);
    let report = json(&tested.stdout);
    let failed: Vec<&Value> =
        report["cases"].as_array().unwrap().iter().filter(|case| case["verdict"] == "fail").collect();
    let ids: Vec<&str> = failed.iter().map(|case| case["id"].as_str().unwrap()).collect();
    assert_eq!(
        ids,
        [
            "301/sdo/download/second-toggle",
            "301/sdo/download/segment-toggle",
            "301/sdo/upload/first-toggle",
            "301/sdo/upload/over-after-abort",
            "301/sdo/upload/repeated-toggle"
        ]
    );
    let reason = &failed[1]["reason"];
    assert_eq!(reason["expected"], "abort 0503 0000h toggle bit not alternated or no answer", "{reason}");
    assert!(reason["duty"].as_str().unwrap().starts_with("A segment whose toggle bit does not alternate"), "{reason}");
    assert_eq!(reason["actual"], "the confirmation of a download segment (30 00 00 00 00 00 00 00)", "{reason}");
    // The frames begin with the reset before the case, and contain the wrong answer.
    let frames = failed[1]["evidence"].as_array().unwrap();
    assert_eq!(
        (&frames[0]["id"], &frames[0]["data"], &frames[0]["direction"]),
        (&0.into(), &"813F".into(), &"tx".into())
    );
    let wrong = frames.iter().find(|frame| frame["id"] == 0x5BF && frame["data"] == "3000000000000000");
    let wrong = wrong.unwrap_or_else(|| panic!("{frames:?}"));
    assert!(wrong["t"].as_u64() > frames[0]["t"].as_u64(), "{wrong}");
    assert!(wrong["text"].as_str().unwrap().contains("confirmed, toggle 1"), "{wrong}");
    // The text output also shows the expected answer, and the frame that was sent.
    let shown = run(&["test", &address]).stdout;
    for part in [ids[1], "abort 0503 0000h toggle bit not alternated or no answer", "5BF#3000000000000000"] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
}

/// A device that boots twice fails the cases of both resets, for one reason. A second defect is reported separately.
#[test]
fn cases_that_fail_for_the_same_defect_are_told_together() {
    let cases = ["301/boot-up/reset-communication", "301/boot-up/reset-node"];
    let twice = "sim:reference-301+boot-up-twice";
    let text = run(&["test", twice, "--select", &cases.join(",")]).stdout;
    assert!(text.contains("Of 2 cases 2 failed, all for the same defect"), "{text}");
    let last: Vec<&str> = text.trim_end().lines().rev().take(2).collect();
    assert!(last[1].starts_with(&format!("✗ {}  ", cases[0])), "{text}");
    assert_eq!(last[0].trim(), format!("the same: {}", cases[1]));

    let both = [twice, "+vendor-id-zero"].concat();
    let select = [&cases[..], &["301/identity/vendor-id"]].concat().join(",");
    let report = json(&run(&["test", &both, "--select", &select, "--format", "json"]).stdout);
    let named: Vec<&Value> = report["defects"].as_array().unwrap().iter().map(|defect| &defect["cases"]).collect();
    assert_eq!(named, [&serde_json::json!(cases), &serde_json::json!(["301/identity/vendor-id"])]);
    let first = &report["defects"][0]["reason"];
    assert_eq!(
        first,
        &report["cases"].as_array().unwrap().iter().find(|case| case["id"] == cases[0]).unwrap()["reason"]
    );
}

fn ran(report: &Value) -> usize {
    report["cases"].as_array().unwrap().len()
}

/// A short run takes the cases that find most faults in their time, and the report says how many cases are left out.
#[test]
fn a_short_run_takes_the_cases_that_find_most() {
    let tested = run(&["test", "sim:reference-301", "--for", "60s", "--format", "json"]);
    assert_eq!(tested.status, 0, "{}", tested.stderr);
    let report = json(&tested.stdout);
    assert!(report["duration_ns"].as_u64().unwrap() <= 60_000_000_000 && report["cancelled"] == false);
    assert!((50..300).contains(&ran(&report)), "{}", ran(&report));
    let told = report["notices"][0].as_str().unwrap();
    let numbers: Vec<usize> = told.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [run, of, caught, known] = numbers[..] else { panic!("{told}") };
    assert_eq!(run, ran(&report));
    // In a seventh of the time more than half of all faults are found.
    assert!(run * 2 < of && caught * 2 > known, "{told}");
}

#[test]
fn a_quick_run_catches_most_faults_with_fewer_cases() {
    let select = ["--select", "301/sdo"];
    let report = |more: &[&str]| {
        let tested = run(&[&["test", "sim:reference-301", "--format", "json"], &select[..], more].concat());
        json(&tested.stdout)
    };
    let (quick, full) = (report(&["--profile", "quick"]), report(&["--profile", "full"]));
    assert!(ran(&quick) * 3 < ran(&full) * 2, "{} of {}", ran(&quick), ran(&full));
    assert!(quick["duration_ns"].as_u64() < full["duration_ns"].as_u64());
    assert_eq!(quick["summary"]["fail"], 0);
}

#[test]
fn no_case_is_no_success() {
    let tested = run(&["test", ENCODER, "--select", "nonsense"]);
    assert_eq!(tested.status, 3);
    assert!(tested.stderr.contains("no case was executed"), "{}", tested.stderr);
}

#[test]
fn mistakes_have_their_status() {
    for (args, status, says) in [
        (&["test", "sim:no-such-model"][..], 2, "kuebler-sendix-58x8"),
        (&["test", "sim:kuebler-sendix-58x8+no-such-fault"], 2, "canvass list faults"),
        (&["test", "can0", "--node", "1"], 3, "CAN"),
        (&["test", "sim:kuebler-sendix-58x8:63", "--node", "5"], 3, "node 5 does not answer"),
        (&["test", ENCODER, "--report", "html=/no/such/folder/x.html"], 2, "can't write"),
        (&["send", ENCODER, "63F#4"], 2, "position"),
        (&["explain", "nonsense"], 2, "nothing has the id"),
    ] {
        let ended = run(args);
        assert_eq!(ended.status, status, "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(says), "{args:?}: {}", ended.stderr);
    }
}

/// Writing and reading 6000h, as Kübler's manual prints it (5.3.7.4).
#[test]
fn send_shows_request_and_response() {
    let sent = run(&["send", ENCODER, "63F#2B00600001000000", "63F#4000600000000000"]);
    assert_eq!(sent.status, 0, "{}", sent.stderr);
    let lines: Vec<&str> = sent.stdout.lines().collect();
    assert_eq!(lines.len(), 4);
    for (line, frame) in lines.iter().zip([
        "63F  2B 00 60 00 01 00 00 00",
        "5BF  60 00 60 00 00 00 00 00",
        "63F  40 00 60 00 00 00 00 00",
        "5BF  4B 00 60 00 01 00 00 00",
    ]) {
        assert!(line.contains(frame), "{line}");
    }
    assert!(lines[3].contains("Operating parameters = 1"));
}

#[test]
fn what_there_is_can_be_listed_and_explained() {
    for what in ["cases", "situations", "models", "faults", "formats"] {
        let listed = json(&run(&["list", what, "--format", "json"]).stdout);
        let rows = listed.as_array().unwrap();
        assert!(!rows.is_empty());
        for row in rows {
            let id = row["id"].as_str().unwrap();
            assert!(!row["summary"].as_str().unwrap().is_empty(), "{id}");
            if what == "faults" {
                assert!(row["model"].is_string() && row["fuzz"].is_boolean(), "{id}");
            }
        }
        let id = rows[0]["id"].as_str().unwrap();
        assert!(run(&["explain", id]).stdout.starts_with(id));
    }
    // `explain` lists the allowed answers of a case, and the cases of a situation.
    let case = run(&["explain", "301/sdo/download/read-only"]).stdout;
    assert!(case.contains("allows     0601 0002h (read-only)"), "{case}");
    let situation = run(&["explain", "repeated-toggle"]).stdout;
    let rows = ["allowed    0503 0000h or no answer", "CiA 301 7.2.4.3.2", "301/sdo/download/segment-toggle"];
    assert!(rows.iter().all(|row| situation.contains(row)), "{situation}");
}

#[test]
fn all_reports_of_a_run_are_written() {
    let folder = env!("CARGO_TARGET_TMPDIR");
    let files: Vec<String> = ["html", "junit", "json", "markdown"]
        .iter()
        .map(|format| format!("{format}={folder}/report.{format}"))
        .collect();
    let mut args = vec!["test", ENCODER];
    args.extend(files.iter().flat_map(|file| ["--report", file]));
    assert_eq!(run(&args).status, 0);
    for file in files {
        let path = file.split_once('=').unwrap().1;
        let text = std::fs::read_to_string(path).unwrap();
        let case = match path.ends_with("junit") {
            true => "name=\"period\" classname=\"301.heartbeat\"",
            false => "301/heartbeat/period",
        };
        assert!(text.contains(case), "{path} does not tell of a case");
    }
}

fn temporary(name: &str, text: &str) -> String {
    let path = format!("{}/{name}", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&path, text).unwrap();
    path
}

const FAULTY: &str = "sim:reference-301+heartbeat-period-doubled";

#[test]
fn waivers_are_applied_and_idle_ones_are_told_of() {
    let file = temporary(
        "waivers.toml",
        "[[waiver]]\ncase = \"301/heartbeat/*\"\nobject = \"heartbeat\"\ndoes = \"time *\"\n\
         reason = \"slow timer, ticket 7\"\n\n\
         [[waiver]]\ncase = \"301/heartbeat/off\"\nobject = \"heartbeat\"\ndoes = \"count *\"\nreason = \"old\"\n\
         expires = 2020-01-01\n",
    );
    let tested = run(&[
        "test",
        FAULTY,
        "--select",
        "301/heartbeat/period,301/heartbeat/off",
        "--waivers",
        &file,
        "--format",
        "json",
    ]);
    assert_eq!(tested.status, 0, "{}", tested.stderr);
    let report = json(&tested.stdout);
    let case = report["cases"].as_array().unwrap().iter().find(|case| case["id"] == "301/heartbeat/period").unwrap();
    assert_eq!((&case["verdict"], &case["waiver_line"]), (&"deviation".into(), &1.into()));
    assert!(case["documented"].as_str().unwrap().contains("ticket 7"));
    assert!(report["notices"].to_string().contains("expired on 2020-01-01"), "{}", report["notices"]);
    let bad = temporary(
        "bad-waivers.toml",
        "\n[[waiver]]\ncase = \"301/no-such/*\"\nobject = \"device\"\ndoes = \"silence\"\nreason = \"x\"\n",
    );
    let refused = run(&["test", FAULTY, "--waivers", &bad]);
    assert_eq!(refused.status, 2);
    assert!(refused.stderr.contains("line 2") && refused.stderr.contains("301/no-such/*"), "{}", refused.stderr);
}

/// A waiver for one object does not cover other objects.
#[test]
fn a_waiver_for_one_object_of_an_every_case_leaves_the_others_failing() {
    let case = "301/sdo/download/every-read-only";
    let waived = |does: &str| {
        let text = format!("[[waiver]]\ncase = \"{case}\"\nobject = \"1000:00\"\ndoes = \"{does}\"\nreason = \"x\"\n");
        let file = temporary("one-object.toml", &text);
        let device = "sim:reference-301+sdo-read-only-wrong-code";
        let tested = run(&["test", device, "--select", case, "--waivers", &file, "--format", "json"]);
        let report = json(&tested.stdout);
        let breaches = report["cases"][0]["breaches"].as_array().unwrap().clone();
        let of = |verdict: &str| -> Vec<String> {
            let those = breaches.iter().filter(|breach| breach["verdict"] == verdict);
            those.map(|breach| breach["subject"].as_str().unwrap().to_owned()).collect()
        };
        (tested.status, of("deviation"), of("fail"))
    };
    let (status, excused, failed) = waived("abort 0800 0022h");
    assert_eq!((status, &*excused), (1, &["1000h:00".to_owned()][..]));
    assert!(failed.len() > 20 && failed.contains(&"1001h:00".to_owned()), "{failed:?}");
    // The waiver does not cover another answer of the same object.
    let (status, excused, failed) = waived("abort 0601 0000h");
    assert_eq!((status, excused.len()), (1, 0));
    assert!(failed.contains(&"1000h:00".to_owned()));
}

/// A measured value that has changed during a case is not called one that the tester could not set back.
#[test]
fn a_value_that_the_device_sets_is_not_put_back() {
    let case = "301/sdo/download/every-read-only";
    let tested = run(&["test", "sim:kuebler-sendix-f58m~rpm=0.02", "--select", case]);
    assert_eq!(tested.status, 0, "{}", tested.stdout);
    assert!(!tested.stdout.contains("could not be set back"), "{}", tested.stdout);
    assert!(tested.stdout.contains("The device is as it was before the run"), "{}", tested.stdout);
    assert!(tested.stdout.contains("values that the device sets itself differ: 6004h:00"), "{}", tested.stdout);
}

#[test]
fn two_results_are_compared() {
    let result = |bus: &str, name: &str| {
        let tested = run(&["test", bus, "--select", "301/heartbeat,301/identity", "--format", "json"]);
        temporary(name, &tested.stdout)
    };
    let (old, new) = (result("sim:reference-301", "old.json"), result(FAULTY, "new.json"));
    let worse = run(&["compare", &old, &new]);
    assert_eq!(worse.status, 1, "{}", worse.stderr);
    assert!(worse.stdout.contains("301/heartbeat/period: pass -> fail"), "{}", worse.stdout);
    let better = run(&["compare", &new, &old, "--format", "json"]);
    assert_eq!(better.status, 0);
    let changes = json(&better.stdout);
    assert_eq!(changes["schema"], "canvass/compare/1");
    // The reverse comparison shows the same changes with the opposite direction, and no others.
    let subjects = |changes: &Value, direction: &str| -> BTreeSet<String> {
        let changes = changes["changes"].as_array().unwrap().iter();
        let changes = changes.filter(|change| change["direction"] == direction);
        changes.map(|change| format!("{} {}", change["kind"], change["subject"])).collect()
    };
    let there = json(&run(&["compare", &old, &new, "--format", "json"]).stdout);
    let got_worse = subjects(&there, "worse");
    assert!(got_worse.contains("\"verdict\" \"301/heartbeat/period\""), "{got_worse:?}");
    assert_eq!((subjects(&changes, "better"), subjects(&changes, "worse")), (got_worse, BTreeSet::new()));
    assert_eq!(changes["summary"]["better"], there["summary"]["worse"]);
    assert!(run(&["compare", &old, &old]).stdout.ends_with("\nno difference\n"));
    assert_eq!(run(&["compare", &old, "/no/such/file"]).status, 2);
}

#[test]
fn the_selftest_detects_and_counts() {
    let tested = run(&["selftest", "--select", "301/heartbeat", "--format", "json"]);
    assert_eq!(tested.status, 0, "{}{}", tested.stdout, tested.stderr);
    let matrix = json(&tested.stdout);
    let summary = &matrix["summary"];
    // The matrix has a row for each fault that these cases are meant to detect. Every fault is detected, and each of
    // these cases detects a fault.
    let catalogue = json(&run(&["list", "cases", "--format", "json"]).stdout);
    let cases: Vec<&str> = catalogue.as_array().unwrap().iter().map(|case| case["id"].as_str().unwrap()).collect();
    let rows = matrix["matrix"].as_array().unwrap();
    assert_eq!(summary["faults"].as_u64(), Some(rows.len() as u64));
    assert_eq!(summary["detected"], summary["faults"], "{summary}");
    let found: BTreeSet<&str> =
        rows.iter().flat_map(|row| row["failed"].as_array().unwrap()).map(|case| case.as_str().unwrap()).collect();
    let selected: BTreeSet<&str> = cases.into_iter().filter(|id| id.starts_with("301/heartbeat/")).collect();
    assert_eq!(found, selected, "each of these cases finds a fault");
    assert_eq!((&summary["false_alarms"], &summary["vacuous_cases"]), (&0.into(), &0.into()));
    assert!(matrix["matrix"][0]["failed"].is_array() && matrix["matrix"][0]["model"].is_string());
}

/// The recording of a run can be decoded, and marks the cases.
#[test]
fn a_run_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.log", "run.pcapng", "run.mcap"] {
        let file = folder.path().join(name).display().to_string();
        let tested = run(&["test", "sim:reference-301", "--select", "301/sdo/upload/expedited", "--record", &file]);
        assert_eq!(tested.status, 0, "{}", tested.stderr);
        let decoded = run(&["decode", &file]).stdout;
        assert!(decoded.contains("1000h:00") && decoded.contains("# case 301/sdo"), "{name}: {decoded}");
    }
}

#[test]
fn a_case_can_be_repeated_and_forecast() {
    let repeated =
        run(&["test", "sim:reference-301", "--select", "301/identity/names", "--repeat", "3", "--format", "json"]);
    let case = &json(&repeated.stdout)["cases"][0];
    assert_eq!((case["repetitions"].as_array().unwrap().len(), &case["flaky"]), (3, &false.into()));
    let forecast = run(&["test", "can0", "--node", "1", "--select", "301/store,301/identity", "--dry-run"]);
    assert_eq!(forecast.status, 0);
    assert!(forecast.stdout.contains("301/store/persists  (only with --allow nvm)"), "{}", forecast.stdout);
    assert!(forecast.stderr.contains("in about"), "{}", forecast.stderr);
}

/// A forecast names the capabilities that the device lacks for the cases, according to the device's description.
#[test]
fn a_forecast_says_what_is_needed() {
    let args = ["test", "can0", "--node", "1", "--device", "conformance/device/models/lika-ax58.eds", "--dry-run"];
    let forecast = run(&[&args[..], &["--select", "301/tpdo,301/sync"]].concat());
    let line = forecast.stdout.lines().find(|line| line.starts_with("301/sync/period")).unwrap_or_default();
    assert!(line.contains("(needs a SYNC producer"), "{}{}", forecast.stdout, forecast.stderr);
    let unreadable = run(&["test", "can0", "--node", "1", "--device", "no-such.eds", "--dry-run"]);
    assert_eq!(unreadable.status, 2, "{}", unreadable.stderr);
}

/// Every report of a run ends with the changes of the object dictionary.
#[test]
fn the_dictionary_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    let [page, text] = ["run.html", "run.md"].map(|name| folder.path().join(name));
    let (html, markdown) = (format!("html={}", page.display()), format!("markdown={}", text.display()));
    let args = ["test", "sim:reference-301", "--select", "301/heartbeat", "--report", &html, "--report", &markdown];
    let shown = run(&args);
    assert_eq!(shown.status, 0, "{}{}", shown.stdout, shown.stderr);
    let [page, text] = [page, text].map(|path| std::fs::read_to_string(path).unwrap());
    for report in [&shown.stdout, &page, &text] {
        assert!(report.contains("The device is as it was before the run ("), "{report}");
    }
    let document = json(&run(&["test", "sim:reference-301", "--select", "301/heartbeat", "--format", "json"]).stdout);
    let comparison = &document["comparison"];
    assert_eq!((&comparison["as_found"], &comparison["complete"]), (&true.into(), &true.into()), "{comparison}");
    assert!(comparison["objects"].as_u64().unwrap() > 200 && comparison["commands"].as_array().unwrap().is_empty());
}

/// The tester waits up to a second for a device that answers after 900 ms, unless the user sets a shorter time.
#[test]
fn waiting_times_can_be_set() {
    const SLOW: &str = "sim:reference-301~~answers-in-900-ms";
    let tested = |timeouts: &str| run(&["test", SLOW, "--select", "301/identity/vendor-id", "--timeout", timeouts]);
    let patient = tested("sdo=1s");
    assert_eq!(patient.status, 0, "{}{}", patient.stdout, patient.stderr);
    let impatient = tested("sdo=500ms,boot-up=6s");
    assert_ne!(impatient.status, 0, "{}", impatient.stdout);
    for wrong in ["sdo", "sdo=0", "dinner=5"] {
        assert_eq!(run(&["test", ENCODER, "--timeout", wrong]).status, 2, "{wrong}");
    }
}
