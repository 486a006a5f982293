//! Runs `canvass`, whose output the answers must equal.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The path of the program: CANVASS_PROGRAM, or the program that `cargo build` made in the folder above.
fn program() -> PathBuf {
    let built = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/debug/canvass");
    let program = std::env::var_os("CANVASS_PROGRAM").map_or_else(built, PathBuf::from);
    assert!(program.exists(), "{} is not there: cargo build in the folder above", program.display());
    program
}

fn output(arguments: &[&str], capture: &Path) -> String {
    let ended = Command::new(program()).args(arguments).arg(capture).output().unwrap();
    String::from_utf8(ended.stdout).unwrap()
}

/// The JSON Lines that the program prints, without the name of the schema.
pub fn lines(arguments: &[&str], capture: &Path) -> Vec<Value> {
    let without_schema = |line: &str| {
        let mut value: Value = serde_json::from_str(line).unwrap();
        value.as_object_mut().unwrap().remove("schema");
        value
    };
    output(arguments, capture).lines().map(without_schema).collect()
}

/// The JSON document that the program prints.
pub fn document(arguments: &[&str], capture: &Path) -> Value {
    serde_json::from_str(&output(arguments, capture)).unwrap()
}

/// The document that the program writes into a file, whose name is the last argument.
pub fn written(arguments: &[&str], capture: &Path) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("document.json");
    output(&[arguments, &[file.to_str().unwrap()]].concat(), capture);
    serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap()
}
