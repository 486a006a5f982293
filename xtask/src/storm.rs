//! Ten million random frames for every simulated device, none of which may cause a panic.

use crate::run::run;
use anyhow::Result;

/// Builds the example with all checks, and runs it. The arguments are those of `conformance/fuzz/examples/storm.rs`:
/// frames, seed, models.
pub fn storm() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(2).collect();
    let mut command =
        vec!["run", "--profile", "storm", "--locked", "--package", "canvass-fuzzer", "--example", "storm", "--"];
    command.extend(arguments.iter().map(String::as_str));
    run("cargo", &command)
}
