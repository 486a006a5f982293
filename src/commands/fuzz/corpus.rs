//! `--corpus-dir`: sequences that are kept between runs, a file for each, and the regressions.

use super::regressions::forbidden;
use super::unreadable;
use crate::status::Failure;
use crate::whole_file::WholeFile;
use anyhow::Context;
use canvass_fuzzer::{Knowledge, Sequence, reproducer};
use canvass_suite::touch::Touch;
use canvass_traces::small_file::{self, OF_PROGRAM};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The file of regressions in a corpus.
pub const REGRESSIONS: &str = "regressions.log";

/// The files of the corpus begin with these letters. Other files of the folder are left alone.
const PREFIX: &str = "corpus-";

/// Reads the corpus, shortest sequences first. A folder that does not exist yet is an empty corpus. Sequences with frames
/// that are not allowed are left out.
pub fn read(folder: &Path, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Result<Vec<Sequence>, Failure> {
    let mut sequences = Vec::new();
    for path in files(folder)? {
        let bytes = small_file::read(&path, OF_PROGRAM).with_context(|| format!("can't read {}", path.display()))?;
        let read = reproducer::read(&bytes, knowledge.node).map_err(|error| unreadable(&path, error))?;
        sequences.extend(read.into_iter().filter(|sequence| forbidden(sequence, knowledge, allow).is_none()));
    }
    sequences.sort_by_cached_key(|sequence| (sequence.stimuli.len(), reproducer::candump(sequence)));
    Ok(sequences)
}

/// Makes the folder hold these sequences, and removes those that were read and reach nothing new any more.
pub fn write(folder: &Path, read: &[Sequence], kept: &[Sequence]) -> Result<(), Failure> {
    let failed = || format!("can't write to {}", folder.display());
    std::fs::create_dir_all(folder).with_context(failed)?;
    let named = |sequences: &[Sequence]| -> BTreeMap<String, String> {
        let logs = sequences.iter().filter(|sequence| !sequence.stimuli.is_empty()).map(reproducer::candump);
        logs.map(|log| (name(&log), log)).collect()
    };
    let (before, after) = (named(read), named(kept));
    for (name, log) in after.iter().filter(|(name, _)| !folder.join(name).exists()) {
        let file = WholeFile::create(&folder.join(name))?;
        file.writer()?.write_all(log.as_bytes()).with_context(failed)?;
        file.complete()?;
    }
    for name in before.keys().filter(|name| !after.contains_key(*name)) {
        match std::fs::remove_file(folder.join(name)) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(anyhow::Error::new(error).context(failed()).into());
            }
            _ => {}
        }
    }
    Ok(())
}

/// The files of the corpus.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(unreadable(folder, error).into()),
    };
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>();
    let mut paths = paths.with_context(|| format!("can't read {}", folder.display()))?;
    let is_of_corpus = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(".log"))
    };
    paths.retain(is_of_corpus);
    paths.sort();
    Ok(paths)
}

/// The name of a sequence's file: the FNV-1a hash of its log, so that the same sequence has the same name in each run.
fn name(log: &str) -> String {
    const BASIS: u64 = 0xCBF2_9CE4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01B3;
    let hash = log.bytes().fold(BASIS, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME));
    format!("{PREFIX}{hash:016x}.log")
}
