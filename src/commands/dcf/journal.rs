//! The journal of `canvass dcf write`, by which `canvass restore` undoes it.

use crate::commands::test::journal::usual_path;
use crate::output::diagnostic;
use anyhow::{Result, anyhow, bail};
use canvass_analyzer::dictionary::survey::Answer;
use canvass_analyzer::dictionary::survey::Survey;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_suite::journal::{Head, Journal};
use std::path::{Path, PathBuf};

/// The journal of one node, with the way to undo its changes.
pub struct Undo {
    journal: Journal,
    address: String,
    is_kept: bool,
}

/// Where the journal of a node is written.
pub fn path(wanted: Option<&Path>, address: &str, node: NodeId, is_only: bool) -> PathBuf {
    match wanted {
        None => usual_path(address, node),
        Some(path) if is_only => path.to_owned(),
        // Each node has its own journal.
        Some(path) => {
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            name.push(format!("-node{node}"));
            let ending = path.extension().map(|ending| ending.to_owned());
            let path = path.with_file_name(name);
            ending.map_or(path.clone(), |ending| path.with_extension(ending))
        }
    }
}

impl Undo {
    /// Writes the journal, before the first change.
    pub fn begin(
        path: &Path,
        is_kept: bool,
        address: &str,
        node: NodeId,
        device: &str,
        state: Option<State>,
        survey: &Survey,
    ) -> Result<Self> {
        if path.exists() {
            let file = path.display();
            bail!(
                "{file} is there: an earlier run has left node {node} changed; `canvass restore {address} --journal \
                 {file}` puts it back, or remove the file if the device is as it should be"
            );
        }
        let values = survey.answers().filter_map(|(at, answer)| match answer {
            Answer::Value(value) => Some((at, value.clone())),
            _ => None,
        });
        let dictionary: Vec<(Multiplexer, Vec<u8>)> = values.collect();
        let operational = state == Some(State::OPERATIONAL);
        let head = Head { bus: address, node, device, operational, dictionary: &dictionary, zero_point: None };
        let journal =
            Journal::create(path, &head).map_err(|error| anyhow!("can't write {}: {error}", path.display()))?;
        Ok(Self { journal, address: address.to_owned(), is_kept })
    }

    /// Notes that the device is about to store its parameters.
    pub fn store(&mut self) -> Result<()> {
        self.journal.store().map_err(|error| anyhow!("can't write {}: {error}", self.journal.path().display()))
    }

    /// Says how to undo what was written.
    pub fn tell(&self) {
        diagnostic(&format!("canvass: {} undoes what was written", self.command()));
    }

    fn command(&self) -> String {
        format!("`canvass restore {} --journal {}`", self.address, self.journal.path().display())
    }

    /// Ends the journal: everything is written as it was wanted.
    pub fn end(self) -> Result<()> {
        if self.is_kept {
            self.tell();
            return Ok(());
        }
        let path = self.journal.path().to_owned();
        self.journal.remove().map_err(|error| anyhow!("can't remove {}: {error}", path.display()))
    }
}
