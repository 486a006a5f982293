//! The program for cargo-fuzz: one for all targets, as linking one for each takes longer than running it.
#![no_main]

use canvass_fuzz::{Target, targets};
use std::sync::OnceLock;

/// The environment variable with the name of the target.
const VARIABLE: &str = "CANVASS_FUZZ_TARGET";

static TARGET: OnceLock<Target> = OnceLock::new();

libfuzzer_sys::fuzz_target!(
    init: {
        let name = std::env::var(VARIABLE).unwrap_or_default();
        match targets().into_iter().find(|target| target.name == name) {
            Some(target) => drop(TARGET.set(target)),
            None => list(),
        }
    },
    |bytes: &[u8]| {
        if let Some(target) = TARGET.get() {
            target.read(bytes);
        }
    }
);

/// Prints the names of the targets, with their folders of real inputs, and ends the program.
fn list() -> ! {
    eprintln!("set {VARIABLE} to one of these targets:");
    for target in targets() {
        println!("{} {}", target.name, target.seeds().join(" "));
    }
    std::process::exit(2)
}
