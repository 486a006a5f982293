//! `cargo xtask ci`: everything that must pass, with all its set-up. `cargo xtask bench`: how fast it is, beside its
//! peers.

mod bench;
mod ci;
mod fuzz;
mod packages;
mod run;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(std::path::Path::to_owned);
    std::env::set_current_dir(root.unwrap_or_else(|| ".".into()))?;
    match std::env::args().nth(1).as_deref() {
        Some("ci") => ci::ci(),
        Some("bench") => bench::bench(),
        Some("fuzz") => fuzz::fuzz(),
        _ => bail!("usage: cargo xtask ci | bench | fuzz"),
    }
}
