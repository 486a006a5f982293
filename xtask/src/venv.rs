//! Environments of Python with what a list of requirements names.

use crate::consent;
use crate::packages::{Package, install};
use crate::run::{is_there, run};
use anyhow::Result;
use std::fs;

/// Debian's Python has neither venv nor pip by itself.
const VENV_MODULE: Package =
    Package { program: "python3", probe: &["-c", "import ensurepip, venv"], package: "python3-venv" };

/// An environment.
pub struct Venv {
    /// Its folder.
    pub folder: &'static str,
    /// Its Python, in that folder.
    pub python: &'static str,
    /// The file that names what is in it.
    pub requirements: &'static str,
    /// A statement that works where all of it is there.
    pub probe: &'static str,
}

impl Venv {
    /// Makes it, unless it is there and as its requirements say.
    ///
    /// # Errors
    /// If it may not be made, or something can't be installed.
    pub fn install(&self) -> Result<()> {
        let wanted = fs::read_to_string(self.requirements)?;
        // The requirements that the environment was made for.
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
