//! `canvass-fleet decode`, `signals` and `diagnose` write the same tables as SQL.

use std::path::Path;
use std::process::{Command, Output};

fn run(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_canvass-fleet")).args(words).output().unwrap()
}

fn said(words: &[&str]) -> String {
    let ended = run(words);
    assert!(ended.status.success(), "{words:?}: {}", String::from_utf8_lossy(&ended.stderr));
    String::from_utf8(ended.stdout).unwrap()
}

fn sample() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/samples/kuebler-5.7.7.txt").display().to_string()
}

const COMMANDS: [(&str, &[&str]); 4] = [
    ("messages", &["decode"]),
    ("events", &["decode", "--events"]),
    ("signals", &["signals"]),
    ("findings", &["diagnose"]),
];

#[test]
fn as_text() {
    for (table, command) in COMMANDS {
        let by_sql = said(&["sql", &format!("SELECT * FROM {table}('{}')", sample()), "--format", "csv"]);
        assert_eq!(said(&[command, &[&sample(), "--format", "csv"]].concat()), by_sql, "{table}");
    }
}

#[test]
fn as_files_of_other_programs() {
    let folder = tempfile::tempdir().unwrap();
    for (table, command) in COMMANDS {
        for format in ["parquet", "arrow"] {
            let file = folder.path().join(format!("{table}.{format}")).display().to_string();
            said(&[command, &[&sample(), "--format", format, "--output", &file]].concat());
            let content = std::fs::read(&file).unwrap();
            assert!(content.len() > 300);
            if format == "parquet" {
                let count = |from: &str| said(&["sql", &format!("SELECT count(*) FROM {from}"), "--format", "csv"]);
                assert_eq!(count(&format!("'{file}'")), count(&format!("{table}('{}')", sample())), "{table}");
            }
        }
    }
}

#[test]
fn what_is_no_capture_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let (text, file) = (folder.path().join("a.log"), folder.path().join("a.csv"));
    std::fs::write(&text, "nothing that canvass knows\n").unwrap();
    let [text, file] = [text, file].map(|path| path.display().to_string());
    let ended = run(&["decode", &text, &sample(), "--format", "csv", "--output", &file]);
    assert_eq!(ended.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&ended.stderr).contains("1 file was passed over"), "{ended:?}");
    assert!(std::fs::read_to_string(&file).unwrap().lines().count() > 2, "the other one is written");
    assert_eq!(run(&["decode", "no such file"]).status.code(), Some(2));
}

/// A file of one answer is not written with two, one behind the other.
#[test]
fn two_answers_are_no_document() {
    let folder = tempfile::tempdir().unwrap();
    let two = "SELECT 1 AS a; SELECT 2 AS b";
    for format in ["csv", "parquet", "arrow"] {
        let file = folder.path().join(format);
        let ended = run(&["sql", two, "--format", format, "--output", &file.display().to_string()]);
        assert_eq!(ended.status.code(), Some(2), "{format}");
        assert!(String::from_utf8_lossy(&ended.stderr).contains("hold one answer"), "{ended:?}");
        assert!(!file.exists(), "{format}");
    }
    assert_eq!(said(&["sql", two, "--format", "json"]), "{\"a\":1}\n{\"b\":2}\n");
    assert_eq!(said(&["sql", "CREATE VIEW one AS SELECT 1 AS a; SELECT a FROM one", "--format", "csv"]), "a\n1\n");
}
