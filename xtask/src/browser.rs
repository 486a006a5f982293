//! The browser in which the tests look at the pages.

use crate::packages::{Package, install};
use crate::run::run;
use anyhow::Result;

const CHROMIUM: Package = Package { program: "chromium", probe: &["--version", "--no-sandbox"], package: "chromium" };
const DRIVER: Package = Package { program: "chromedriver", probe: &["--version"], package: "chromium-driver" };
/// Without a font there is nothing to see.
const FONT: Package = Package { program: "fc-match", probe: &["sans-serif"], package: "fonts-dejavu-core" };

/// Installs Chromium and what drives it.
pub fn install_all() -> Result<()> {
    install(&[CHROMIUM, DRIVER, FONT])
}

/// Runs the tests that need it.
pub fn test() -> Result<()> {
    install_all()?;
    run("cargo", &["test", "--locked", "--features", "browser", "--test", "browser"])
}
