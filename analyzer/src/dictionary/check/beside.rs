//! Files beside a DCF: files to download, and the EDS from which it was made.

use crate::dictionary::description::DeviceDescription;
use crate::dictionary::difference::{Difference, compare};
use crate::dictionary::place::Place;
use crate::dictionary::problem::{EdsProblem, Problems};
use crate::dictionary::rules::file as rules;
use crate::dictionary::source::{FieldName, Section, Source};

/// The folder of the checked file.
pub trait Folder {
    /// Whether the folder has a file of that name.
    fn has(&self, name: &str) -> bool;
    /// The bytes of the file of that name; `None` if it is absent, unreadable or too large.
    fn read(&self, name: &str) -> Option<Vec<u8>>;
}

/// Checks a DCF against the files beside it.
pub(super) fn check(description: &DeviceDescription, source: &Source<'_>, folder: &dyn Folder) -> Vec<EdsProblem> {
    let mut problems = Problems::default();
    if description.is_configuration() && !source.is_xml() {
        downloads(source, folder, &mut problems);
        other_eds(description, folder, &mut problems);
    }
    problems.into_sorted()
}

/// Whether `name` is a file name without a folder. The check ignores files in other folders or on another machine.
fn is_plain(name: &str) -> bool {
    !name.is_empty() && !name.contains(['/', '\\', ':', '\0']) && !matches!(name, "." | "..")
}

fn downloads(source: &Source<'_>, folder: &dyn Folder, problems: &mut Problems) {
    let fields = source.elements().flat_map(Section::all_fields);
    for field in fields.filter(|field| field.known() == Some(FieldName::DownloadFile)) {
        if is_plain(field.value()) && !folder.has(field.value()) {
            problems.report(field.place(), &rules::DOWNLOAD, "a file beside the DCF", field.value());
        }
    }
}

fn other_eds(description: &DeviceDescription, folder: &dyn Folder, problems: &mut Problems) {
    let named = description.file.last_eds.as_deref().map(str::trim).filter(|name| is_plain(name));
    let Some(bytes) = named.and_then(|name| folder.read(name)) else { return };
    let Ok(original) = DeviceDescription::read(&bytes) else { return };
    let differences: Vec<Difference> = compare(&original, description).into_iter().filter(matters).collect();
    let Some(first) = differences.first() else { return };
    let more = differences.len() - 1;
    let and = if more == 0 { String::new() } else { format!(", and {more} more") };
    let found = format!("{} {}: {}{and}", first.subject, first.name, first.kind.title());
    let place = Place { section: "FileInfo", field: "LastEDS", ..Place::default() };
    problems.report(place, &rules::OTHER_EDS, "a DCF that describes the device as its EDS does", &found);
}

/// Whether a difference from the EDS is an error. A DCF may differ in the configured values, the data about the file,
/// and the resulting PDOs.
fn matters(difference: &Difference) -> bool {
    const OWN: [&str; 7] =
        ["configured/", "commissioning/", "file/", "pdo/", "module/connected", "entry/denotation", "device/untold"];
    !OWN.iter().any(|own| difference.kind.id.starts_with(own))
}
