//! An object by its address and name, and its values in words.

use super::value::ValueText;
use crate::Multiplexer;
use crate::dictionary::{Annotation, DataType};
use crate::network::Node;
use std::fmt;

/// An object of a node: `1018h:01 Vendor-ID`.
pub(super) struct Object<'a> {
    multiplexer: Multiplexer,
    /// The name of the object, where the entry's own name does not say enough.
    object: Option<&'a str>,
    name: Option<&'a str>,
    data_type: Option<DataType>,
    annotation: Option<&'a Annotation>,
}

impl<'a> Object<'a> {
    pub fn new(node: Option<&'a Node>, multiplexer: Multiplexer) -> Self {
        let description = node.and_then(|node| node.description.as_deref());
        let object = description.and_then(|description| description.dictionary.object(multiplexer.index));
        let entry = object.and_then(|object| object.entry(multiplexer.sub));
        Self {
            multiplexer,
            object: object.filter(|object| !object.code.is_single()).map(|object| object.name.as_str()),
            name: entry.map(|entry| entry.name.as_str()),
            data_type: entry.map(|entry| entry.data_type),
            annotation: description.and_then(|description| description.annotations.get(multiplexer)),
        }
    }

    /// A value of the object.
    pub fn value<'v>(&'v self, bytes: &'v [u8]) -> ValueText<'v> {
        ValueText { bytes, data_type: self.data_type, annotation: self.annotation }
    }

    /// The first bytes of a value, as many as the object's type has: of an SDO whose length is not said, or of a
    /// PDO.
    pub fn leading<'v>(&'v self, bytes: &'v [u8]) -> ValueText<'v> {
        let length = self.data_type.and_then(DataType::bytes).unwrap_or(bytes.len());
        self.value(&bytes[..length.min(bytes.len())])
    }
}

impl fmt::Display for Object<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.multiplexer.fmt(f)?;
        if let Some(object) = self.object {
            write!(f, " {}", object.escape_debug())?;
        }
        match self.name {
            Some(name) => write!(f, "{} {}", if self.object.is_some() { "," } else { "" }, name.escape_debug()),
            None => Ok(()),
        }
    }
}
