//! `canvass decode`.

use super::{Contract, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A line of `canvass decode`: a frame. The program writes lines by hand for speed; a test compares them with the type.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DecodeLine {
    /// The name and version of the contract, only in the first line.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Option<Word>,
    /// The time of the frame.
    pub t: u64,
    pub channel: String,
    /// The CAN-ID.
    pub id: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fd: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub xl: Option<bool>,
    /// For a remote frame: the length that it requests.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dlc: Option<u8>,
    /// `rx` or `tx`, if the capture contains the direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<Word>,
    pub data: String,
    /// The node of the frame: its sender, the SDO server, or the node that an NMT command names.
    pub node: Option<u8>,
    pub service: Word,
    /// The source of the knowledge about the CAN-ID: `predefined`, `description` or `trace`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<Word>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub index: Option<u16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sub: Option<u8>,
    /// The name of the object that the frame is about.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub violation: Option<Violation>,
    /// For a PDO whose mapping is known: the mapped objects, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<Signal>,
    /// The meaning of the frame in words.
    pub text: String,
    /// The comment of the capture on the frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comment: Option<String>,
}

/// The rule of the SDO protocol that the frame breaks.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Violation {
    /// `toggle`, `multiplexer`, `size`, `crc`, `sequence` or `unexpected`.
    pub rule: Word,
    pub text: String,
}

/// A mapped object.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Signal {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    pub index: u16,
    pub sub: u8,
    /// The number by its type; `null` if the PDO is too short for the object, or JSON can't express the number.
    pub raw: Option<Number>,
    #[serde(default, with = "said", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Number>")]
    pub value: Option<Option<Number>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The value as scaled by the configuration of the device.
    #[serde(default, with = "said", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Number>")]
    pub scaled: Option<Option<Number>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaled_unit: Option<String>,
}

/// A number of any type of CANopen.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Number {
    Boolean(bool),
    Unsigned(u64),
    Integer(i64),
    Real(f64),
}

/// A member that may be absent, `null` or a value: absence and `null` have different meanings.
mod said {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<T: Serialize, S: Serializer>(said: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        said.serialize(serializer)
    }

    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Option<T>, D::Error> {
        T::deserialize(from).map(Some)
    }
}

impl Contract for DecodeLine {
    const SCHEMA: &'static str = "canvass/decode/1";
    const COMMAND: &'static str = "canvass decode";
}
