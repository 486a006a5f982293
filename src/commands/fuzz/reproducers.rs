//! `--reproducers`: a log file for each violation.

use crate::status::Failure;
use crate::whole_file::WholeFile;
use anyhow::Context;
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::reproducer;
use std::io::Write;
use std::path::Path;

/// Writes one file per violation. The violation and the seed determine the file's name. An error with one file does
/// not stop the others.
pub fn write(folder: &Path, found: &[Found], seed: u64) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).with_context(|| failed(folder))?;
    let found = found.iter().filter(|found| !found.sequence.stimuli.is_empty());
    let written: Vec<Result<(), Failure>> = found.map(|found| write_one(folder, found, seed)).collect();
    written.into_iter().collect()
}

fn write_one(folder: &Path, found: &Found, seed: u64) -> Result<(), Failure> {
    let file = WholeFile::create(&folder.join(name(found, seed)))?;
    let text = reproducer::regression(found, seed);
    file.writer()?.write_all(text.as_bytes()).with_context(|| failed(folder))?;
    Ok(file.complete()?)
}

fn failed(folder: &Path) -> String {
    format!("can't write to {}", folder.display())
}

fn name(found: &Found, seed: u64) -> String {
    let violation = &found.violation;
    let words = format!("{} {}", violation.property.id(), violation.rule).to_lowercase();
    let plain: String = words.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    format!("{plain}-seed{seed}.log")
}
