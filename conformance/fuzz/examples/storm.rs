//! Sends random frames to every model: `cargo run --profile storm --example storm [FRAMES [SEED [MODEL...]]]`.
//!
//! The profile enables checks that a release omits: integer overflow and debug assertions.

use canvass_device::models::Model;
use canvass_fuzzer::storm::storm;
use std::io::Write;
use std::time::Instant;

const FRAMES: u64 = 10_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let frames = arguments.first().map_or(Ok(FRAMES), |text| text.parse())?;
    let seed = arguments.get(1).map_or(Ok(1), |text| text.parse())?;
    let wanted = arguments.get(2..).unwrap_or_default();
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{:22} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>7}",
        "model", "frames", "sent", "no node", "initial.", "pre-op.", "operat.", "stopped", "starts", "s"
    )?;
    for model in Model::all().iter().filter(|model| wanted.is_empty() || wanted.iter().any(|id| id == model.id())) {
        let begin = Instant::now();
        let done = storm(model, frames, seed)?;
        let [none, initialising, pre_operational, operational, stopped] = done.by_state;
        writeln!(
            out,
            "{:22} {:>10} {:>10} {none:>9} {initialising:>9} {pre_operational:>9} {operational:>9} {stopped:>9} {:>7} {:>7.1}",
            model.id(),
            done.frames,
            done.sent,
            done.starts,
            begin.elapsed().as_secs_f64(),
        )?;
    }
    Ok(())
}
