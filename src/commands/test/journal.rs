//! `--journal`: where a run on a live bus writes down what it changes, and what becomes of the journal of an earlier run that
//! did not come to its end.

use crate::output::{diagnostic, is_seen};
use crate::put_back::{put_back, read};
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_analyzer::NodeId;
use canvass_bus::Bus;
use canvass_suite::bench::{Target, Timing};
use std::io::{self, BufRead, IsTerminal};
use std::path::{Path, PathBuf};

/// The journal of runs on that device of that bus: in the folder in which the run is started, or, where nothing can be
/// written there, in that for temporary files.
pub fn usual_path(bus: &str, node: NodeId) -> PathBuf {
    let bus: String = bus.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' }).collect();
    let name = format!("canvass-{bus}-node{node}.journal");
    let is_writable = tempfile::tempfile_in(".").is_ok();
    if is_writable { PathBuf::from(name) } else { std::env::temp_dir().join(name) }
}

/// If an earlier run has left a journal, its device is put back first, if the user wants that: it is not as it was, and
/// would be found, tested and left so.
pub fn settle(
    path: &Path,
    wanted: bool,
    address: &str,
    bus: &mut dyn Bus,
    target: &Target,
    timing: Timing,
) -> Result<(), Failure> {
    if !path.exists() {
        return Ok(());
    }
    let (file, interrupted) = (path.display(), read(path)?);
    let why = format!("an earlier run on node {} was interrupted and has left {file}", interrupted.node);
    if !wanted && !is_answered_yes(&format!("canvass: {why}. Put the device back first? [Y/n] ")) {
        return Err(anyhow!(
            "{why}: `canvass restore {address} --journal {file}` puts the device back, --restore does it before this run; \
             if it is as it should be, remove the file"
        )
        .into());
    }
    let device = if target.model.is_empty() { &interrupted.device } else { &target.model };
    match put_back(bus, device, timing, &interrupted, path)? {
        Status::Good => Ok(()),
        _ => {
            Err(anyhow!("{why}, and not all could be put back: remove the file to test the device all the same").into())
        }
    }
}

/// Nobody is asked where nobody answers.
fn is_answered_yes(question: &str) -> bool {
    if !io::stdin().is_terminal() || !is_seen() {
        return false;
    }
    diagnostic(question);
    let mut answer = String::new();
    let read = io::stdin().lock().read_line(&mut answer);
    read.is_ok_and(|bytes| bytes > 0) && matches!(answer.trim(), "" | "y" | "Y" | "yes")
}
