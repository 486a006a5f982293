//! Steps of CI beside others: another xtask, whose output goes to a file and is printed when it ends.
//!
//! A compilation leaves a third of two processors idle: crates wait for each other, and linking has one thread. So what
//! compiles in a target folder of its own runs beside the compilation of the workspace.

use crate::consent;
use crate::run::{is_there, target_folder, this_program};
use anyhow::{Context, Result, ensure};
use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command};
use std::sync::Mutex;

/// A command of xtask that runs beside others.
pub struct Aside {
    words: &'static [&'static str],
    running: Mutex<Option<Running>>,
}

struct Running {
    child: Child,
    log: PathBuf,
}

impl Aside {
    pub const fn new(words: &'static [&'static str]) -> Self {
        Self { words, running: Mutex::new(None) }
    }

    /// Starts the command.
    pub fn begin(&self) -> Result<()> {
        let running = start(self.words)?;
        if let Ok(mut place) = self.running.lock() {
            *place = Some(running);
        }
        Ok(())
    }

    /// Waits for the command, which is started if it was not, and prints its output.
    pub fn end(&self) -> Result<()> {
        let begun = self.running.lock().ok().and_then(|mut place| place.take());
        let Running { mut child, log } = begun.map_or_else(|| start(self.words), Ok)?;
        let status = child.wait()?;
        eprintln!("{}", std::fs::read_to_string(&log).with_context(|| log.display().to_string())?);
        ensure!(status.success(), "cargo xtask {} ended with {status}", self.words.join(" "));
        Ok(())
    }
}

fn start(words: &[&str]) -> Result<Running> {
    eprintln!("$ cargo xtask {} (beside the next steps)", words.join(" "));
    let folder = target_folder().join("ci");
    std::fs::create_dir_all(&folder)?;
    let log = folder.join(format!("{}.log", words.join("_")));
    let (out, errors) = (File::create(&log)?, File::options().append(true).open(&log)?);
    let mut command = behind(this_program()?);
    let child = command.args(consent::words()).args(words).stdout(out).stderr(errors).spawn();
    Ok(Running { child: child.context("can't run another xtask")?, log })
}

/// A command that leaves the processors to the steps in front, where there is a program for that.
fn behind(program: PathBuf) -> Command {
    if !is_there("nice", &["--version"]) {
        return Command::new(program);
    }
    let mut nice = Command::new("nice");
    nice.args(["-n", "5"]).arg(program);
    nice
}
