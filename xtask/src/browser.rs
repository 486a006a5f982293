//! The browser for the tests of the pages.

use crate::packages::{Package, install};
use crate::run::run;
use anyhow::Result;

const CHROMIUM: Package = Package { program: "chromium", probe: &["--version", "--no-sandbox"], package: "chromium" };
const DRIVER: Package = Package { program: "chromedriver", probe: &["--version"], package: "chromium-driver" };
/// Without a font, pages show no text.
const FONT: Package = Package { program: "fc-match", probe: &["sans-serif"], package: "fonts-dejavu-core" };

/// Installs Chromium and its driver.
pub fn install_all() -> Result<()> {
    install(&[CHROMIUM, DRIVER, FONT])
}

/// Runs the browser tests.
pub fn test() -> Result<()> {
    install_all()?;
    run("cargo", &["test", "--locked", "--features", "browser", "--test", "browser"])
}
