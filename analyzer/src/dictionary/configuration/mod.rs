//! The configuration of a device: which entries are settings, their values in a DCF or XDC for a node-ID, and the order
//! in which a device takes them.

mod concise;
mod from_device;
mod order;
mod project;
mod rebase;
mod setting;

pub use concise::{BadConcise, read_concise, write_concise};
pub use from_device::{ReadConfiguration, from_device};
pub use order::{companions, is_cob_id, ordered};
pub use project::{BadProject, Project, ProjectNode};
pub use setting::{DeviceSettings, Excluded, Hazard};

use super::description::DeviceDescription;
use super::object::{Entry, Setting};
use super::value::{Value, ValueError};
use crate::identity::{Multiplexer, NodeId};
use crate::object;
use rebase::rebased;

/// A value for an object.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Download {
    /// The object.
    pub at: Multiplexer,
    /// The value, little-endian.
    pub value: Vec<u8>,
}

impl From<&(Multiplexer, Vec<u8>)> for Download {
    fn from((at, value): &(Multiplexer, Vec<u8>)) -> Self {
        Self { at: *at, value: value.clone() }
    }
}

/// Why a configured value can't be written to a node.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum BadSetting {
    /// The value does not fit the data type of its entry.
    #[error("{at}: {error}")]
    Value {
        /// The entry.
        at: Multiplexer,
        /// Why it does not fit.
        error: ValueError,
    },
    /// Two nodes would send with the same CAN-ID.
    #[error(
        "{at}: the CAN-ID {can_id:03X}h is for node {of}, and would be sent by node {node} too: write it as \
         $NODEID+0x… in the file, or give the node a file of its own"
    )]
    Shared {
        /// The entry.
        at: Multiplexer,
        /// The CAN-ID.
        can_id: u32,
        /// The node whose file it is.
        of: NodeId,
        /// The other node.
        node: NodeId,
    },
}

/// The configured values of a description for a node, without read-only entries. Formulas are resolved with the
/// node-ID, and COB-IDs of the predefined connection set follow the node-ID.
///
/// # Errors
/// All values that can't be written to this node.
pub fn configured(description: &DeviceDescription, node: NodeId) -> Result<Vec<Download>, Vec<BadSetting>> {
    let own = description.commissioning.as_ref().and_then(|commissioning| commissioning.node_id);
    let (mut downloads, mut bad) = (Vec::new(), Vec::new());
    for (at, entry) in description.dictionary.entries().filter(|(_, entry)| entry.access.is_writable()) {
        let Some(setting) = &entry.configured else { continue };
        match value_for(at, entry, setting, own, node) {
            Ok(value) => downloads.push(Download { at, value }),
            Err(error) => bad.push(error),
        }
    }
    if bad.is_empty() { Ok(downloads) } else { Err(bad) }
}

fn value_for(
    at: Multiplexer,
    entry: &Entry,
    setting: &Setting,
    own: Option<NodeId>,
    node: NodeId,
) -> Result<Vec<u8>, BadSetting> {
    let value = match (setting.resolve(entry.data_type, node), setting) {
        (Value::Unsigned(raw), Setting::Fixed(_)) => Value::Unsigned(rebased(at, raw, own, node)?),
        (value, _) => value,
    };
    value.encode(entry.data_type).map_err(|error| BadSetting::Value { at, error })
}

/// The parts of 1018h that a device with this configuration has, by sub-index: configured values, defaults, or the
/// numbers of the file's head. The serial number only if the file is for this node.
pub fn identity(description: &DeviceDescription, node: NodeId) -> [Option<u32>; 4] {
    let own = description.commissioning.as_ref();
    let entry = |sub| description.dictionary.entry(Multiplexer::new(object::IDENTITY, sub)).ok();
    let number = |value: Option<Value>| value.and_then(|value| u32::try_from(value.to_raw()?).ok());
    let described = |sub| number(entry(sub).and_then(|entry| entry.start_value(node)));
    let device = &description.device;
    let serial = || {
        let configured = entry(4).and_then(|entry| Some(entry.configured.as_ref()?.resolve(entry.data_type, node)));
        let named = own.and_then(|commissioning| commissioning.lss_serial_number);
        named.or_else(|| number(configured)).filter(|serial| *serial != 0)
    };
    let is_own = own.and_then(|commissioning| commissioning.node_id).is_none_or(|own| own == node);
    [
        described(1).or(device.vendor_number),
        described(2).or(device.product_number),
        described(3).or(device.revision_number),
        is_own.then(serial).flatten(),
    ]
}

/// A setting that reads as this value for the node: a formula where the described default is one with the same offset,
/// so that the file serves other nodes too. `None` if the bytes are no value of the entry's data type.
pub fn setting_of(entry: &Entry, bytes: &[u8], node: NodeId) -> Option<Setting> {
    let value = Value::decode(entry.data_type, bytes).ok()?;
    match &entry.default {
        Some(formula @ Setting::NodeIdPlus(_)) if formula.resolve(entry.data_type, node) == value => {
            Some(formula.clone())
        }
        _ => Some(Setting::Fixed(value)),
    }
}

#[cfg(test)]
mod tests;
