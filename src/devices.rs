//! `--device NODE=MODEL|FILE`: which device a node is.

use crate::output::diagnostic;
use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::dictionary::{DeviceDescription, EdsProblem, KnownDevice, Severity};
use canvass_analyzer::{NodeId, NodeRange, meant};
use canvass_device::models::Model;
use canvass_traces::small_file::{self, OF_HAND};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Nodes and the model or file that describes them, as typed.
#[derive(Clone, Debug)]
pub struct DeviceArg {
    pub nodes: Vec<NodeId>,
    /// The model's id or the file's path.
    pub device: String,
}

impl std::str::FromStr for DeviceArg {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (nodes, device) = text.split_once('=').context("expected NODE=MODEL or NODE=FILE, such as 5=motor.eds")?;
        Ok(Self { nodes: NodeRange::list(nodes)?, device: device.to_owned() })
    }
}

/// A node-ID as it is typed: 1 to 127, decimal or hexadecimal with 0x.
pub fn parse_node(text: &str) -> Result<NodeId> {
    Ok(NodeRange::node(text)?)
}

impl DeviceArg {
    /// The model or the description of the device.
    pub fn describe(&self) -> Result<KnownDevice> {
        describe(&self.device)
    }
}

/// Tells which device each node is. A device of fewer nodes comes before that of `all`.
///
/// # Errors
/// If a description can't be read, or a node has two.
pub fn each(devices: &[DeviceArg], mut describe: impl FnMut(NodeId, &Arc<KnownDevice>)) -> Result<()> {
    let is_of_all = |device: &&DeviceArg| device.nodes.len() == NodeId::ALL.len();
    let (of_all, of_some): (Vec<&DeviceArg>, Vec<&DeviceArg>) = devices.iter().partition(is_of_all);
    for group in [of_all, of_some] {
        let mut named: BTreeMap<NodeId, &str> = BTreeMap::new();
        for device in group {
            for &node in &device.nodes {
                if let Some(other) = named.insert(node, &device.device).filter(|other| *other != device.device) {
                    let of = if device.nodes.len() == NodeId::ALL.len() {
                        "all nodes".to_owned()
                    } else {
                        format!("node {node}")
                    };
                    bail!("{other} and {} can't both be the device of {of}: name the nodes of each", device.device);
                }
            }
            let known = Arc::new(device.describe()?);
            device.nodes.iter().for_each(|node| describe(*node, &known));
        }
    }
    Ok(())
}

/// The model or file in `MODEL`, `FILE` or `NODE=FILE`.
pub fn named(device: &str) -> &str {
    device.split_once('=').map_or(device, |(_, device)| device)
}

/// Reads a built-in model, or the description in a file.
pub fn describe(device: &str) -> Result<KnownDevice> {
    if let Some(model) = Model::by_id(device) {
        return Ok(KnownDevice::clone(model.device()));
    }
    let path = Path::new(device);
    if !path.exists() {
        let meant = meant(device, Model::all().iter().map(Model::id));
        bail!("\"{device}\" is neither a built-in model (`canvass list models`) nor a file{meant}");
    }
    let description = read(path)?;
    tell_problems(path, &description.problems);
    Ok(KnownDevice::described(description))
}

/// Reads the description in a file, with its problems. A description with unreadable parts is refused: it would
/// describe another device.
pub fn read(path: &Path) -> Result<DeviceDescription> {
    let bytes = small_file::read(path, OF_HAND).with_context(|| format!("can't read {}", path.display()))?;
    let description =
        DeviceDescription::read(&bytes).with_context(|| format!("{} is no device description", path.display()))?;
    description.usable().map_err(|unusable| anyhow!("{}: {unusable}", path.display()))?;
    Ok(description)
}

/// Prints the problems of a description in one line, and how to see all of them.
fn tell_problems(path: &Path, problems: &[EdsProblem]) {
    let of = |severity| problems.iter().filter(move |problem| problem.severity() == severity);
    let first = of(Severity::Error).next().or_else(|| of(Severity::Warning).next());
    if let Some(first) = first {
        let count = summary(problems);
        let path = path.display();
        diagnostic(&format!("{path}: {count}; the first: {first} (`canvass eds check {path}` shows all)"));
    }
}

/// The number of problems: `1 error, 2 warnings`.
pub fn summary(problems: &[EdsProblem]) -> String {
    let count = |severity, name: &str| {
        let count = problems.iter().filter(|problem| problem.severity() == severity).count();
        format!("{count} {name}{}", if count == 1 { "" } else { "s" })
    };
    format!("{}, {}", count(Severity::Error, "error"), count(Severity::Warning, "warning"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<()> {
        let description = DeviceDescription::read(text.as_bytes()).unwrap();
        Ok(description.usable()?)
    }

    #[test]
    fn nodes_are_lists_and_ranges() {
        let nodes = |text: &str| -> Vec<u8> {
            let device: DeviceArg = format!("{text}=x.eds").parse().unwrap();
            device.nodes.iter().map(|node| node.raw()).collect()
        };
        assert_eq!(nodes("5"), [5]);
        assert_eq!(nodes("0x7F,1..3"), [127, 1, 2, 3]);
        assert_eq!(nodes("all").len(), 127);
        for wrong in ["", "0", "3..1", "1..128", "1.3", "1,"] {
            assert!(format!("{wrong}=x.eds").parse::<DeviceArg>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_node_has_one_device_and_all_is_for_the_others() {
        let told = |args: &[&str]| -> Result<Vec<String>> {
            let devices: Vec<DeviceArg> = args.iter().map(|text| text.parse().unwrap()).collect();
            let mut of = BTreeMap::new();
            each(&devices, |node, known| _ = of.insert(node, known.description.device.product_name.clone()))?;
            Ok([5, 6].map(|node| of[&NodeId::new(node).unwrap()].clone()).to_vec())
        };
        let (specific, general) = ("5=lika-ax58", "all=kuebler-sendix-58x8");
        let both = told(&[specific, general]).unwrap();
        assert_eq!(both, told(&[general, specific]).unwrap(), "the order does not matter");
        assert_ne!(both[0], both[1]);
        let reason = |args: &[&str]| told(args).unwrap_err().to_string();
        assert_eq!(
            reason(&["all=lika-ax58", general]),
            "lika-ax58 and kuebler-sendix-58x8 can't both be the device of all nodes: name the nodes of each"
        );
        assert!(reason(&["4..6=lika-ax58", "6=kuebler-sendix-58x8", general]).contains("device of node 6"));
    }

    #[test]
    fn a_conflict_is_refused() {
        let text = "[FileInfo]\n<<<<<<< HEAD\nX=1\n=======\nX=2\n>>>>>>> other\n";
        assert!(read(text).unwrap_err().to_string().contains("line 2 begins an unresolved merge conflict"));
        assert!(read("[FileInfo]\n;=======\nX=1\n").is_ok());
    }

    #[test]
    fn what_is_half_unread_is_refused() {
        let good = "[FileInfo]\nFileName=x.eds\n[DeviceInfo]\nVendorName=x\n";
        assert!(read(good).is_ok());
        let refused = read(&format!("{good}one\ntwo\nthree\nfour\nfive\n")).unwrap_err().to_string();
        assert!(refused.contains("5 of 9 lines"), "{refused}");
    }
}
