//! The non-volatile memory of a simulated device as TOML text, with one line for each stored value. A user keeps it
//! between runs.

use super::Device;
use super::parameters::Content;
use super::store::StoredNetwork;
use canvass_analyzer::Multiplexer;
use canvass_traces::{Timestamp, hex};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// The stored values of a device. The caller reads and writes the file.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// The id of the model.
    model: String,
    /// The value that the application stores in addition to the parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    offset: Option<i64>,
    /// The node-ID stored by LSS; 255 for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    node_id: Option<u8>,
    /// The index of the bit rate stored by LSS.
    #[serde(skip_serializing_if = "Option::is_none")]
    bit_timing: Option<u8>,
    /// The stored values by address: `"1017:00" = "0x3E8"` for numbers, `"2010:00" = "bytes 41 42"` for other values.
    #[serde(default)]
    values: BTreeMap<String, String>,
}

/// Why a text can't be the memory of this device.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum MemoryError {
    /// The text is no TOML, or has unknown fields.
    #[error("expected the stored values of a device, {0}")]
    Text(#[from] toml::de::Error),
    /// The memory is of another model.
    #[error("expected the stored values of a {expected}, found those of a {found}")]
    Model {
        /// The model of the device.
        expected: String,
        /// The model of the memory.
        found: String,
    },
    /// A line for which the device has no object.
    #[error("expected a stored value such as \"1017:00\" = \"0x3E8\" of an object of the device, found \"{0}\"")]
    Value(String),
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&toml::to_string(self).map_err(|_| fmt::Error)?)
    }
}

impl FromStr for Memory {
    type Err = MemoryError;

    fn from_str(text: &str) -> Result<Self, MemoryError> {
        Ok(toml::from_str(text)?)
    }
}

impl Device {
    /// The currently stored values of the device.
    pub fn memory(&self) -> Memory {
        let (contents, retained) = self.context.store.contents(&self.context.objects.parameters);
        let network = self.context.store.network();
        Memory {
            model: self.context.objects.model.id().to_owned(),
            offset: retained,
            node_id: network.node_id,
            bit_timing: network.bit_timing,
            values: contents.map(|(at, content)| (address(at), text(content))).collect(),
        }
    }

    /// Loads a memory and switches the device on with these values.
    ///
    /// # Errors
    /// [`MemoryError`] if the memory is of another model, or has values for absent objects; the device is then
    /// unchanged.
    pub fn insert_memory(&mut self, now: Timestamp, memory: &Memory) -> Result<(), MemoryError> {
        let expected = self.context.objects.model.id();
        if memory.model != expected {
            return Err(MemoryError::Model { expected: expected.to_owned(), found: memory.model.clone() });
        }
        let mut contents = BTreeMap::new();
        for (address, value) in &memory.values {
            let stored = parse_address(address).zip(parse_content(value));
            let fitting = stored.filter(|(at, content)| {
                let entry = self.context.objects.parameters.entry(*at);
                entry.is_ok_and(|entry| matches!(content, Content::Number(_)) == entry.size().is_some())
            });
            let (at, content) = fitting.ok_or_else(|| MemoryError::Value(format!("{address} = {value}")))?;
            contents.insert(at, content);
        }
        let network = StoredNetwork { node_id: memory.node_id, bit_timing: memory.bit_timing };
        self.context.store.replace(&contents, memory.offset, network, &self.context.objects.parameters);
        self.power_cycle(now);
        Ok(())
    }
}

fn address(at: Multiplexer) -> String {
    format!("{:04X}:{:02X}", at.index.0, at.sub.0)
}

fn parse_address(text: &str) -> Option<Multiplexer> {
    let (index, sub) = text.split_once(':')?;
    Some(Multiplexer::new(u16::from_str_radix(index, 16).ok()?, u8::from_str_radix(sub, 16).ok()?))
}

fn text(content: &Content) -> String {
    match content {
        Content::Number(number) => format!("0x{number:X}"),
        Content::Bytes(bytes) if bytes.is_empty() => "bytes".to_owned(),
        Content::Bytes(bytes) => format!("bytes {}", hex::spaced(bytes)),
    }
}

fn parse_content(text: &str) -> Option<Content> {
    if let Some(digits) = text.strip_prefix("0x") {
        return Some(Content::Number(u64::from_str_radix(digits, 16).ok()?));
    }
    let bytes = text.strip_prefix("bytes")?.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).ok());
    bytes.collect::<Option<Vec<u8>>>().map(Content::Bytes)
}
