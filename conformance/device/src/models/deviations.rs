//! Differences from the standard that the manual of a model documents, as its sheet lists them.
//!
//! ```toml
//! [[deviation]]
//! standard = "CiA 301"                   # the standard from which the device differs
//! expected = "100Ch is rw"               # the requirement of the standard
//! device = "100Ch is ro"                 # the statement of the manual
//! source = "6.2"                         # the place in the manual
//! object = "100C:00"                     # the subject of the difference
//! breaches = [                           # the breaches that this row explains; it explains no others
//!     { case = "301/guarding/time", does = "abort 0601 0002h" },   # with `object`, if the subject is another
//! ]
//! ```

use canvass_bus::observation::{Pattern, Subject};
use serde::{Deserialize, Deserializer, de};
use std::str::FromStr;

/// A documented difference from the standard: in one case, at one subject, with one behaviour.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Deviation {
    /// The case that fails by the difference: an id, or a pattern with `*`.
    pub case: String,
    /// The subject of the breach, such as an object.
    pub subject: Subject,
    /// The behaviour of the device, in place of the required behaviour.
    pub does: Pattern,
    /// The statement of the manual, with its place.
    pub documented: String,
}

/// The tables of a sheet from which the verdict *deviation* follows.
#[derive(Deserialize)]
pub(super) struct DeviationTables {
    manual: Option<Manual>,
    #[serde(default, rename = "deviation")]
    deviations: Vec<DeviationRow>,
}

/// The manual from which all facts of the sheet come.
#[derive(Deserialize)]
struct Manual {
    title: Option<String>,
    document: Option<String>,
    edition: Option<String>,
}

/// A row `[[deviation]]`. A row without breaches is for readers only: no case of the catalogue fails because of it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DeviationRow {
    standard: String,
    expected: String,
    device: String,
    source: String,
    /// The subject of the breaches of this row that name no subject.
    #[serde(default, deserialize_with = "parsed_or_none")]
    object: Option<Subject>,
    #[serde(default)]
    breaches: Vec<Explained>,
}

/// A breach that the difference explains.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Explained {
    case: String,
    #[serde(default, deserialize_with = "parsed_or_none")]
    object: Option<Subject>,
    #[serde(deserialize_with = "parsed")]
    does: Pattern,
}

fn parsed<'de, D: Deserializer<'de>, T: FromStr<Err: std::fmt::Display>>(deserializer: D) -> Result<T, D::Error> {
    String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
}

fn parsed_or_none<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Subject>, D::Error> {
    parsed(deserializer).map(Some)
}

impl DeviationTables {
    /// The deviations: one for each breach of each row.
    pub(super) fn deviations(&self) -> Vec<Deviation> {
        let manual = self.manual.as_ref().map(Manual::name).unwrap_or_default();
        let of_row = |row: &DeviationRow| {
            let documented = row.documented(&manual);
            let of_breach = |Explained { case, object, does }: &Explained| Deviation {
                case: case.clone(),
                subject: object.or(row.object).unwrap_or(Subject::Device),
                does: does.clone(),
                documented: documented.clone(),
            };
            row.breaches.iter().map(of_breach).collect::<Vec<_>>()
        };
        self.deviations.iter().flat_map(of_row).collect()
    }
}

impl Manual {
    /// The name of the manual: its number and edition, or its title if it has no number.
    fn name(&self) -> String {
        let document = self.document.as_ref().or(self.title.as_ref()).map_or("manual", String::as_str);
        match &self.edition {
            Some(edition) => format!("manual {document}, edition {edition}"),
            None => format!("manual {document}"),
        }
    }
}

impl DeviationRow {
    fn documented(&self, manual: &str) -> String {
        let Self { standard, expected, device, source, .. } = self;
        let manual = if manual.is_empty() { "the manual" } else { manual };
        format!("{device}; {standard}: {expected} ({manual}, section {source})")
    }
}
