//! `canvass eds check`: output formats, exit statuses, selection, fixes.

use crate::running::{run, run_with_input};
use serde_json::Value;

const PLAIN: &str = include_str!("../../analyzer/tests/eds/plain.eds");

/// A folder with `plain.eds`, in which `from` is replaced by `to`.
fn folder(from: &str, to: &str) -> (tempfile::TempDir, String) {
    assert!(PLAIN.contains(from), "{from}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.eds");
    std::fs::write(&path, PLAIN.replacen(from, to, 1)).unwrap();
    (folder, path.display().to_string())
}

/// The exit status and the printed document.
fn json(args: &[&str]) -> (i32, Value) {
    let run = run(args);
    (
        run.status,
        serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}{}", run.stdout, run.stderr)),
    )
}

#[test]
fn a_finding_is_drawn_with_its_line_and_what_to_do() {
    let (_folder, path) = folder("SupportedObjects=2", "SupportedObjects=7");
    let shown = run(&["eds", "check", &path, "--fail-on", "warning", "--select", "eds/list"]);
    assert_eq!(shown.status, 1, "{}", shown.stderr);
    let expected = format!(
        "warning[eds/list/count]: the count of a list is not the number of its entries\n  --> {path}:40:18\n   |\n\
         40 | SupportedObjects=7\n   |                  ^ expected the number of entries, found \"2 entries\"\n   |\n   \
         = note: in [MandatoryObjects]\n   = help: can be fixed automatically: write 2\n\n1 file: no errors, 1 warning, no hints\n\
         1 can be fixed with --fix; --diff shows what would change\n"
    );
    assert_eq!(shown.stdout, expected);
    let plain = run(&["eds", "check", &path, "--ignore", "eds/list,eds/device,eds/pdo", "--fail-on", "warning"]);
    assert_eq!(plain.status, 0, "{}", plain.stdout);
}

/// A file with many hints of several rules: three lines by default, and all of them where they are asked for.
#[test]
fn hints_are_counted() {
    let unknown = (1..9).map(|n| format!("Colour{n}=red\n")).collect::<String>();
    let (_folder, path) = folder(
        "ParameterName=Setting",
        &format!("{unknown}ParameterName=\"Setting\"\nObjFlags=8\nDefaultValue=5 ; five\nPDOMapping=1"),
    );
    let told = run(&["eds", "check", &path]).stdout;
    let hints: Vec<&str> = told.lines().filter(|line| line.starts_with("hint")).collect();
    assert_eq!(hints.len(), 3, "{told}");
    assert!(
        hints[0].starts_with("hint[eds/field/unknown]: 8 × a field is not defined") && hints[0].contains(", …)"),
        "{told}"
    );
    assert!(hints[2].starts_with("hint: ") && hints[2].contains(" other rules"), "{told}");
    assert!(told.contains("\n--hints shows each hint with its line\n"), "{told}");
    let count = |args: &[&str]| run(args).stdout.lines().filter(|line| line.starts_with("hint[")).count();
    assert_eq!(count(&["eds", "check", &path, "--select", "eds/field/unknown"]), 8);
    let all = count(&["eds", "check", &path, "--hints"]);
    assert!(all > 10 && all == count(&["eds", "check", &path, "--fail-on", "hint"]), "{told}");
}

#[test]
fn what_is_hostile_in_a_file_does_not_act() {
    let hostile = "ParameterName=\x1b]0;x\x07\u{202E}abc\tx";
    let (_folder, path) = folder("ParameterName=Setting", hostile);
    for format in ["text", "json", "sarif", "junit", "markdown", "github"] {
        for color in ["always", "never"] {
            let shown = run(&["--color", color, "eds", "check", &path, "--hints", "--format", format]);
            assert!(
                shown.stdout.contains("eds/text/control-character") || format == "junit",
                "{format}: {}",
                shown.stdout
            );
            let acts = |text: &str| text.contains(['\x07', '\u{202E}']) || text.contains("\x1b]");
            assert!(!acts(&shown.stdout) && !acts(&shown.stderr), "{format}: {}", shown.stdout);
        }
    }
}

#[test]
fn json_says_where_and_how_to_mend() {
    let (_folder, path) = folder("CreationTime=09:00AM", "CreationTime=21:00");
    let (status, found) = json(&["eds", "check", &path, "--format", "json", "--ignore", "eds/pdo,eds/device"]);
    assert_eq!((status, &found["schema"]), (0, &Value::from("canvass/eds-check/1")));
    let findings = found["findings"].as_array().unwrap();
    let time = findings.iter().find(|finding| finding["rule"] == "eds/file/time").unwrap();
    assert_eq!((&time["line"], &time["column"], &time["end_column"]), (&7.into(), &14.into(), &19.into()));
    assert_eq!((&time["file"], &time["severity"]), (&Value::from(path.as_str()), &Value::from("warning")));
    assert_eq!(time["fix"]["edits"][0]["text"], "09:00PM");
    assert_eq!(found["summary"]["warnings"], 1);
}

/// The SARIF output has the properties that the schema of SARIF 2.1.0 requires.
#[test]
fn sarif_has_what_its_schema_requires() {
    let (_folder, path) = folder("NrOfTXPDO=1", "NrOfTXPDO=4\n; canvass: allow eds/device/pdo-count by contract\n");
    let (_, log) = json(&["eds", "check", &path, "--format", "sarif"]);
    assert_eq!((&log["version"], log["runs"].as_array().unwrap().len()), (&Value::from("2.1.0"), 1));
    let run = &log["runs"][0];
    assert_eq!(run["tool"]["driver"]["name"], "canvass");
    let rules = run["tool"]["driver"]["rules"].as_array().unwrap();
    let results = run["results"].as_array().unwrap();
    assert!(!results.is_empty());
    for result in results {
        let index = result["ruleIndex"].as_u64().unwrap() as usize;
        assert_eq!(rules[index]["id"], result["ruleId"]);
        assert!(result["message"]["text"].is_string() && !result["message"]["text"].as_str().unwrap().is_empty());
        assert!(["error", "warning", "note"].contains(&result["level"].as_str().unwrap()));
        let place = &result["locations"][0]["physicalLocation"];
        assert!(place["artifactLocation"]["uri"].is_string());
        if let Some(region) = place.get("region") {
            assert!(region["startLine"].as_u64().unwrap() >= 1 && region["startColumn"].as_u64().unwrap() >= 1);
        }
        for fix in result["fixes"].as_array().into_iter().flatten() {
            let change = &fix["artifactChanges"][0];
            assert!(change["artifactLocation"].is_object());
            assert!(change["replacements"].as_array().unwrap().iter().all(|one| one["deletedRegion"].is_object()));
        }
    }
    let waived = results.iter().find(|result| result["ruleId"] == "eds/device/pdo-count").unwrap();
    assert_eq!(waived["suppressions"][0]["justification"], "by contract");
}

#[test]
fn other_forms_name_rule_and_place() {
    let (_folder, path) = folder(
        "[ManufacturerObjects]\nSupportedObjects=1\n1=0x2000",
        "[ManufacturerObjects]\nSupportedObjects=1\n1=0x2001",
    );
    let of = |format| run(&["eds", "check", &path, "--format", format]);
    let github = of("github");
    assert_eq!(github.status, 1);
    let line = github.stdout.lines().find(|line| line.contains("eds/list/undescribed")).unwrap();
    let number = PLAIN.lines().position(|line| line == "1=0x2000").unwrap() + 1;
    let place = format!(",line={number},col=3,endLine={number},endColumn=9,title=eds/list/undescribed::");
    assert!(line.starts_with("::error ") && line.contains(&place), "{line}");
    let markdown = of("markdown").stdout;
    assert!(markdown.contains(&format!("| {number} | error | eds/list/undescribed |")), "{markdown}");
    let junit = of("junit").stdout;
    assert!(junit.contains("classname=\"canvass.eds.list\"") && junit.contains("failures=\"2\""), "{junit}");
}

/// One run writes every format, each as it would be on standard output.
#[test]
fn reports_go_to_files_beside_standard_output() {
    let (folder, path) = folder("SupportedObjects=2", "SupportedObjects=7");
    let formats = ["text", "json", "sarif", "junit", "markdown", "github"];
    let at = |format: &str| folder.path().join(format).display().to_string();
    let reports: Vec<String> = formats.iter().map(|format| format!("--report={format}={}", at(format))).collect();
    let reports: Vec<&str> = reports.iter().map(String::as_str).collect();
    let told = run(&[&["eds", "check", &path, "--fail-on", "warning"], &reports[..]].concat());
    assert_eq!(told.status, 1, "{}", told.stderr);
    for format in formats {
        let alone = run(&["eds", "check", &path, "--fail-on", "warning", "--format", format]).stdout;
        assert!(alone.contains("count"), "{format}: {alone}");
        assert_eq!(std::fs::read_to_string(at(format)).unwrap(), alone, "{format}");
    }
    assert_eq!(told.stdout, std::fs::read_to_string(at("text")).unwrap());
    let onto_itself = run(&["eds", "check", &path, "--report", &format!("json={path}")]);
    assert_eq!(onto_itself.status, 2, "{}", onto_itself.stderr);
}

#[test]
fn folders_and_standard_input_are_checked() {
    let (folder, _) = folder("Lines=1", "Lines=2");
    std::fs::write(folder.path().join("other.txt"), "none").unwrap();
    std::fs::create_dir(folder.path().join("deep")).unwrap();
    std::fs::write(folder.path().join("deep/b.EDS"), PLAIN).unwrap();
    let (_, found) = json(&["eds", "check", folder.path().to_str().unwrap(), "--format", "json"]);
    assert_eq!(found["summary"]["files"], 2);
    let input = run_with_input(&["eds", "check", "-", "--format", "github"], &PLAIN.replace("Lines=1", "Lines=2"));
    assert!(input.stdout.contains("::warning file=-,line="), "{}", input.stdout);
    let none = run(&["eds", "check", folder.path().join("other.txt").to_str().unwrap()]);
    assert!(none.status == 2 && none.stderr.contains("is no device description"), "{}", none.stderr);
    let slip = run(&["eds", "check", "-", "--select", "eds/lists"]);
    assert!(slip.status == 2 && slip.stderr.contains("\"eds/lists\" is no rule"), "{}", slip.stderr);
}

#[test]
fn files_are_mended_and_what_would_change_is_shown() {
    let (_folder, path) = folder("Lines=1", "Lines=4");
    let diff = run(&["eds", "check", &path, "--diff"]);
    assert_eq!(diff.status, 1, "{}", diff.stderr);
    let expected =
        format!("--- a/{path}\n+++ b/{path}\n@@ -34,5 +34,5 @@\n \n [Comments]\n-Lines=4\n+Lines=1\n Line1=one\n \n");
    assert_eq!(diff.stdout, expected);
    assert!(std::fs::read_to_string(&path).unwrap().contains("Lines=4"));
    let fixed = run(&["eds", "check", &path, "--fix", "--ignore", "eds/pdo"]);
    assert!(fixed.status == 0 && fixed.stderr.ends_with("plain.eds: 1 finding fixed\n"), "{}", fixed.stderr);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), PLAIN);
    let again = run(&["eds", "check", &path, "--diff"]);
    assert_eq!((again.status, again.stdout.as_str()), (0, ""));
    let input = run_with_input(&["eds", "check", "-", "--fix"], PLAIN);
    assert!(input.status == 2 && input.stderr.contains("standard input can't be overwritten"), "{}", input.stderr);
}

#[test]
fn rules_are_listed_and_explained() {
    let (_, rules) = json(&["list", "eds-rules", "--format", "json"]);
    let rules = rules.as_array().unwrap();
    assert!(rules.len() > 80, "{}", rules.len());
    for rule in rules {
        let explained = run(&["explain", rule["id"].as_str().unwrap()]);
        assert!(explained.status == 0 && explained.stdout.contains("Passes:"), "{rule}: {}", explained.stderr);
    }
}

/// The files that a DCF names are expected in its folder: the EDS from which it was made, and the files to be
/// downloaded.
#[test]
fn what_a_dcf_names_is_looked_for_beside_it() {
    let (folder, _) = folder("Lines=1", "Lines=1");
    let commissioning = "\n[DeviceComissioning]\nNodeID=5\nBaudrate=250\n";
    let dcf = PLAIN.replacen("[FileInfo]\n", "[FileInfo]\nLastEDS=plain.eds\n", 1) + commissioning;
    let path = folder.path().join("node.dcf");
    let found = |text: String| {
        std::fs::write(&path, text).unwrap();
        let (_, found) = json(&["eds", "check", path.to_str().unwrap(), "--format", "json", "--select", "eds/dcf"]);
        let findings = found["findings"].as_array().unwrap().clone();
        findings.iter().map(|one| (one["rule"].as_str().unwrap().to_owned(), one["line"].as_u64())).collect::<Vec<_>>()
    };
    assert_eq!(found(dcf.clone()), []);
    // A DCF may differ from its EDS in configured values, not in the properties of the device.
    let setting = "ParameterName=Setting\n";
    assert_eq!(found(dcf.replacen(setting, "ParameterName=Setting\nParameterValue=3\n", 1)), []);
    let other = dcf.replacen(setting, "ParameterName=Setting\nLowLimit=1\n", 1);
    assert_eq!(found(other.clone()), [("eds/dcf/other-eds".to_owned(), Some(2))]);
    std::fs::remove_file(folder.path().join("plain.eds")).unwrap();
    assert_eq!(found(other), [], "an EDS that is not there says nothing");
    let downloads = |name: &str| dcf.replacen(setting, &format!("ParameterName=Setting\nDownloadFile={name}\n"), 1);
    assert_eq!(found(downloads("program.bin")).len(), 1);
    std::fs::write(folder.path().join("program.bin"), "").unwrap();
    assert_eq!(found(downloads("program.bin")), []);
    // Files outside the folder are not looked for.
    assert_eq!(found(downloads("../../program.bin")), []);
    assert_eq!(found(downloads("C:\\\\programs\\\\program.bin")), []);
}

/// A finding that a comment in the file waives causes no change.
#[test]
fn a_difference_without_a_change_has_status_0() {
    let (_folder, path) = folder("Lines=1", "; canvass: allow eds/file/comment-count as it is\nLines=2");
    let nothing = run(&["eds", "check", &path, "--diff", "--select", "eds/file/comment-count"]);
    assert_eq!((nothing.status, nothing.stdout.as_str()), (0, ""));
    let (_folder, path) = folder("Lines=1", "Lines=2");
    let change = run(&["eds", "check", &path, "--diff", "--select", "eds/file/comment-count"]);
    assert!(change.status == 1 && change.stdout.contains("\n+Lines=1\n"), "{}", change.stdout);
}

/// Findings that an earlier check had are known, wherever their lines have moved; a new one still fails.
#[test]
fn a_baseline_leaves_new_findings() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (eds, baseline) = (path("device.eds"), path("known.sarif"));
    let wrong = "[FileInfo]\nFileName=device.eds\n[DeviceInfo]\nVendorName=x\n[MandatoryObjects]\nSupportedObjects=1\n\
        1=0x1000\n[1000]\nParameterName=Device type\nDataType=0x0099\nAccessType=ro\n";
    std::fs::write(&eds, wrong).unwrap();
    let sarif = run(&["eds", "check", &eds, "--fail-on", "hint", "--format", "sarif"]);
    assert_eq!(sarif.status, 1, "{}", sarif.stderr);
    std::fs::write(&baseline, &sarif.stdout).unwrap();
    let known = ["eds", "check", &eds, "--fail-on", "hint", "--baseline", &baseline];
    let same = run(&known);
    assert_eq!(same.status, 0, "{}", same.stdout);
    // The lines move, and another object is wrong.
    std::fs::write(&eds, format!("; a comment\n; another one\n{wrong}")).unwrap();
    assert_eq!(run(&known).status, 0, "{}", run(&known).stdout);
    let more = format!(
        "{wrong}[OptionalObjects]\nSupportedObjects=1\n1=0x1017\n[1017]\nParameterName=Heartbeat\n\
        DataType=0x0006\nAccessType=sometimes\n"
    );
    std::fs::write(&eds, more).unwrap();
    let new = run(&known);
    assert!(new.status == 1 && new.stdout.contains("sometimes") && !new.stdout.contains("0x0099"), "{}", new.stdout);
    let refused = run(&["eds", "check", &eds, "--baseline", &eds]);
    assert!(refused.status == 2 && refused.stderr.contains("expected SARIF"), "{}", refused.stderr);
}
