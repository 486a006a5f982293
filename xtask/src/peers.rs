//! Other people's programs, with which the tests exchange captures and the benchmarks compare.

use crate::consent;
use crate::packages::{Package, install};
use crate::run::{is_there, run};
use anyhow::Result;
use std::fs;

/// Where the Python libraries are; the tests know this place.
pub const PYTHON: &str = "target/peers-venv/bin/python";
const VENV: &str = "target/peers-venv";
const REQUIREMENTS: &str = "tests/peers/requirements.txt";
/// The requirements that the environment was made for.
const INSTALLED: &str = "target/peers-venv/requirements.txt";

const TSHARK: Package = Package { program: "tshark", probe: &["--version"], package: "tshark" };
/// It reads its standard input, which is empty here.
const CAN_UTILS: Package = Package { program: "log2long", probe: &[], package: "can-utils" };
/// Holds XML against a schema.
const XMLLINT: Package = Package { program: "xmllint", probe: &["--version"], package: "libxml2-utils" };
/// Debian's Python has neither venv nor pip by itself.
const VENV_MODULE: Package =
    Package { program: "python3", probe: &["-c", "import ensurepip, venv"], package: "python3-venv" };

/// Installs tshark, can-utils, xmllint and a Python environment with what the tests' requirements name.
pub fn install_all() -> Result<()> {
    install(&[TSHARK, CAN_UTILS, XMLLINT])?;
    let wanted = fs::read_to_string(REQUIREMENTS)?;
    let is_installed = fs::read_to_string(INSTALLED).is_ok_and(|installed| installed == wanted);
    if is_installed && is_there(PYTHON, &["-c", "import can, canopen, mcap, mcap_ros2, rosbags, serial, cantools"]) {
        return Ok(());
    }
    install(&[VENV_MODULE])?;
    let pip = format!("pip install --requirement {REQUIREMENTS}");
    consent::ask("a Python environment in target/peers-venv", &pip)?;
    run("python3", &["-m", "venv", "--clear", VENV])?;
    run(PYTHON, &["-m", "pip", "install", "--quiet", "--requirement", REQUIREMENTS])?;
    fs::write(INSTALLED, wanted)?;
    Ok(())
}

/// Runs the tests that need them.
pub fn test() -> Result<()> {
    install_all()?;
    run("cargo", &["test", "--locked", "--features", "peers", "--test", "peers"])
}
