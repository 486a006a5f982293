//! Results of `canvass test`, as their pages: two compared, many as a history.

use canvass_reports::comparison::{self, Missing, TestResult, compare};
use canvass_reports::history::{self, History, Release};
use canvass_reports::provenance::{FileUsed, Provenance};

/// The page that tells what changed from an older result to a newer one.
///
/// # Errors
/// In words, if one is no result of `canvass test`.
pub fn comparison(old: (&str, &str), new: (&str, &str), provenance: Provenance) -> Result<Vec<u8>, String> {
    let (older, newer) = (read(old)?, read(new)?);
    let mut comparison = compare(&older, &newer, Missing::default());
    comparison.provenance = provenance;
    for (role, (name, _), result) in [("old", old, &older), ("new", new, &newer)] {
        comparison.provenance.files.push(FileUsed { role, path: name.to_owned(), content: None });
        comparison.provenance.devices.push((format!("{role} device"), result.identity()));
    }
    let mut page = Vec::new();
    comparison::html::render(&comparison, &mut page).map_err(|error| error.to_string())?;
    Ok(page)
}

/// The page of many results, the oldest first.
///
/// # Errors
/// As [`comparison`].
pub fn history(results: &[(String, String)], provenance: Provenance) -> Result<Vec<u8>, String> {
    let mut releases: Vec<Release> = Vec::new();
    for (name, text) in results {
        let result = read((name, text))?;
        let stem = name.rsplit_once('.').map_or(&**name, |(stem, _)| stem);
        let name = result.note("release").unwrap_or(stem).to_owned();
        match releases.iter_mut().find(|known| known.name == name) {
            Some(known) => known.results.push(result),
            None => releases.push(Release { name, results: vec![result] }),
        }
    }
    let mut history = History::of(&releases);
    history.provenance = provenance;
    let file = |(name, _): &(String, String)| FileUsed { role: "result", path: name.clone(), content: None };
    history.provenance.files.extend(results.iter().map(file));
    let mut page = Vec::new();
    history::html(&history, &mut page).map_err(|error| error.to_string())?;
    Ok(page)
}

fn read((name, text): (&str, &str)) -> Result<TestResult, String> {
    TestResult::read(text).map_err(|error| format!("{name}: {error}"))
}
