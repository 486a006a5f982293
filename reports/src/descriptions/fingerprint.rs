//! Fingerprints of findings: a finding keeps its fingerprint when its line moves or its file is in another folder.

use super::{CheckedFile, Located};
use canvass_traces::hex;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};

/// The name of the fingerprints in SARIF, with the version of how they are made.
pub(super) const NAME: &str = "canvass/1";
/// The number of bytes of a fingerprint.
const LENGTH: usize = 16;

/// The fingerprints of the findings in a file, in their order. Findings that are equal but for their line are numbered.
pub fn fingerprints(file: &CheckedFile) -> Vec<String> {
    let name = file.name.rsplit(['/', '\\']).next().unwrap_or(&file.name);
    let mut known: BTreeMap<Vec<u8>, u32> = BTreeMap::new();
    let fingerprint = |located: &Located| {
        let problem = &located.finding.problem;
        let mut content = Vec::new();
        for part in [name, problem.rule.id, &problem.section, &problem.field, problem.expected, &problem.found] {
            content.extend(part.as_bytes());
            content.push(0);
        }
        let number = known.entry(content.clone()).or_insert(0);
        content.extend(number.to_le_bytes());
        *number += 1;
        hex::compact(&Sha256::digest(&content)[..LENGTH]).to_string().to_lowercase()
    };
    file.findings.iter().map(fingerprint).collect()
}

/// The findings that are known: a baseline.
#[derive(Clone, Debug, Default)]
pub struct Baseline {
    fingerprints: BTreeSet<String>,
    found: BTreeSet<String>,
}

/// Why a file is no baseline.
#[derive(Debug, thiserror::Error)]
pub enum BadBaseline {
    /// The file is no JSON.
    #[error("expected SARIF, as `canvass eds check --format sarif` writes it: {0}")]
    Json(#[from] serde_json::Error),
    /// The file has results without fingerprints, or no results at all.
    #[error("expected results with the fingerprint {NAME}, as `canvass eds check --format sarif` writes them")]
    Fingerprints,
}

impl Baseline {
    /// Reads the SARIF of an earlier check.
    ///
    /// # Errors
    /// [`BadBaseline`] if the text is no SARIF with fingerprints.
    pub fn read(text: &str) -> Result<Self, BadBaseline> {
        let document: Value = serde_json::from_str(text)?;
        let runs = document["runs"].as_array().ok_or(BadBaseline::Fingerprints)?;
        let results = runs.iter().filter_map(|run| run["results"].as_array()).flatten();
        let fingerprint = |result: &Value| result["partialFingerprints"][NAME].as_str().map(str::to_owned);
        let fingerprints = results.map(|result| fingerprint(result).ok_or(BadBaseline::Fingerprints));
        Ok(Self { fingerprints: fingerprints.collect::<Result<_, _>>()?, found: BTreeSet::new() })
    }

    /// Marks the findings of a file that are known: they count as waived.
    pub fn mark(&mut self, file: &mut CheckedFile) {
        let fingerprints = fingerprints(file);
        for (located, fingerprint) in file.findings.iter_mut().zip(fingerprints) {
            if self.fingerprints.contains(&fingerprint) {
                located.is_known = true;
                located.finding.waived.get_or_insert_with(|| "known: in the baseline".to_owned());
                self.found.insert(fingerprint);
            }
        }
    }

    /// The number of known findings that no checked file has any more.
    pub fn gone(&self) -> usize {
        self.fingerprints.difference(&self.found).count()
    }
}
