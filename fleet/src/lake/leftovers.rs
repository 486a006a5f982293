//! Cleans up after a killed run: files that belong to no entry.

use super::{Entry, LakeError, Location};
use crate::table::Table;
use futures::TryStreamExt as _;
use object_store::ObjectStoreExt as _;
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

/// Deletes the files of tables that no entry names, and incomplete files.
///
/// # Errors
/// [`LakeError`] if the lake can't be listed or written.
pub async fn delete(location: &Location, entries: impl Iterator<Item = &Entry>) -> Result<(), LakeError> {
    let parts = entries.flat_map(|entry| &entry.parts);
    let known: BTreeSet<String> = parts.map(|part| location.path(&part.path()).to_string()).collect();
    for table in Table::ALL {
        let folder = location.path(table.name());
        let listed: Vec<_> = location.store.list(Some(&folder)).try_collect().await?;
        for object in listed.into_iter().filter(|object| !known.contains(object.location.as_ref())) {
            location.store.delete(&object.location).await?;
        }
    }
    if let Some(root) = location.folder() {
        for folder in Table::ALL.map(Table::name).iter().chain([&super::log::FOLDER]) {
            half_written(&root.join(folder))?;
        }
    }
    Ok(())
}

/// Deletes incomplete files of the local store, such as `….parquet#1`: the store itself does not list these names.
fn half_written(folder: &Path) -> Result<(), LakeError> {
    let failed = |error: io::Error| LakeError::Folder { folder: folder.to_owned(), source: error };
    let entries = match folder.read_dir() {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(failed(error)),
    };
    for entry in entries {
        let path: PathBuf = entry.map_err(failed)?.path();
        // A symbolic link leads out of the lake: its target is not the lake's.
        let kind = path.symlink_metadata().map_err(failed)?.file_type();
        if kind.is_dir() {
            half_written(&path)?;
        } else if kind.is_file() && is_half_written(&path) {
            std::fs::remove_file(&path).map_err(failed)?;
        }
    }
    Ok(())
}

fn is_half_written(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.rsplit_once('#'));
    let is_ours = |name: &str| name.ends_with(".parquet") || name.ends_with(".json");
    name.is_some_and(|(name, number)| is_ours(name) && number.bytes().all(|byte| byte.is_ascii_digit()))
}
