//! Reviewed mutants that are equivalent to the original: `xtask/equivalent-mutants.toml` for the simulated devices, and
//! files such as `xtask/equivalent-mutants-analyzer.toml` for crates with their own tests.
//!
//! A row names the code instead of the line number, so that it stays true while the code around it changes.

use super::area::Area;
use super::drawn::Mutant;
use anyhow::{Context, Result};
use std::collections::BTreeSet;

/// A reviewed mutant. A row without `change` covers all mutants of the line, a row without `code` all of the function:
/// code whose effect no tester can know.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReviewedMutant {
    file: String,
    function: String,
    /// The line of code.
    code: Option<String>,
    change: Option<String>,
    /// Why nobody could distinguish the mutant from the original.
    why: String,
}

/// The list of reviewed mutants.
#[derive(Default, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reviewed {
    #[serde(default)]
    mutant: Vec<ReviewedMutant>,
}

impl Reviewed {
    pub fn read(area: &Area) -> Result<Self> {
        let file = match area.name {
            "device" => "xtask/equivalent-mutants.toml".to_owned(),
            name => format!("xtask/equivalent-mutants-{name}.toml"),
        };
        let text = std::fs::read_to_string(&file).with_context(|| file.clone())?;
        toml::from_str(&text).context(file)
    }

    /// Why a mutant is equivalent, if it is listed.
    pub fn reason(&self, mutant: &Mutant) -> Option<&str> {
        self.mutant.iter().find(|row| row.is(mutant)).map(|row| row.why.as_str())
    }

    /// Rows whose code does not exist any more.
    pub fn stale(&self, mutants: &[Mutant]) -> BTreeSet<&ReviewedMutant> {
        self.mutant.iter().filter(|row| !mutants.iter().any(|mutant| row.is(mutant))).collect()
    }
}

impl ReviewedMutant {
    fn is(&self, mutant: &Mutant) -> bool {
        self.file == mutant.file
            && self.function == mutant.function
            && self.code.as_ref().is_none_or(|code| *code == mutant.code)
            && self.change.as_ref().is_none_or(|change| *change == mutant.change)
    }
}

/// A mutant as a row of the list, to which a reviewer adds the reason.
pub fn row(mutant: &Mutant) -> String {
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    format!(
        "[[mutant]]\nfile = {}\nfunction = {}\ncode = {}\nchange = {}\nwhy = \"\"\n",
        quoted(&mutant.file),
        quoted(&mutant.function),
        quoted(&mutant.code),
        quoted(&mutant.change)
    )
}
