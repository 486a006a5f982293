//! The log of a lake: the list of its files. Files that the log does not name are not part of the lake.
//!
//! A commit is one object, written whole or not at all, and its number can be used only once. So the commits of a
//! killed run stay, and if two runs commit the same number, the second one is refused.

use super::{Entry, LakeError, Location};
use bytes::Bytes;
use futures::TryStreamExt;
use object_store::{ObjectStoreExt as _, PutMode, PutOptions, PutPayload};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/lake/1";

/// A commit.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Commit {
    schema: String,
    /// Whether the commit holds all entries, so that earlier commits are not needed any more.
    complete: bool,
    /// Entries that are new, or replace the entries of the same files.
    entries: Vec<Entry>,
}

/// The content of a lake at one moment.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// The number of the last commit; 0 if there is no lake yet.
    pub version: u64,
    /// The entries, by the names of the source files.
    pub entries: BTreeMap<String, Entry>,
}

/// The folder of the commits.
pub const FOLDER: &str = "log";

fn name(version: u64) -> String {
    format!("{FOLDER}/{version:020}.json")
}

impl Snapshot {
    /// Reads the content of a lake, which is empty if there is no lake.
    ///
    /// # Errors
    /// [`LakeError`] if the log can't be read.
    pub async fn read(location: &Location) -> Result<Self, LakeError> {
        // Another run may be deleting the commits that a later commit replaces.
        for _ in 0..3 {
            if let Some(snapshot) = Self::try_read(location).await? {
                return Ok(snapshot);
            }
        }
        Err(LakeError::Changing(location.url.to_string()))
    }

    async fn try_read(location: &Location) -> Result<Option<Self>, LakeError> {
        let versions = versions(location).await?;
        let mut commits = Vec::new();
        for version in versions.into_iter().rev() {
            let content = match location.store.get(&location.path(&name(version))).await {
                Ok(found) => found.bytes().await?,
                Err(object_store::Error::NotFound { .. }) => return Ok(None),
                Err(error) => return Err(error.into()),
            };
            let commit = parse(&content, version)?;
            let is_complete = commit.complete;
            commits.push((version, commit));
            if is_complete {
                break;
            }
        }
        let mut snapshot = Self::default();
        for (version, commit) in commits.into_iter().rev() {
            snapshot.version = version;
            snapshot.add(commit.entries);
        }
        Ok(Some(snapshot))
    }

    fn add(&mut self, entries: Vec<Entry>) {
        self.entries.extend(entries.into_iter().map(|entry| (entry.file.name.clone(), entry)));
    }

    /// Commits entries; returns the entries that they replace.
    ///
    /// # Errors
    /// [`LakeError::Conflict`] if another run has committed meanwhile.
    pub async fn commit(&mut self, location: &Location, entries: Vec<Entry>) -> Result<Vec<Entry>, LakeError> {
        self.put(location, false, entries.clone()).await?;
        let replaced = entries.iter().filter_map(|entry| self.entries.get(&entry.file.name).cloned()).collect();
        self.add(entries);
        Ok(replaced)
    }

    /// Begins a run: from now on commits of other runs are refused. All earlier commits become one commit.
    ///
    /// # Errors
    /// As [`Snapshot::commit`].
    pub async fn begin(&mut self, location: &Location) -> Result<(), LakeError> {
        self.put(location, true, self.entries.values().cloned().collect()).await?;
        for version in versions(location).await?.into_iter().filter(|&version| version < self.version) {
            location.store.delete(&location.path(&name(version))).await?;
        }
        Ok(())
    }

    async fn put(&mut self, location: &Location, complete: bool, entries: Vec<Entry>) -> Result<(), LakeError> {
        let version = self.version + 1;
        let commit = Commit { schema: SCHEMA.to_owned(), complete, entries };
        let content =
            serde_json::to_vec(&commit).map_err(|error| LakeError::Log { version, reason: error.to_string() })?;
        let options = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
        let payload = PutPayload::from_bytes(Bytes::from(content));
        match location.store.put_opts(&location.path(&name(version)), payload, options).await {
            Ok(_) => {
                self.version = version;
                Ok(())
            }
            Err(object_store::Error::AlreadyExists { .. } | object_store::Error::Precondition { .. }) => {
                Err(LakeError::Conflict(location.url.to_string()))
            }
            Err(error) => Err(error.into()),
        }
    }
}

fn parse(content: &[u8], version: u64) -> Result<Commit, LakeError> {
    let commit: Commit =
        serde_json::from_slice(content).map_err(|error| LakeError::Log { version, reason: error.to_string() })?;
    if commit.schema == SCHEMA {
        return Ok(commit);
    }
    Err(LakeError::Log { version, reason: format!("expected {SCHEMA}, found {}", commit.schema) })
}

/// The numbers of all commits, rising.
async fn versions(location: &Location) -> Result<Vec<u64>, LakeError> {
    let listed = location.store.list(Some(&location.path(FOLDER)));
    let objects: Vec<_> = listed.try_collect().await?;
    let number = |object: &object_store::ObjectMeta| object.location.filename()?.strip_suffix(".json")?.parse().ok();
    let mut versions: Vec<u64> = objects.iter().filter_map(number).collect();
    versions.sort_unstable();
    Ok(versions)
}
