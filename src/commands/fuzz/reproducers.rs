//! `--reproducers`: a log and a test for pytest for each violation.

use crate::status::Failure;
use crate::whole_file::WholeFile;
use anyhow::Context;
use canvass_analyzer::NodeId;
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::reproducer;
use std::io::Write;
use std::path::Path;

/// Writes two files per violation. The violation and the seed determine their names. An error with one file does not
/// stop the others.
pub fn write(folder: &Path, found: &[Found], node: NodeId, seed: u64) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).with_context(|| failed(folder))?;
    let found = found.iter().filter(|found| !found.sequence.stimuli.is_empty());
    let files = found.flat_map(|found| {
        let name = format!("{}-seed{seed}", found.violation.defect());
        let test = format!("test_{}.py", name.replace('-', "_"));
        [(format!("{name}.log"), reproducer::regression(found, seed)), (test, reproducer::pytest(found, node, seed))]
    });
    let written: Vec<Result<(), Failure>> = files.map(|(name, text)| write_one(folder, &name, &text)).collect();
    written.into_iter().collect()
}

fn write_one(folder: &Path, name: &str, text: &str) -> Result<(), Failure> {
    let file = WholeFile::create(&folder.join(name))?;
    file.writer()?.write_all(text.as_bytes()).with_context(|| failed(folder))?;
    Ok(file.complete()?)
}

fn failed(folder: &Path) -> String {
    format!("can't write to {}", folder.display())
}
