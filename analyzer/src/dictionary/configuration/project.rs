//! The project file of a network (CiA 306-3, `nodelist.cpj`): its nodes, each with its DCF.
//!
//! ```text
//! [TOPOLOGY]
//! NetName=line 3
//! Nodes=0x01
//! Node5Present=0x01
//! Node5Name=press
//! Node5DCFName=node5.dcf
//! ```

use crate::dictionary::source::{DescriptionError, Source};
use crate::identity::NodeId;
use std::collections::BTreeMap;

/// A network: its name and its nodes.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Project {
    /// `NetName`.
    pub name: String,
    /// The nodes that are present.
    pub nodes: BTreeMap<NodeId, ProjectNode>,
}

/// A node of a network.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct ProjectNode {
    /// `NodexName`.
    pub name: String,
    /// `NodexDCFName`: the DCF beside the project file.
    pub dcf: String,
}

/// Why a file is no project of a network.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum BadProject {
    /// The file can't be read.
    #[error(transparent)]
    Source(#[from] DescriptionError),
    /// The file has no section `[TOPOLOGY]`.
    #[error("expected the section [TOPOLOGY] of a network project (CiA 306-3), found none")]
    Topology,
    /// A present node has no DCF.
    #[error("node {0} is present, but has no Node{0}DCFName")]
    Dcf(NodeId),
}

impl Project {
    /// Reads a project file.
    ///
    /// # Errors
    /// [`BadProject`] if the file is none, or a present node lacks its DCF.
    pub fn read(bytes: &[u8]) -> Result<Self, BadProject> {
        let source = Source::read(bytes)?;
        let section = source.section("TOPOLOGY").ok_or(BadProject::Topology)?;
        let mut project = Self::default();
        let mut present: BTreeMap<NodeId, bool> = BTreeMap::new();
        for field in section.fields() {
            let value = field.value().trim();
            match key(field.name()) {
                Key::Name => value.clone_into(&mut project.name),
                Key::Present(node) => {
                    present.insert(node, !matches!(value, "" | "0" | "0x0" | "0x00"));
                }
                Key::NodeName(node) => value.clone_into(&mut project.nodes.entry(node).or_default().name),
                Key::Dcf(node) => value.clone_into(&mut project.nodes.entry(node).or_default().dcf),
                Key::Other => {}
            }
        }
        project.nodes.retain(|node, _| present.get(node) == Some(&true));
        let lacking = present
            .into_iter()
            .find(|(node, is_present)| *is_present && project.nodes.get(node).is_none_or(|known| known.dcf.is_empty()));
        lacking.map_or(Ok(project), |(node, _)| Err(BadProject::Dcf(node)))
    }

    /// The text of the project file.
    pub fn text(&self) -> String {
        let one_line = |text: &str| text.replace(|c: char| c.is_control(), " ");
        let mut text =
            format!("[TOPOLOGY]\r\nNetName={}\r\nNodes=0x{:02X}\r\n", one_line(&self.name), self.nodes.len());
        for (node, ProjectNode { name, dcf }) in &self.nodes {
            let (name, dcf) = (one_line(name), one_line(dcf));
            text.push_str(&format!("Node{node}Present=0x01\r\nNode{node}Name={name}\r\nNode{node}DCFName={dcf}\r\n"));
        }
        text
    }
}

/// The meaning of a field's name.
enum Key {
    Name,
    Present(NodeId),
    NodeName(NodeId),
    Dcf(NodeId),
    Other,
}

fn key(name: &str) -> Key {
    let lower = name.trim().to_ascii_lowercase();
    if lower == "netname" {
        return Key::Name;
    }
    let Some(rest) = lower.strip_prefix("node") else { return Key::Other };
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let (number, property) = rest.split_at(digits);
    let Some(node) = number.parse().ok().and_then(NodeId::new) else { return Key::Other };
    match property {
        "present" => Key::Present(node),
        "name" => Key::NodeName(node),
        "dcfname" => Key::Dcf(node),
        _ => Key::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_is_read_as_written() {
        let node = |name: &str, dcf: &str| ProjectNode { name: name.to_owned(), dcf: dcf.to_owned() };
        let nodes = [(5, node("press", "node5.dcf")), (127, node("", "last.dcf"))];
        let nodes = nodes.into_iter().map(|(raw, node)| (NodeId::new(raw).unwrap(), node)).collect();
        let project = Project { name: "line 3".to_owned(), nodes };
        assert_eq!(Project::read(project.text().as_bytes()), Ok(project));
    }

    /// A node that is not present is left out; one without a DCF is an error; another file is none.
    #[test]
    fn what_lacks_a_dcf_is_told() {
        let text = "[Topology]\nNode3Present=0\nNode3DCFName=a.dcf\nNode4Present=1\nNode4DCFName=b.dcf\n";
        let project = Project::read(text.as_bytes()).unwrap();
        assert_eq!(project.nodes.keys().map(|node| node.raw()).collect::<Vec<_>>(), [4]);
        let lacking = Project::read(b"[Topology]\nNode3Present=0x01\n").unwrap_err();
        assert_eq!(lacking.to_string(), "node 3 is present, but has no Node3DCFName");
        assert_eq!(Project::read(b"[FileInfo]\nFileName=x.eds\n"), Err(BadProject::Topology));
    }
}
