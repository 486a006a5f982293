//! `--replay` and `--regressions`: sequences of earlier runs.

use super::{notice, unreadable};
use crate::status::Failure;
use anyhow::{Context, anyhow};
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::limits::{self, Forbidden};
use canvass_fuzzer::{Knowledge, Sequence, reproducer};
use canvass_suite::touch::Touch;
use canvass_traces::small_file::{self, OF_PROGRAM};
use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

/// The sequences of a file.
#[derive(Default)]
pub struct Regressions {
    /// The sequences that may be sent.
    pub sequences: Vec<Sequence>,
}

impl Regressions {
    /// Reads a log or reproducer. One forbidden frame refuses the whole file: a partial replay proves nothing.
    pub fn replay(path: &Path, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Result<Self, Failure> {
        let bytes = small_file::read(path, OF_PROGRAM).with_context(|| format!("can't read {}", path.display()))?;
        let sequences = reproducer::read(&bytes, knowledge.node).map_err(|error| unreadable(path, error))?;
        if let Some(why) = sequences.iter().find_map(|sequence| forbidden(sequence, knowledge, allow)) {
            return Err(anyhow!("{}: {why}", path.display()).into());
        }
        if sequences.is_empty() {
            return Err(unreadable(path, "the file holds no frame").into());
        }
        Ok(Self { sequences })
    }

    /// Opens a file of regressions, if it exists. Sequences with forbidden frames are left out.
    pub fn open(path: &Path, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Result<Self, Failure> {
        let bytes = match small_file::read(path, OF_PROGRAM) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(anyhow!("can't read {}: {error}", path.display()).into()),
        };
        if bytes.trim_ascii().is_empty() {
            return Ok(Self::default());
        }
        let mut sequences = reproducer::read(&bytes, knowledge.node).map_err(|error| unreadable(path, error))?;
        sequences.retain(|sequence| match forbidden(sequence, knowledge, allow) {
            Some(why) => {
                notice(&format!("{}: a sequence is left out: {why}", path.display()));
                false
            }
            None => true,
        });
        Ok(Self { sequences })
    }

    /// Appends the new sequences.
    pub fn append(&self, path: &Path, found: &[Found], seed: u64) -> Result<(), Failure> {
        // Log times are coarser than those of a sequence; so the comparison uses each sequence as it reads back from
        // a log.
        let known: BTreeSet<String> = self.sequences.iter().map(reproducer::candump).collect();
        let new: String = found
            .iter()
            .filter(|found| !found.sequence.stimuli.is_empty())
            .filter(|found| !known.contains(&reproducer::candump(&found.whole())))
            .map(|found| reproducer::regression(found, seed))
            .collect();
        if new.is_empty() {
            return Ok(());
        }
        Ok(append(path, new.as_bytes()).with_context(|| format!("can't write {}", path.display()))?)
    }
}

/// Appends all bytes or, if the disk is full, none: half a frame would make the file unreadable.
fn append(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    let before = file.metadata()?.len();
    file.write_all(bytes).and_then(|()| file.flush()).inspect_err(|_| {
        // A pipe or a device can't be shortened.
        let _ = file.set_len(before);
    })
}

/// The reason why the first forbidden frame is refused, with the option that permits it.
pub fn forbidden(sequence: &Sequence, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Option<String> {
    sequence.stimuli.iter().find_map(|stimulus| {
        let frame = &stimulus.frame;
        Some(match limits::of(frame, knowledge, allow)? {
            why @ Forbidden::Touch(touch) => format!("{frame} {why}: --allow {touch} permits it"),
            why @ Forbidden::Program => format!("{frame} {why}"),
        })
    })
}
