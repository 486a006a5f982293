//! The list of components: valid by the schema of CycloneDX, and complete.

use super::output;
use crate::dist::{components, file, system, tools};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::fs;
use std::process::Command;

/// A validator of CycloneDX, from its own library.
const VALIDATE: &str = "
import sys
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
wrong = JsonStrictValidator(SchemaVersion.from_version(sys.argv[2])).validate_str(open(sys.argv[1]).read())
sys.exit(str(wrong) if wrong else 0)
";

/// Validates the list, and looks for each library of the program in it.
pub fn validate() -> Result<String> {
    let list = file("components", "sbom")?;
    output(Command::new(tools::VENV.python).args(["-c", VALIDATE]).arg(&list).arg(components::SPECIFICATION))?;
    let list: Value = serde_json::from_slice(&fs::read(&list)?)?;
    let listed = list["components"].as_array().context("components")?;
    let tree = ["tree", "--package", "canvass", "--edges", "normal", "--prefix", "none", "--format", "{p}"];
    let tree = output(Command::new("cargo").args(tree).args(["--target", system::X86_64.target]))?;
    for library in tree.lines() {
        let mut words = library.split(' ');
        let (name, version) = (words.next().context("a name")?, words.next().context("a version")?);
        let is_it = |component: &Value| component["name"] == name && version[1..] == component["version"];
        let is_program = name == "canvass";
        ensure!(is_program || listed.iter().any(is_it), "{name} {version} is not listed");
    }
    let without: Vec<&Value> = listed.iter().filter(|one| one["licenses"].is_null()).map(|one| &one["name"]).collect();
    ensure!(without.is_empty(), "no licence is listed for {without:?}");
    Ok(format!("valid; {} components, all with licences", listed.len()))
}
