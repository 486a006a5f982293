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

/// Sequences of earlier runs.
#[derive(Default)]
pub struct Regressions {
    /// Those that may be sent.
    pub sequences: Vec<Sequence>,
}

impl Regressions {
    /// A log or reproducer; all of it may be sent, or nothing is.
    pub fn replay(path: &Path, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Result<Self, Failure> {
        let bytes = small_file::read(path, OF_PROGRAM).with_context(|| format!("can't read {}", path.display()))?;
        let sequences = reproducer::read(&bytes, knowledge.node).map_err(|error| unreadable(path, error))?;
        if let Some(why) = sequences.iter().find_map(|sequence| forbidden(sequence, knowledge, allow)) {
            return Err(anyhow!("{}: {why}", path.display()).into());
        }
        if sequences.is_empty() {
            return Err(unreadable(path, "it holds no frame").into());
        }
        Ok(Self { sequences })
    }

    /// A file of regressions, if there is one already.
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

    /// Appends what is new.
    pub fn append(&self, path: &Path, found: &[Found], seed: u64) -> Result<(), Failure> {
        // A log has no way to tell apart what its times can't; what it is read as is compared.
        let known: BTreeSet<String> = self.sequences.iter().map(reproducer::candump).collect();
        let new: String = found
            .iter()
            .filter(|found| !found.sequence.stimuli.is_empty())
            .filter(|found| !known.contains(&reproducer::candump(&found.sequence)))
            .map(|found| reproducer::regression(found, seed))
            .collect();
        if new.is_empty() {
            return Ok(());
        }
        Ok(append(path, new.as_bytes()).with_context(|| format!("can't write {}", path.display()))?)
    }
}

/// Appends all of it or, if there is no room for that, nothing: half of a frame would make the file unreadable.
fn append(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    let before = file.metadata()?.len();
    file.write_all(bytes).and_then(|()| file.flush()).inspect_err(|_| {
        // A pipe or a device can't be shortened.
        let _ = file.set_len(before);
    })
}

/// The first frame that is not allowed, with the reason and how it is allowed.
fn forbidden(sequence: &Sequence, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Option<String> {
    sequence.stimuli.iter().find_map(|stimulus| {
        let frame = &stimulus.frame;
        Some(match limits::of(frame, knowledge, allow)? {
            why @ Forbidden::Touch(touch) => format!("{frame} {why}: --allow {touch} permits it"),
            why @ Forbidden::Program => format!("{frame} {why}"),
        })
    })
}
