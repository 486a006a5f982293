//! Answers in SQL equal those of `canvass decode`, `signals` and `diagnose`, for every sample and for 200 generated
//! captures of all formats.

mod compare;
mod engine;
mod program;
mod pushed;
mod traffic;

use canvass_traces::Format;
use std::path::{Path, PathBuf};

fn samples() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/samples");
    let is_capture = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        !matches!(ending, "md" | "py" | "frames")
    };
    let mut samples: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    samples.retain(is_capture);
    samples.sort();
    assert!(samples.len() > 20, "{samples:?}");
    samples
}

#[test]
fn every_sample() {
    let engine = engine::Engine::new();
    samples().iter().for_each(|sample| compare::all(&engine, sample));
}

#[test]
fn generated_captures_of_all_formats() {
    let engine = engine::Engine::new();
    let folder = tempfile::tempdir().unwrap();
    let mut count = 0;
    for seed in 0..20 {
        for format in Format::all() {
            compare::all(&engine, &traffic::write(folder.path(), format, seed));
            count += 1;
        }
    }
    assert_eq!(count, 20 * Format::all().count());
}
