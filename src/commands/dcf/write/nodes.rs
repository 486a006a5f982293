//! Which file is written to which node.

use crate::commands::dcf::file::ConfigurationFile;
use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::dictionary::configuration::Project;
use canvass_analyzer::{NodeError, NodeId, NodeRange};
use canvass_traces::small_file::{self, OF_HAND};
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

/// Nodes as typed: `5`, `1..8`, `1,5`.
#[derive(Clone, Debug)]
pub struct Nodes(Vec<NodeId>);

impl FromStr for Nodes {
    type Err = NodeError;

    fn from_str(text: &str) -> Result<Self, NodeError> {
        NodeRange::list(text).map(Self)
    }
}

/// The nodes with their files. A project of a network names both.
pub fn plan(path: &Path, wanted: Option<&Nodes>) -> Result<Vec<(NodeId, Arc<ConfigurationFile>)>> {
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("cpj")) {
        return project(path, wanted);
    }
    let file = Arc::new(ConfigurationFile::read(path)?);
    let nodes = match (wanted, file.node()) {
        (Some(nodes), _) => nodes.0.clone(),
        (None, Some(node)) => vec![node],
        (None, None) => bail!("{} names no node-ID: use --node N", path.display()),
    };
    Ok(nodes.into_iter().map(|node| (node, Arc::clone(&file))).collect())
}

fn project(path: &Path, wanted: Option<&Nodes>) -> Result<Vec<(NodeId, Arc<ConfigurationFile>)>> {
    let name = path.display();
    let bytes = small_file::read(path, OF_HAND).with_context(|| format!("can't read {name}"))?;
    let project = Project::read(&bytes).with_context(|| format!("{name} is no project of a network"))?;
    let is_wanted = |node: NodeId| wanted.is_none_or(|nodes| nodes.0.contains(&node));
    let nodes = project.nodes.iter().filter(|(node, _)| is_wanted(**node));
    let files = nodes.map(|(node, known)| {
        let file = ConfigurationFile::read(&path.with_file_name(&known.dcf))?;
        Ok((*node, Arc::new(file)))
    });
    let files: Vec<_> = files.collect::<Result<_>>()?;
    if files.is_empty() {
        return Err(anyhow!("{name} has none of these nodes"));
    }
    Ok(files)
}
