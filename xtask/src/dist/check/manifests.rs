//! The manifests for Windows: valid by the schemas of their package managers.

use super::output;
use crate::dist::{manifests, tools};
use anyhow::{Context, Result};
use std::process::Command;

/// Validates a manifest by a schema.
const VALIDATE: &str = "
import json, sys, jsonschema, yaml
schema = json.load(open(sys.argv[2]))
jsonschema.validators.validator_for(schema)(schema).validate(yaml.safe_load(open(sys.argv[1])))
";
/// An address that nobody has: manifests that are only checked name it.
const ADDRESS: &str = "https://canvass.invalid/releases";

/// Makes the manifests, and validates each.
pub fn validate() -> Result<String> {
    tools::VENV.install()?;
    for file in manifests::at(ADDRESS)? {
        let part = manifests::WINGET.iter().find(|part| file.contains(*part));
        let schema = part.map_or_else(|| "scoop.json".to_owned(), |part| format!("winget-{part}-1.9.0.json"));
        let mut python = Command::new(tools::VENV.python);
        python.args(["-c", VALIDATE, &format!("{}/{file}", crate::dist::FOLDER)]);
        output(python.arg(format!("packaging/schemas/{schema}"))).with_context(|| file.clone())?;
        std::fs::remove_file(std::path::Path::new(crate::dist::FOLDER).join(file))?;
    }
    Ok("valid by their schemas".to_owned())
}
