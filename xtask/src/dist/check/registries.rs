//! What registries of languages get: the libraries for crates.io, the wheel for PyPI.

use crate::python;
use crate::run::run;
use anyhow::Result;

/// The libraries that others may use, each after those that it needs.
const LIBRARIES: [&str; 3] = ["canvass-macros", "canvass-traces", "canvass-analyzer"];

/// Packs the libraries and compiles what was packed, as the registry would get it.
pub fn publish() -> Result<String> {
    let mut words = vec!["publish", "--dry-run", "--locked", "--allow-dirty"];
    words.extend(LIBRARIES.iter().flat_map(|library| ["--package", *library]));
    run("cargo", &words)?;
    Ok("packed, compiled from the package".to_owned())
}

/// Installs the wheel into a clean environment.
pub fn wheel() -> Result<String> {
    python::check()?;
    Ok("installed by pip without an index; its tests".to_owned())
}
