//! The sequences of earlier runs, and the files in which this run keeps its own.

use super::corpus;
use super::regressions::Regressions;
use crate::status::Failure;
use canvass_fuzzer::campaign::Outcome;
use canvass_fuzzer::{Knowledge, Sequence};
use canvass_suite::touch::Touch;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The sequences of earlier runs.
#[derive(Default)]
pub struct Earlier {
    /// Sequences that have shown violations.
    regressions: Regressions,
    /// The file of these sequences.
    file: Option<PathBuf>,
    corpus: Vec<Sequence>,
    /// The folder of the corpus.
    folder: Option<PathBuf>,
}

impl Earlier {
    /// The sequences of `--replay`.
    pub fn replayed(path: &Path, knowledge: &Knowledge, allow: &BTreeSet<Touch>) -> Result<Self, Failure> {
        Ok(Self { regressions: Regressions::replay(path, knowledge, allow)?, ..Self::default() })
    }

    /// The sequences of `--corpus-dir` and `--regressions`.
    pub fn open(
        folder: Option<PathBuf>,
        regressions: Option<PathBuf>,
        knowledge: &Knowledge,
        allow: &BTreeSet<Touch>,
    ) -> Result<Self, Failure> {
        let file = regressions.or_else(|| Some(folder.as_ref()?.join(corpus::REGRESSIONS)));
        let regressions = file.as_deref().map(|path| Regressions::open(path, knowledge, allow)).transpose()?;
        let corpus = folder.as_deref().map(|folder| corpus::read(folder, knowledge, allow)).transpose()?;
        let (regressions, corpus) = (regressions.unwrap_or_default(), corpus.unwrap_or_default());
        Ok(Self { regressions, file, corpus, folder })
    }

    /// The sequences that have shown violations, and the corpus.
    pub fn sequences(&self) -> (Vec<Sequence>, Vec<Sequence>) {
        (self.regressions.sequences.clone(), self.corpus.clone())
    }

    /// Keeps the corpus and the violations of a run.
    pub fn keep(&self, outcome: &Outcome, seed: u64) -> Result<(), Failure> {
        if let Some(folder) = &self.folder {
            corpus::write(folder, &self.corpus, &outcome.corpus)?;
        }
        match &self.file {
            Some(path) => self.regressions.append(path, &outcome.violations, seed),
            None => Ok(()),
        }
    }
}
