//! Runs the targets of coverage-guided fuzzing on every toolchain: with random bytes, and with real inputs that were
//! cut, spliced and changed.
#![cfg(test)]

#[path = "../../fuzz-targets/src/lib.rs"]
mod targets;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::path::{Path, PathBuf};
use targets::{SAMPLES, Target, targets};

/// The seed inputs of a target. Large inputs take too long in a test.
fn seeds(target: &Target) -> Vec<Vec<u8>> {
    const LARGEST: u64 = 64 * 1024;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = target.seeds().into_iter().map(|folder| root.join(folder)).filter(|folder| folder.is_dir());
    let mut files: Vec<PathBuf> = folders
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file() && path.metadata().unwrap().len() <= LARGEST)
        .collect();
    files.sort();
    files.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// A real input with random changes, or a random input.
fn input(seeds: Vec<Vec<u8>>) -> BoxedStrategy<Vec<u8>> {
    let random = proptest::collection::vec(any::<u8>(), 0..200).boxed();
    if seeds.is_empty() {
        return prop_oneof![random, "\\PC{0,80}".prop_map(String::into_bytes)].boxed();
    }
    let edit = (any::<proptest::sample::Index>(), any::<u8>(), 0_usize..24, 0_u8..4);
    let changed = (proptest::sample::select(seeds), proptest::collection::vec(edit, 0..8)).prop_map(|(seed, edits)| {
        edits.into_iter().fold(seed, |mut bytes, (at, byte, count, kind)| {
            let at = at.index(bytes.len() + 1);
            let end = (at + count).min(bytes.len());
            match kind {
                0 => bytes[at..end].fill(byte),
                1 => drop(bytes.drain(at..end)),
                2 => drop(bytes.splice(at..at, std::iter::repeat_n(byte, count))),
                _ => bytes.truncate(at),
            }
            bytes
        })
    });
    prop_oneof![4 => changed, 1 => random].boxed()
}

fn hold(target: &Target) {
    const CASES: u32 = 96;
    let config = Config { cases: CASES, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let outcome = runner.run(&input(seeds(target)), |bytes| {
        target.read(&bytes);
        Ok(())
    });
    assert!(outcome.is_ok(), "{}: {outcome:?}", target.name);
}

fn reads_captures(target: &Target) -> bool {
    target.seeds().iter().any(|folder| folder == SAMPLES)
}

#[test]
fn captures_of_every_format_are_survived() {
    targets().iter().filter(|target| reads_captures(target)).for_each(hold);
}

#[test]
fn every_other_reader_survives_what_it_reads() {
    targets().iter().filter(|target| !reads_captures(target)).for_each(hold);
}

/// Real inputs are also read unchanged.
#[test]
fn every_seed_is_read() {
    for target in targets() {
        seeds(&target).iter().for_each(|seed| target.read(seed));
    }
}

/// A folder of seeds that belongs to no target would never be read.
#[test]
fn every_folder_of_seeds_has_its_target() {
    let folders = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz-targets/seeds")).unwrap();
    for folder in folders {
        let name = folder.unwrap().file_name().into_string().unwrap();
        assert!(targets().iter().any(|target| target.name == name), "{name}");
    }
}
