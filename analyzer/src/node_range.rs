//! Ranges of node-IDs as typed.

use crate::NodeId;
use std::fmt;
use std::str::FromStr;

/// Consecutive nodes: `5`, `1..8`, `all`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NodeRange {
    first: NodeId,
    last: NodeId,
}

/// Why a text names no nodes.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum NodeError {
    /// The text is no node-ID.
    #[error("expected a node-ID of 1 to 127, found \"{0}\"")]
    Node(String),
    /// The range ends before it begins.
    #[error("expected nodes such as 5, 1..8 or all, found \"{0}\"")]
    Range(String),
}

impl NodeRange {
    /// Whether the node is in the range.
    pub fn contains(self, node: NodeId) -> bool {
        (self.first..=self.last).contains(&node)
    }

    fn nodes(self) -> impl Iterator<Item = NodeId> {
        (self.first.raw()..=self.last.raw()).filter_map(NodeId::new)
    }

    /// All nodes of a list of ranges: `1..8,63`.
    ///
    /// # Errors
    /// [`NodeError`] of the first invalid range.
    pub fn list(text: &str) -> Result<Vec<NodeId>, NodeError> {
        let ranges: Vec<Self> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
        Ok(ranges.into_iter().flat_map(Self::nodes).collect())
    }

    /// Parses a node-ID: 1 to 127, decimal or hexadecimal with 0x.
    ///
    /// # Errors
    /// [`NodeError`] if the text is no node-ID.
    pub fn node(text: &str) -> Result<NodeId, NodeError> {
        let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
            Some(hex) => u8::from_str_radix(hex, 16),
            None => text.parse(),
        };
        number.ok().and_then(NodeId::new).ok_or_else(|| NodeError::Node(text.to_owned()))
    }
}

impl FromStr for NodeRange {
    type Err = NodeError;

    fn from_str(text: &str) -> Result<Self, NodeError> {
        let text = if text.eq_ignore_ascii_case("all") { "1..127" } else { text };
        let (first, last) = text.split_once("..").unwrap_or((text, text));
        let (first, last) = (Self::node(first)?, Self::node(last)?);
        if first > last {
            return Err(NodeError::Range(text.to_owned()));
        }
        Ok(Self { first, last })
    }
}

impl fmt::Display for NodeRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.first == self.last {
            true => write!(f, "{}", self.first),
            false => write!(f, "{}..{}", self.first, self.last),
        }
    }
}
