//! `--journal`: the file in which a run on a live bus records its changes, and the journal of an earlier, interrupted
//! run.

use crate::output::{diagnostic, is_seen};
use crate::put_back::{put_back, read};
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_analyzer::NodeId;
use canvass_bus::Bus;
use canvass_suite::bench::{Target, Timing};
use std::io::{self, BufRead, IsTerminal};
use std::path::{Path, PathBuf};

/// The default path of the journal for this bus and node: in the working directory or, if that is read-only, in the
/// temporary folder.
pub fn usual_path(bus: &str, node: NodeId) -> PathBuf {
    let bus: String = bus.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' }).collect();
    let name = format!("canvass-{bus}-node{node}.journal");
    let is_writable = tempfile::tempfile_in(".").is_ok();
    if is_writable { PathBuf::from(name) } else { std::env::temp_dir().join(name) }
}

/// If an earlier run left a journal, restores its device first, with the user's consent: otherwise the run would test
/// a changed device and leave it changed.
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
    if !wanted && !is_answered_yes(&format!("canvass: {why}. Restore the device first? [Y/n] ")) {
        return Err(anyhow!(
            "{why}: `canvass restore {address} --journal {file}` restores the device, --restore does it before this \
             run; if the device is as it should be, remove the file"
        )
        .into());
    }
    let device = if target.model.is_empty() { &interrupted.device } else { &target.model };
    match put_back(bus, device, timing, &interrupted, path)? {
        Status::Good => Ok(()),
        _ => Err(anyhow!(
            "{why}, and some objects could not be restored: remove the file to test the device nevertheless"
        )
        .into()),
    }
}

/// Asks the user; without a terminal the answer is no.
fn is_answered_yes(question: &str) -> bool {
    if !io::stdin().is_terminal() || !is_seen() {
        return false;
    }
    diagnostic(question);
    let mut answer = String::new();
    let read = io::stdin().lock().read_line(&mut answer);
    read.is_ok_and(|bytes| bytes > 0) && matches!(answer.trim(), "" | "y" | "Y" | "yes")
}
