//! The provenance of a result of the page, in the form of the program for the same files.

use crate::file::hexadecimal;
use canvass_reports::provenance::{Choice, ChosenBy, Date, FileUsed, Host, Provenance};
use sha2::{Digest, Sha256};

/// The surroundings of the page: host, system, date and zone.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(default)]
pub struct Surroundings {
    host: String,
    system: String,
    date: String,
    zone: String,
}

impl Surroundings {
    /// The provenance of a diagnosis. `devices` are the device descriptions in use, each as `NODES=FILE`.
    pub fn of_diagnosis(&self, devices: Vec<String>, format: Option<&str>, same_bus: bool) -> Provenance {
        let options = vec![
            usual("fail-on", ["error"]),
            given("threshold", []),
            given("bit-rate", []),
            given("device", devices),
            given("node", []),
            given("channel", []),
            given("from", []),
            given("to", []),
            given("format-in", format.map(str::to_owned)),
            given("topic", []),
            given("columns", []),
            flag("same-bus", same_bus),
            flag("strict", false),
        ];
        Provenance { options, ..self.provenance() }
    }

    /// The provenance of a comparison of two results.
    pub fn of_comparison(&self) -> Provenance {
        Provenance { options: vec![flag("allow-missing", false), given("earlier", [])], ..self.provenance() }
    }

    /// A provenance with only date and host.
    pub fn provenance(&self) -> Provenance {
        let date = Date { rfc3339: self.date.clone(), zone: self.zone.clone() };
        let host = Host { name: self.host.clone(), system: self.system.clone() };
        Provenance { date: Some(date), host: Some(host), ..Provenance::default() }
    }
}

/// An option with its default.
pub fn usual<T: Into<String>>(name: &str, value: impl IntoIterator<Item = T>) -> Choice {
    let value: Vec<String> = value.into_iter().map(Into::into).collect();
    Choice { name: name.to_owned(), default: value.clone(), value, by: ChosenBy::Default }
}

/// An option without a default.
pub fn given(name: &str, value: impl IntoIterator<Item = String>) -> Choice {
    let value: Vec<String> = value.into_iter().collect();
    let by = if value.is_empty() { ChosenBy::Default } else { ChosenBy::CommandLine };
    Choice { name: name.to_owned(), value, default: Vec::new(), by }
}

/// An option without value, set or not.
pub fn flag(name: &str, set: bool) -> Choice {
    match set {
        true => Choice { value: vec!["yes".to_owned()], by: ChosenBy::CommandLine, ..usual(name, ["no"]) },
        false => usual(name, ["no"]),
    }
}

/// A file that was read completely.
pub fn used(role: &'static str, name: &str, bytes: &[u8]) -> FileUsed {
    let content = Some((bytes.len() as u64, hexadecimal(&Sha256::digest(bytes))));
    FileUsed { role, path: name.to_owned(), content }
}
