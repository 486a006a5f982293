//! `cargo xtask ci`: everything that must pass, with all its set-up. `cargo xtask peers`: of these, the tests that
//! exchange captures with other people's programs. `cargo xtask browser`: those that show the pages in Chromium. `cargo
//! xtask bench`: how fast canvass is, beside its peers; `--instructions` counts instead what a frame costs. `cargo xtask
//! memory`: what it needs for captures of gigabytes. `cargo xtask storm`: ten million random frames for each simulated
//! device. `cargo xtask rooms`: whether the folders of the crates use each other in one direction only. `cargo xtask
//! incidents`: what the diagnosis names first in a thousand
//! networks with one fault each, and in a thousand healthy ones.

mod bench;
mod browser;
mod ci;
mod diagnosing;
mod fuzz;
mod incidents;
mod measure;
mod memory;
mod packages;
mod peers;
mod rooms;
mod run;
mod simulation;
mod storm;
mod vcan;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(std::path::Path::to_owned);
    std::env::set_current_dir(root.unwrap_or_else(|| ".".into()))?;
    match std::env::args().nth(1).as_deref() {
        Some("ci") => ci::ci(),
        Some("peers") => peers::test(),
        Some("browser") => browser::test(),
        Some("bench") if std::env::args().nth(2).as_deref() == Some("--instructions") => bench::instructions(),
        Some("bench") => bench::bench(),
        Some("fuzz") => fuzz::fuzz(),
        Some("memory") => memory::memory(),
        Some("incidents") => incidents::incidents(),
        Some("rooms") => rooms::rooms(&std::env::args().skip(2).collect::<Vec<_>>()),
        Some("storm") => storm::storm(),
        Some("vcan") => vcan::test(&std::env::args().skip(2).collect::<Vec<_>>()),
        Some("vcan-load") => vcan::load(),
        _ => {
            bail!(
                "usage: cargo xtask ci | fuzz | storm | peers | browser | vcan | bench [--instructions] | memory | incidents | rooms [CRATE...] | vcan-load"
            )
        }
    }
}
