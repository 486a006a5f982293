//! Runs the targets of coverage-guided fuzzing on every toolchain: with random bytes, and with real inputs that were
//! cut, spliced and changed.
#![cfg(test)]

#[path = "../../fuzz-targets/src/lib.rs"]
mod targets;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::path::{Path, PathBuf};
use targets::{TARGETS, Target};

/// The seed inputs of a target. Large inputs take too long in a test.
fn seeds(folders: &[&str]) -> Vec<Vec<u8>> {
    const LARGEST: u64 = 64 * 1024;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<PathBuf> = folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap())
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

fn hold(&(name, read, folders): &Target) {
    const CASES: u32 = 96;
    let config = Config { cases: CASES, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let outcome = runner.run(&input(seeds(folders)), |bytes| {
        read(&bytes);
        Ok(())
    });
    assert!(outcome.is_ok(), "{name}: {outcome:?}");
}

#[test]
fn captures_of_every_format_are_survived() {
    TARGETS.iter().filter(|target| target.2.contains(&"traces/samples")).for_each(hold);
}

#[test]
fn every_other_reader_survives_what_it_reads() {
    TARGETS.iter().filter(|target| !target.2.contains(&"traces/samples")).for_each(hold);
}

/// Real inputs are also read unchanged.
#[test]
fn every_seed_is_read() {
    for (_, read, folders) in TARGETS {
        seeds(folders).iter().for_each(|seed| read(seed));
    }
}

/// A capture format without a fuzz target is detected here.
#[test]
fn every_capture_format_has_its_target() {
    for format in canvass_traces::Format::all() {
        let name = format.id().trim_start_matches("candump-");
        assert!(TARGETS.iter().any(|target| target.0 == name), "{name}");
    }
    let manifest = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz-targets/Cargo.toml")).unwrap();
    for (name, ..) in TARGETS {
        assert!(manifest.contains(&format!("targets/{name}.rs")), "{name}");
    }
}
