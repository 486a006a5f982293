//! `--device NODE=MODEL|FILE`: which device a node is.

use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_device::models::Model;
use std::path::Path;

/// A node and the model or file that describes it, as typed.
#[derive(Clone, Debug)]
pub struct DeviceArg {
    /// The node.
    pub node: NodeId,
    /// The model's id or the file's path.
    pub device: String,
}

impl std::str::FromStr for DeviceArg {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (node, device) = text.split_once('=').context("expected NODE=MODEL or NODE=FILE, such as 5=motor.eds")?;
        let node = parse_node(node)?;
        Ok(Self { node, device: device.to_owned() })
    }
}

/// A node-ID as it is typed: 1 to 127, decimal or hexadecimal with 0x.
pub fn parse_node(text: &str) -> Result<NodeId> {
    let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(hex) => u8::from_str_radix(hex, 16),
        None => text.parse(),
    };
    number.ok().and_then(NodeId::new).ok_or_else(|| anyhow!("expected a node-ID of 1 to 127, found \"{text}\""))
}

impl DeviceArg {
    /// The description of the device.
    pub fn describe(&self) -> Result<DeviceDescription> {
        describe(&self.device)
    }
}

/// The description of a built-in model or in a file.
pub fn describe(device: &str) -> Result<DeviceDescription> {
    if let Some(model) = Model::by_id(device) {
        return Ok(model.description().clone());
    }
    let path = Path::new(device);
    if !path.exists() {
        bail!("\"{device}\" is neither a built-in model (`canvass list models`) nor a file");
    }
    let bytes = std::fs::read(path).with_context(|| format!("can't read {}", path.display()))?;
    DeviceDescription::read(&bytes).with_context(|| format!("{} is no device description", path.display()))
}
