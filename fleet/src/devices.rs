//! `--device`: which device a node is, by its node-ID or by its identity.
//!
//! Rules are plain data: they are sent with a plan to the computer that reads the captures, with the contents of files.

use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::network::{Candidate, Candidates, Fact};
use canvass_analyzer::{Multiplexer, NodeId, NodeRange, object};
use canvass_device::models::Model;
use canvass_traces::small_file::{self, OF_HAND};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

/// All rules about devices; the first rule that matches a node decides.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default, Serialize, Deserialize)]
pub struct Devices(Vec<Rule>);

/// The nodes of a device, and the description of this device.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
pub struct Rule {
    /// The nodes that the rule matches.
    who: Who,
    /// The description of these nodes.
    description: Description,
}

/// The nodes that a rule matches.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
enum Who {
    /// Nodes with these node-IDs.
    Nodes(Vec<u8>),
    /// Nodes with all of these identity values: sub-indexes of 1018h with their values.
    Identity(Vec<(u8, u32)>),
}

/// The source of a device's description.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
enum Description {
    /// A built-in model.
    Model(String),
    /// A file, with its content.
    File { name: String, content: Vec<u8> },
}

/// Why a rule can't be used.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// The syntax of the rule is wrong.
    #[error(
        "\"{0}\": expected NODE=FILE, such as 5=motor.eds, or vendor:N,product:N,revision:N=FILE with at least one of \
         them, such as product:0x2011=motor.eds; FILE may be a built-in model"
    )]
    Syntax(String),
    /// The rule names an invalid node-ID.
    #[error("\"{rule}\": {source}")]
    Nodes {
        /// The rule as typed.
        rule: String,
        /// The reason.
        source: canvass_analyzer::NodeError,
    },
    /// The rule names neither a model nor a file.
    #[error("\"{0}\" is neither a built-in model (`canvass list models`) nor a file")]
    Missing(String),
    /// The file of the description can't be read.
    #[error("can't read {name}: {reason}")]
    Unreadable {
        /// The file.
        name: String,
        /// The reason.
        reason: String,
    },
}

impl Devices {
    /// Makes the rules from their parts, in order of precedence.
    pub fn new(rules: Vec<Rule>) -> Self {
        Self(rules)
    }

    /// Whether there are no rules.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Passes the devices of named nodes to `describe`, and all candidates for the recognition of other nodes to
    /// `offer`.
    ///
    /// # Errors
    /// If a description can't be read.
    pub fn tell(
        &self,
        mut describe: impl FnMut(NodeId, Arc<KnownDevice>),
        offer: impl FnOnce(Candidates),
    ) -> Result<(), DeviceError> {
        let mut said = Vec::new();
        for rule in &self.0 {
            let known = Arc::new(rule.description.known()?);
            match &rule.who {
                Who::Nodes(nodes) => {
                    nodes
                        .iter()
                        .filter_map(|&node| NodeId::new(node))
                        .for_each(|node| describe(node, Arc::clone(&known)));
                }
                Who::Identity(values) => said.push(Candidate::said(
                    rule.description.name(),
                    values.iter().map(|&(sub, value)| (identity(sub), Fact::Number(vec![value]))).collect(),
                    known,
                )),
            }
        }
        offer(Candidates::new(move || said.into_iter().chain(Model::all().iter().map(Model::candidate)).collect()));
        Ok(())
    }
}

const fn identity(sub: u8) -> Multiplexer {
    Multiplexer::new(object::IDENTITY, sub)
}

impl Description {
    fn read(device: &str) -> Result<Self, DeviceError> {
        if Model::by_id(device).is_some() {
            return Ok(Self::Model(device.to_owned()));
        }
        let path = Path::new(device);
        if !path.exists() {
            return Err(DeviceError::Missing(device.to_owned()));
        }
        let unreadable = |reason: String| DeviceError::Unreadable { name: device.to_owned(), reason };
        let content = small_file::read(path, OF_HAND).map_err(|error| unreadable(error.to_string()))?;
        let file = Self::File { name: device.to_owned(), content };
        // An error in the description is reported before any capture is read.
        file.known()?;
        Ok(file)
    }

    fn known(&self) -> Result<KnownDevice, DeviceError> {
        let (name, content) = match self {
            Self::Model(id) => {
                let model = Model::by_id(id).ok_or_else(|| DeviceError::Missing(id.clone()))?;
                return Ok(KnownDevice::clone(model.device()));
            }
            Self::File { name, content } => (name, content),
        };
        let unreadable = |reason: String| DeviceError::Unreadable { name: name.clone(), reason };
        let description = DeviceDescription::read(content).map_err(|error| unreadable(error.to_string()))?;
        description.usable().map_err(|error| unreadable(error.to_string()))?;
        Ok(KnownDevice::described(description))
    }

    fn name(&self) -> &str {
        match self {
            Self::Model(name) | Self::File { name, .. } => name,
        }
    }
}

impl FromStr for Rule {
    type Err = DeviceError;

    fn from_str(text: &str) -> Result<Self, DeviceError> {
        let syntax = || DeviceError::Syntax(text.to_owned());
        let (who, device) = text.split_once('=').ok_or_else(syntax)?;
        let who = if who.contains(':') {
            Who::Identity(who.split(',').map(|part| value(part).ok_or_else(syntax)).collect::<Result<_, _>>()?)
        } else {
            let nodes = NodeRange::list(who).map_err(|source| DeviceError::Nodes { rule: text.to_owned(), source })?;
            Who::Nodes(nodes.into_iter().map(NodeId::raw).collect())
        };
        Ok(Self { who, description: Description::read(device)? })
    }
}

/// Parses `product:0x2011` into a sub-index of 1018h and its value.
fn value(part: &str) -> Option<(u8, u32)> {
    let (name, number) = part.split_once(':')?;
    let sub = ["vendor", "product", "revision", "serial"].iter().position(|known| *known == name)? as u8 + 1;
    let number = match number.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok()?,
        None => number.parse().ok()?,
    };
    Some((sub, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_as_typed() {
        let rule: Rule = "vendor:19,product:0x2011=kuebler-sendix-58x8".parse().unwrap();
        assert_eq!(rule.who, Who::Identity(vec![(1, 19), (2, 0x2011)]));
        let rule: Rule = "1..3,63=kuebler-sendix-58x8".parse().unwrap();
        assert_eq!(rule.who, Who::Nodes(vec![1, 2, 3, 63]));
        for wrong in ["", "5", "0=kuebler-sendix-58x8", "colour:5=kuebler-sendix-58x8", "product:=x", "5=none.eds"] {
            assert!(wrong.parse::<Rule>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn rules_are_plain_data() {
        let devices = Devices::new(vec!["product:1=kuebler-sendix-58x8".parse().unwrap()]);
        let json = serde_json::to_string(&devices).unwrap();
        assert_eq!(serde_json::from_str::<Devices>(&json).unwrap(), devices);
    }
}
