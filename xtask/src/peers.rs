//! Other people's programs, for tests that exchange captures and for benchmarks.

use crate::consent;
use crate::packages::{Package, install};
use crate::run::run;
use crate::venv::Venv;
use anyhow::Result;
use std::fs;

/// The Python with the libraries; the tests use the same path.
pub const PYTHON: &str = "target/peers-venv/bin/python";
const VENV: Venv = Venv {
    folder: "target/peers-venv",
    python: PYTHON,
    requirements: "tests/peers/requirements.txt",
    probe: "import can, canopen, mcap, mcap_ros2, rosbags, serial, cantools, pytest_lsp",
};

const TSHARK: Package = Package { program: "tshark", probe: &["--version"], package: "tshark" };
/// The probe reads standard input, which is empty here.
const CAN_UTILS: Package = Package { program: "log2long", probe: &[], package: "can-utils" };
/// The validator of XML documents.
const XMLLINT: Package = Package { program: "xmllint", probe: &["--version"], package: "libxml2-utils" };

const NODE: Package = Package { program: "node", probe: &["--version"], package: "nodejs" };
const NPM: Package = Package { program: "npm", probe: &["--version"], package: "npm" };
/// The folder of the extension for Visual Studio Code, where npm installs its packages.
const EXTENSION: &str = "editors/vscode";

/// Installs tshark, can-utils, xmllint, the Python environment of the tests, and the packages of the extension.
pub fn install_all() -> Result<()> {
    install(&[TSHARK, CAN_UTILS, XMLLINT, NODE, NPM])?;
    extension()?;
    install_python()
}

/// Installs the Python environment alone.
pub fn install_python() -> Result<()> {
    VENV.install()
}

/// Installs the packages in the lock file of the extension.
fn extension() -> Result<()> {
    let library = format!("{EXTENSION}/node_modules/vscode-languageclient/package.json");
    let lock = format!("{EXTENSION}/package-lock.json");
    let installed = format!("{EXTENSION}/node_modules/.package-lock.json");
    let written = |path: &str| fs::metadata(path).and_then(|data| data.modified()).ok();
    if fs::exists(library)? && written(&installed) >= written(&lock) {
        return Ok(());
    }
    let npm = ["--prefix", EXTENSION, "ci", "--no-audit", "--no-fund"];
    consent::ask(&format!("what {EXTENSION} needs"), &format!("npm {}", npm.join(" ")))?;
    run("npm", &npm)
}

/// Runs the tests that need these programs.
pub fn test() -> Result<()> {
    install_all()?;
    run("cargo", &["test", "--locked", "--features", "peers", "--test", "peers"])
}
