//! Pages of results of `canvass test`: a comparison of two results, or a history of many.

use crate::provenance::{Surroundings, used};
use canvass_reports::comparison::{Missing, compare};
use canvass_reports::document::{Form, Report as _};
use canvass_reports::history::{History, Release};
use canvass_reports::results::{self, TestResult};

/// A result that the user has opened.
pub struct ChosenResult {
    /// The name of the file.
    pub name: String,
    /// The content of the file.
    pub bytes: Vec<u8>,
}

/// The page of the changes from an older result to a newer one.
///
/// # Errors
/// A text, if one of the files is no result of `canvass test`.
pub fn comparison(old: &ChosenResult, new: &ChosenResult, surroundings: &Surroundings) -> Result<Vec<u8>, String> {
    let (older, newer) = (old.read()?, new.read()?);
    let mut comparison = compare(&older, &newer, Missing::default());
    comparison.releases = [release(old, &older), release(new, &newer)];
    comparison.provenance = surroundings.of_comparison();
    for (role, chosen, result) in [("old", old, &older), ("new", new, &newer)] {
        comparison.provenance.files.push(used(role, &chosen.name, &chosen.bytes));
        comparison.provenance.devices.push((format!("{role} device"), result.identity()));
    }
    let mut page = Vec::new();
    comparison.write(Form::Html, &mut page).map_err(|error| error.to_string())?;
    Ok(page)
}

/// The page of many results, the oldest first.
///
/// # Errors
/// As [`comparison`].
pub fn history(results: &[ChosenResult], surroundings: &Surroundings) -> Result<Vec<u8>, String> {
    let mut releases: Vec<Release> = Vec::new();
    for chosen in results {
        let result = chosen.read()?;
        let name = release(chosen, &result);
        match releases.iter_mut().find(|known| known.name == name) {
            Some(known) => known.results.push(result),
            None => releases.push(Release { name, results: vec![result] }),
        }
    }
    let mut history = History::of(&releases);
    history.provenance = surroundings.provenance();
    history.provenance.files = results.iter().map(|chosen| used("result", &chosen.name, &chosen.bytes)).collect();
    let mut page = Vec::new();
    history.write(Form::Html, &mut page).map_err(|error| error.to_string())?;
    Ok(page)
}

/// The name of a release: as the result notes it, else the name of the file.
fn release(chosen: &ChosenResult, result: &TestResult) -> String {
    let stem = chosen.name.rsplit_once('.').map_or(&*chosen.name, |(stem, _)| stem);
    result.note("release").unwrap_or(stem).to_owned()
}

impl ChosenResult {
    fn read(&self) -> Result<TestResult, String> {
        let told = |error: &dyn std::fmt::Display| format!("{}: {error}", self.name);
        let text = str::from_utf8(&self.bytes).map_err(|error| told(&error))?;
        results::read(text).map_err(|error| told(&error))
    }
}
