//! An object as text: its address, name and values.

use super::escaped::Escaped;
use super::value::ValueText;
use crate::dictionary::names::{Meaning, ObjectName, bit_names, meaning, object_name, unit};
use crate::dictionary::{Annotation, DataType, Entry, Object as DescribedObject, Unit};
use crate::network::{Node, Signal};
use crate::{Multiplexer, NodeId};
use std::borrow::Cow;
use std::fmt;

/// An object of a node: `1018h:01 Identity object, Vendor-ID`.
#[derive(Clone, Copy)]
pub(super) struct Object<'a> {
    id: Option<NodeId>,
    node: Option<&'a Node>,
    pub multiplexer: Multiplexer,
    object: Option<&'a DescribedObject>,
    entry: Option<&'a Entry>,
    standard: Option<ObjectName>,
    annotation: Option<&'a Annotation>,
    profile: Option<u16>,
    /// The number, from 0, among the values of the object in a PDO that maps the object several times.
    repetition: Option<u8>,
}

impl<'a> Object<'a> {
    pub fn new(id: Option<NodeId>, node: Option<&'a Node>, multiplexer: Multiplexer) -> Self {
        let device = node.and_then(|node| node.device.as_deref());
        let object = device.and_then(|device| device.description.dictionary.object(multiplexer.index));
        let profile = id.zip(node).and_then(|(id, node)| node.profile(id));
        Self {
            id,
            node,
            multiplexer,
            object,
            entry: object.and_then(|object| object.entry(multiplexer.sub)),
            standard: object_name(multiplexer, profile),
            annotation: device.and_then(|device| device.manual.annotations.of(multiplexer, profile)),
            profile,
            repetition: None,
        }
    }

    /// The object of a signal.
    pub fn mapped(id: Option<NodeId>, node: Option<&'a Node>, signal: &Signal) -> Self {
        Self { repetition: signal.repetition, ..Self::new(id, node, signal.object) }
    }

    /// Whether PDOs carry the object with this number of bits by the device's manual, although its data type has more.
    pub fn is_shortened_to(&self, bits: u8) -> bool {
        self.annotation.is_some_and(|annotation| annotation.mapped_bits == Some(bits))
    }

    /// Writes the name of the channel after the name of the object: ` A`, or ` #1` if the manual has no name.
    fn channel(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(repetition) = self.repetition else { return Ok(()) };
        match self.annotation.and_then(|annotation| annotation.channels.get(usize::from(repetition))) {
            Some(name) => write!(f, " {}", Escaped(name)),
            None => write!(f, " #{}", u16::from(repetition) + 1),
        }
    }

    pub fn data_type(&self) -> Option<DataType> {
        let standard = || self.standard.and_then(|name| name.entry).and_then(|entry| entry.data_type);
        let described = self.entry.map(|entry| entry.data_type);
        // Few objects have a type that depends on another object.
        if self.annotation.is_some_and(|annotation| annotation.signed_if.is_some())
            && let (Some(node), Some(id)) = (self.node, self.id)
        {
            return node.data_type(id, self.multiplexer).or(described);
        }
        described.or_else(standard)
    }

    pub fn choice(&self, raw: u64) -> Option<&'a str> {
        self.annotation.and_then(|annotation| annotation.choice(raw))
    }

    /// The meaning of a whole value in the standard or the device's profile.
    pub fn meaning(&self, value: i64) -> Option<Meaning> {
        meaning(self.multiplexer, value, self.profile)
    }

    /// The unit of the object in the description or the standard.
    pub fn unit(&self) -> Option<Cow<'a, Unit>> {
        let annotated = self.annotation.and_then(|annotation| annotation.unit.as_ref());
        annotated.map(Cow::Borrowed).or_else(|| unit(self.multiplexer, self.profile).map(Cow::Owned))
    }

    /// The unit of the object that the device's configuration determines.
    pub fn scale(&self) -> Option<Unit> {
        self.node.zip(self.id).and_then(|(node, id)| node.scale(id, self.multiplexer))
    }

    /// The unit of the object, and the unit that the device's configuration adds. If both have the same symbol, the
    /// configured unit alone: it holds for this device, the other one for the device as delivered.
    pub fn units<'u>(&self, configured: Option<&'u Unit>) -> (Option<Cow<'a, Unit>>, Option<&'u Unit>) {
        let fixed = self.unit().filter(|fixed| configured.is_none_or(|configured| fixed.symbol != configured.symbol));
        (fixed, configured)
    }

    /// The names of the set bits among the first `count`, and of clear bits whose clear state has a name.
    pub fn bits(&self, raw: u64, count: u8) -> impl Iterator<Item = &'a str> {
        let of_standard = bit_names(self.multiplexer.index, self.profile);
        let annotation = self.annotation;
        // Most values are numbers, whose bits have no names, and so are the numbers of entries at sub-index 0.
        let is_number = annotation.is_none() && of_standard.is_empty() || self.is_number_of_entries();
        let count = if is_number { 0 } else { count };
        (0..count).filter_map(move |bit| {
            let set = raw >> bit & 1 != 0;
            match annotation.and_then(|annotation| annotation.bit(bit)) {
                Some(name) if set => Some(&*name.name).filter(|name| !name.is_empty()),
                Some(name) => name.clear.as_deref(),
                None if set => of_standard.get(usize::from(bit)).copied().filter(|name| !name.is_empty()),
                None => None,
            }
        })
    }

    /// Whether the object is sub-index 0 of an array or record.
    fn is_number_of_entries(&self) -> bool {
        let described = self.object.map(|object| object.code.is_single());
        let is_single = described.or_else(|| self.standard.map(|name| name.object.code.is_single()));
        self.multiplexer.sub.0 == 0 && is_single == Some(false)
    }

    /// A value of the object.
    pub fn value<'v>(&'v self, bytes: &'v [u8]) -> ValueText<'v> {
        ValueText { bytes, object: self, scale: None, is_shortened: false }
    }

    /// The value in the first bytes, in the length of the object's data type; further bytes are ignored. If the type has
    /// no fixed length, all bytes are the value. Used for SDO values without a size, and for PDOs.
    pub fn leading<'v>(&'v self, bytes: &'v [u8]) -> ValueText<'v> {
        let length = self.data_type().and_then(DataType::bytes).unwrap_or(bytes.len());
        self.value(&bytes[..length.min(bytes.len())])
    }
}

/// Writes the names of the description; without a description, the names of the standard; then the name of the channel.
impl fmt::Display for Object<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.multiplexer.fmt(f)?;
        self.escaped_name(f)?;
        self.channel(f)
    }
}

impl Object<'_> {
    /// Whether the description or a standard has a name for the object.
    pub fn is_named(&self) -> bool {
        self.object.is_some() || self.standard.is_some()
    }

    /// Writes the name after a blank, escaped.
    fn escaped_name(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(object) = self.object else {
            return self.standard.map_or(Ok(()), |name| write!(f, " {name}"));
        };
        write!(f, " {}", Escaped(&object.name))?;
        match self.entry {
            Some(entry) if !object.code.is_single() => write!(f, ", {}", Escaped(&entry.name)),
            _ => Ok(()),
        }
    }

    /// The name without the address, unescaped.
    pub fn name(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.object, self.entry) {
            (None, _) => self.standard.map_or(Ok(()), |name| write!(f, "{name}"))?,
            (Some(object), Some(entry)) if !object.code.is_single() => write!(f, "{}, {}", object.name, entry.name)?,
            (Some(object), _) => f.write_str(&object.name)?,
        }
        self.channel(f)
    }
}
