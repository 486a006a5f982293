//! `cargo xtask docs`: writes the pages of `docs` that are made from the code. Tests check that they are current.

use crate::run::run;
use anyhow::{Context, Result, bail};
use std::process::Command;

/// What `canvass list` prints as Markdown, and the page.
const PAGES: [(&str, &str); 4] = [
    ("cases", "docs/cases.md"),
    ("rules", "docs/rules.md"),
    ("eds-rules", "docs/eds-rules.md"),
    ("faults", "docs/fuzz-faults.md"),
];

pub fn docs() -> Result<()> {
    run("cargo", &["build", "--locked", "--bin", "canvass"])?;
    for (what, page) in PAGES {
        let args = ["run", "--quiet", "--locked", "--bin", "canvass", "--", "list", what, "--format", "markdown"];
        let output = Command::new("cargo").args(args).output().context("can't run cargo")?;
        if !output.status.success() {
            bail!("canvass list {what} ended with {}: {}", output.status, String::from_utf8_lossy(&output.stderr));
        }
        std::fs::write(page, output.stdout).with_context(|| format!("can't write {page}"))?;
        eprintln!("{page}");
    }
    run("cargo", &["run", "--quiet", "--locked", "--package", "canvass-reports", "--example", "schemas", "--", "docs/schemas"])
}
