//! The npm packages: `canvass`, which starts the program, and a package for each system that brings it.

use super::{FOLDER, VERSION, scratch, system};
use crate::packages::{self, Package};
use anyhow::{Context, Result, ensure};
use serde_json::{Map, Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The package manager of Node.
pub const NPM: Package = Package { program: "npm", probe: &["--version"], package: "npm" };

/// Fetches npm.
pub fn prepare() -> Result<()> {
    ensure!(system::AARCH64.program().exists(), "it holds the programs for Linux: cargo xtask dist linux");
    ensure!(system::program_for_windows().exists(), "it holds the program for Windows: cargo xtask dist windows");
    packages::install(&[NPM])
}

/// The program for each system, with Node's names of it.
fn programs() -> Vec<((&'static str, &'static str), PathBuf)> {
    let linux = system::LINUX.iter().map(|system| (system.node, system.program()));
    linux.chain([(("win32", "x64"), system::program_for_windows())]).collect()
}

/// All packages.
pub fn make() -> Result<Vec<String>> {
    let mut made = Vec::new();
    let mut optional = Map::new();
    for ((platform, processor), program) in programs() {
        let name = format!("@canvass/{platform}-{processor}");
        let file = if platform == "win32" { "canvass.exe" } else { "canvass" };
        let folder = scratch("npm")?;
        fs::copy(&program, folder.join(file)).with_context(|| program.display().to_string())?;
        let mut about = about(&name);
        about["os"] = json!([platform]);
        about["cpu"] = json!([processor]);
        made.push(pack(&folder, &about)?);
        optional.insert(name, VERSION.into());
    }
    let folder = scratch("npm")?;
    fs::create_dir_all(folder.join("bin"))?;
    fs::copy("packaging/npm/canvass.js", folder.join("bin/canvass.js"))?;
    fs::copy("packaging/npm/README.md", folder.join("README.md"))?;
    let mut about = about("canvass");
    about["bin"] = json!({ "canvass": "bin/canvass.js" });
    about["optionalDependencies"] = Value::Object(optional);
    about["engines"] = json!({ "node": ">=16" });
    made.push(pack(&folder, &about)?);
    Ok(made)
}

fn about(name: &str) -> Value {
    json!({
        "name": name,
        "version": VERSION,
        "description": "CANopen trace analyzer and protocol conformance tester",
        "license": "MIT OR Apache-2.0",
        "keywords": ["can", "canopen", "conformance", "eds"],
    })
}

/// Packs a folder; returns the name of the package's file.
fn pack(folder: &Path, about: &Value) -> Result<String> {
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        fs::copy(licence, folder.join(licence))?;
    }
    fs::write(folder.join("package.json"), serde_json::to_vec_pretty(about)?)?;
    let to = std::env::current_dir()?.join(FOLDER);
    let mut npm = Command::new(NPM.program);
    npm.args(["pack", "--silent", "--pack-destination"]).arg(to).current_dir(folder);
    let output = npm.output().context("npm")?;
    ensure!(output.status.success(), "npm pack: {}", String::from_utf8_lossy(&output.stderr));
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
