//! `canvass test` and `canvass send` as a user meets them.

use crate::running::run;
use serde_json::Value;

const ENCODER: &str = "sim:kuebler-sendix-58x8";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn the_simulated_encoder_passes() {
    let tested = run(&["test", ENCODER, "--format", "json"]);
    assert_eq!(tested.status, 0, "{}", tested.stderr);
    let report = json(&tested.stdout);
    assert_eq!(report["schema"], "canvass/test/1");
    let cases = report["cases"].as_array().unwrap();
    assert!(cases.len() >= 12);
    for case in cases {
        assert!(!case["clause_confidence"].as_str().unwrap().is_empty(), "{case}");
        assert_ne!(case["verdict"], "fail", "{case}");
        assert_ne!(case["verdict"], "error", "{case}");
    }
    assert!(report["summary"]["pass"].as_u64().unwrap() >= 12);
}

#[test]
fn two_runs_give_the_same_bytes() {
    let once = || run(&["test", ENCODER, "--format", "json", "--seed", "7"]).stdout;
    assert_eq!(once(), once());
}

#[test]
fn a_faulty_firmware_fails_with_reason_and_frames() {
    let address = format!("{ENCODER}+sdo-toggle-unchecked");
    let tested = run(&["test", &address, "--format", "json"]);
    assert_eq!(tested.status, 1);
    let report = json(&tested.stdout);
    let failed = report["cases"].as_array().unwrap().iter().find(|case| case["verdict"] == "fail").unwrap();
    for part in ["duty", "expected", "actual"] {
        assert!(!failed["reason"][part].as_str().unwrap().is_empty(), "{failed}");
    }
    let frame = &failed["evidence"][0];
    assert!(frame["t"].is_u64() && frame["id"].is_u64() && frame["data"].is_string() && frame["text"].is_string());
    let shown = run(&["test", &address]);
    assert!(shown.stdout.contains("expected") && shown.stdout.contains("63F#") || shown.stdout.contains("63F"));
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
        (&["explain", "nonsense"], 2, "nothing is called"),
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
    // A case says what it allows, and the situation which cases ask it.
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
        assert!(std::fs::metadata(path).unwrap().len() > 1000, "{path}");
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

/// Who accepts what one object does has not accepted it of the others.
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
    // Another answer of the same object is not what was accepted.
    let (status, excused, failed) = waived("abort 0601 0000h");
    assert_eq!((status, excused.len()), (1, 0));
    assert!(failed.contains(&"1000h:00".to_owned()));
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
    assert!(changes["summary"]["better"].as_u64().unwrap() >= 1);
    assert!(run(&["compare", &old, &old]).stdout.starts_with("no difference\n"));
    assert_eq!(run(&["compare", &old, "/no/such/file"]).status, 2);
}

#[test]
fn the_selftest_detects_and_counts() {
    let tested = run(&["selftest", "--select", "301/heartbeat", "--format", "json"]);
    assert_eq!(tested.status, 0, "{}{}", tested.stdout, tested.stderr);
    let matrix = json(&tested.stdout);
    let summary = &matrix["summary"];
    assert!(summary["faults"].as_u64().unwrap() >= 8 && summary["detected"] == summary["faults"], "{summary}");
    assert_eq!((&summary["false_alarms"], &summary["vacuous_cases"]), (&0.into(), &0.into()));
    assert!(matrix["matrix"][0]["failed"].is_array() && matrix["matrix"][0]["model"].is_string());
}

/// The traffic of a run can be decoded, and the cases are marked in it.
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

/// What a device would need for the cases that do not apply is known beforehand, by its description.
#[test]
fn a_forecast_says_what_is_needed() {
    let args = ["test", "can0", "--node", "1", "--device", "conformance/device/models/lika-ax58.eds", "--dry-run"];
    let forecast = run(&[&args[..], &["--select", "301/tpdo,301/sync"]].concat());
    let line = forecast.stdout.lines().find(|line| line.starts_with("301/sync/period")).unwrap_or_default();
    assert!(line.contains("(needs a SYNC producer"), "{}{}", forecast.stdout, forecast.stderr);
    let unreadable = run(&["test", "can0", "--node", "1", "--device", "no-such.eds", "--dry-run"]);
    assert_eq!(unreadable.status, 2, "{}", unreadable.stderr);
}

/// Every run ends with what it has made of the object dictionary, in every report.
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

/// What is waited for can be set: a device that answers after 300 µs is too slow for nobody but an impossible tester.
#[test]
fn waiting_times_can_be_set() {
    let slow =
        run(&["test", ENCODER, "--select", "301/identity", "--timeout", "sdo=1ms,boot-up=6", "--tolerance", "1"]);
    assert!([0, 1, 3].contains(&slow.status));
    for wrong in ["sdo", "sdo=0", "dinner=5"] {
        assert_eq!(run(&["test", ENCODER, "--timeout", wrong]).status, 2, "{wrong}");
    }
}

/// `docs/cases.md` is what the program prints.
#[test]
fn the_catalogue_page_is_current() {
    let page = std::fs::read_to_string(format!("{}/docs/cases.md", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let printed = run(&["list", "cases", "--format", "markdown"]).stdout;
    assert!(page == printed, "run: canvass list cases --format markdown > docs/cases.md");
}
