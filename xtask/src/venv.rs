//! Python environments with the packages of a requirements file.

use crate::consent;
use crate::packages::{Package, install};
use crate::run::{is_there, run};
use anyhow::Result;
use std::fs;

/// Debian's Python has neither venv nor pip by itself.
const VENV_MODULE: Package =
    Package { program: "python3", probe: &["-c", "import ensurepip, venv"], package: "python3-venv" };

/// A Python environment.
pub struct Venv {
    /// The folder of the environment.
    pub folder: &'static str,
    /// The Python interpreter in this folder.
    pub python: &'static str,
    /// The requirements file.
    pub requirements: &'static str,
    /// A statement that works only if all packages are installed.
    pub probe: &'static str,
}

impl Venv {
    /// Makes the environment, unless it exists and matches its requirements.
    ///
    /// # Errors
    /// If there is no permission to make the environment, or a package can't be installed.
    pub fn install(&self) -> Result<()> {
        let wanted = fs::read_to_string(self.requirements)?;
        // A copy of the requirements from which the environment was made.
        let kept = format!("{}/requirements.txt", self.folder);
        let is_installed = fs::read_to_string(&kept).is_ok_and(|installed| installed == wanted);
        if is_installed && is_there(self.python, &["-c", self.probe]) {
            return Ok(());
        }
        install(&[VENV_MODULE])?;
        let pip = format!("pip install --requirement {}", self.requirements);
        consent::ask(&format!("a Python environment in {}", self.folder), &pip)?;
        run("python3", &["-m", "venv", "--clear", self.folder])?;
        run(self.python, &["-m", "pip", "install", "--quiet", "--requirement", self.requirements])?;
        fs::write(kept, wanted)?;
        Ok(())
    }
}
