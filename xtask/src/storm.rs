//! Ten million random frames for every simulated device, which must not come to harm.

use crate::run::run;
use anyhow::Result;

/// Builds with all checks, and lets them loose. The arguments are those of `conformance/fuzz/examples/storm.rs`: frames, seed,
/// models.
pub fn storm() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(2).collect();
    let mut command =
        vec!["run", "--profile", "storm", "--locked", "--package", "canvass-fuzzer", "--example", "storm", "--"];
    command.extend(arguments.iter().map(String::as_str));
    run("cargo", &command)
}
