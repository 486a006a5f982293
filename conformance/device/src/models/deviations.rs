//! What a model's sheet says of differences from the standard that the manual documents.

use serde::Deserialize;

/// A difference from the standard that the manual documents.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Deviation {
    /// The cases that it explains: an id, or a pattern with `*`.
    pub case: String,
    /// What the manual says, and where.
    pub documented: String,
}

/// The tables of a sheet that the verdict *deviation* is made of.
#[derive(Deserialize)]
pub(super) struct DeviationTables {
    manual: Option<Manual>,
    #[serde(default, rename = "deviation")]
    deviations: Vec<Row>,
}

/// Where all facts of the sheet come from.
#[derive(Deserialize)]
struct Manual {
    title: Option<String>,
    document: Option<String>,
    edition: Option<String>,
}

/// One difference. Without `cases` it is only for people: no case of the catalogue fails because of it.
#[derive(Deserialize)]
struct Row {
    standard: String,
    expected: String,
    device: String,
    source: String,
    /// The cases whose failure it explains: ids, or patterns with `*`.
    #[serde(default)]
    cases: Vec<String>,
}

impl DeviationTables {
    /// One deviation for each case pattern of each row.
    pub(super) fn deviations(&self) -> Vec<Deviation> {
        let manual = self.manual.as_ref().map(Manual::name).unwrap_or_default();
        let of_row = |row: &Row| {
            let documented = row.documented(&manual);
            row.cases
                .iter()
                .map(|case| Deviation { case: case.clone(), documented: documented.clone() })
                .collect::<Vec<_>>()
        };
        self.deviations.iter().flat_map(of_row).collect()
    }
}

impl Manual {
    /// The document's number and edition, or its title where it has no number.
    fn name(&self) -> String {
        let document = self.document.as_ref().or(self.title.as_ref()).map_or("manual", String::as_str);
        match &self.edition {
            Some(edition) => format!("manual {document}, edition {edition}"),
            None => format!("manual {document}"),
        }
    }
}

impl Row {
    fn documented(&self, manual: &str) -> String {
        let Self { standard, expected, device, source, .. } = self;
        let manual = if manual.is_empty() { "the manual" } else { manual };
        format!("{device}; {standard}: {expected} ({manual}, section {source})")
    }
}
