//! The mutants that somebody has looked at and found right: `xtask/equivalent-mutants.toml` for those of the simulated devices,
//! `xtask/equivalent-mutants-analyzer.toml` and such for those that a crate's own tests look for.
//!
//! A row names the code and not the line, so that it stays true while the code around it changes.

use super::area::Area;
use super::drawn::Mutant;
use anyhow::{Context, Result};
use std::collections::BTreeSet;

/// One mutant; where `change` is left out all of that line, and where `code` is left out all of the function: it is about
/// what nobody can know of a device.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReviewedMutant {
    file: String,
    function: String,
    /// The line as it stands.
    code: Option<String>,
    change: Option<String>,
    /// Why nobody could tell it from what is right.
    why: String,
}

/// The list.
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

    /// Why a mutant is right, if it is listed.
    pub fn reason(&self, mutant: &Mutant) -> Option<&str> {
        self.mutant.iter().find(|row| row.is(mutant)).map(|row| row.why.as_str())
    }

    /// Rows for which there is no code any more.
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

/// A mutant as a row of the list, for who has found the reason.
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
