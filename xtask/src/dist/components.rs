//! The list of components (SBOM) in the format CycloneDX. It names each library in the program with its version, licence and
//! checksum.

use super::{FOLDER, name, system, tools};
use crate::run::run;
use anyhow::{Context, Result};
use std::fs;
use std::path::Path;

/// The version of CycloneDX that the list follows.
pub const SPECIFICATION: &str = "1.5";

/// Fetches what makes the list.
pub fn prepare() -> Result<()> {
    tools::VENV.install()?;
    tools::install_subcommand("cargo-cyclonedx")
}

/// The list of the program for Linux; those for other systems differ in what reaches the system.
pub fn make() -> Result<Vec<String>> {
    let name = name("sbom.cdx");
    let spec = ["--spec-version", SPECIFICATION, "--format", "json", "--override-filename", &name];
    run("cargo", &[&["cyclonedx", "--target", system::X86_64.target, "--quiet"], &spec[..]].concat())?;
    // The tool writes a list beside each Cargo.toml of the workspace. That of the program has all the others in it.
    let file = format!("{name}.json");
    fs::copy(&file, Path::new(FOLDER).join(&file)).context("the list of the program")?;
    for folder in members()?.iter().chain([&".".to_owned()]) {
        let list = Path::new(folder).join(&file);
        if list.exists() {
            fs::remove_file(list)?;
        }
    }
    Ok(vec![file])
}

/// The folders of the workspace's crates.
fn members() -> Result<Vec<String>> {
    let manifest: toml::Table = fs::read_to_string("Cargo.toml")?.parse()?;
    let members = manifest["workspace"]["members"].as_array().context("members")?;
    members.iter().map(|member| Ok(member.as_str().context("a folder")?.to_owned())).collect()
}
