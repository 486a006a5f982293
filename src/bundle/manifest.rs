//! `manifest.json`: the names of a bundle's files, with the hash of each.

use super::zip::Entry;
use crate::provenance::hash;
use anyhow::{Context, Result, bail};
use canvass_reports::provenance::VERSION;
use serde_json::{Value, json};

/// Name of the manifest in the bundle.
pub const NAME: &str = "manifest.json";
/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/bundle/1";

/// Makes the manifest of the given files.
pub fn of(entries: &[Entry]) -> Result<Entry> {
    let files = entries.iter().map(file).collect::<Result<Vec<Value>>>()?;
    let manifest = json!({ "schema": SCHEMA, "version": VERSION, "files": files });
    Ok(Entry { name: NAME.to_owned(), content: format!("{manifest:#}\n").into_bytes() })
}

fn file(entry: &Entry) -> Result<Value> {
    let (bytes, sha256) = hash(&entry.content[..])?;
    Ok(json!({ "name": entry.name, "bytes": bytes, "sha256": sha256 }))
}

/// Checks that the bundle holds exactly the files of the manifest, unchanged.
///
/// # Errors
/// The first file that is missing, added or changed, by its name.
pub fn check(manifest: &Entry, entries: &[Entry]) -> Result<()> {
    let text: Value =
        serde_json::from_slice(&manifest.content).context("manifest.json was changed: expected a JSON document")?;
    if text["schema"] != SCHEMA {
        bail!("manifest.json: expected a document of schema {SCHEMA}, found {}", text["schema"]);
    }
    let listed = text["files"].as_array().map(Vec::as_slice).unwrap_or_default();
    for known in listed {
        let name = known["name"].as_str().unwrap_or_default();
        if !entries.iter().any(|entry| entry.name == name) {
            bail!("{name} is missing: manifest.json lists it");
        }
    }
    for entry in entries {
        let known = listed.iter().find(|known| known["name"] == *entry.name);
        let known = known.with_context(|| format!("{} is not in manifest.json: it was added", entry.name))?;
        if *known != file(entry)? {
            bail!("{} was changed: manifest.json has the SHA-256 {}", entry.name, known["sha256"]);
        }
    }
    Ok(())
}
