//! Annotations of objects: units, names of values, names of bits.

use super::names::{self, Unit};
use crate::Multiplexer;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The meaning of an object's values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Annotation {
    /// The unit of a number.
    pub unit: Option<Unit>,
    /// Names of single values.
    pub choices: Vec<(u64, Cow<'static, str>)>,
    /// Names of bits.
    pub bits: Vec<BitName>,
    /// Names of the object's values in a PDO that maps the object several times, in the order of the mapping.
    pub channels: Vec<Cow<'static, str>>,
    /// How the channels of the object hang together; `None` if they are independent.
    pub redundancy: Option<Redundancy>,
    /// Number of bits with which PDOs carry the object, if the manual gives fewer than the data type has.
    pub mapped_bits: Option<u8>,
    /// The state of the device in which the object is signed, although its data type is not.
    pub signed_if: Option<Condition>,
}

/// How two channels of an object hang together: the second changes against the first one, or with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Redundancy {
    /// The state of the device in which both channels change in the same direction; `None` if they never do.
    pub same_if: Option<Condition>,
    /// The raw value of a full turn of an angle; `None` for values that do not wrap.
    pub turn: Option<u32>,
}

/// A state of a device: an object has this value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Condition {
    /// The object.
    pub at: Multiplexer,
    /// The value of the object.
    pub value: u32,
}

/// The name of a bit, and of its two states if they have names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitName {
    /// The bit, from 0.
    pub bit: u8,
    /// The meaning of the set bit.
    pub name: Cow<'static, str>,
    /// The meaning of the clear bit, if it is worth mentioning.
    pub clear: Option<Cow<'static, str>>,
}

/// The annotations of a dictionary. An entry with sub-index FFh holds for all sub-indexes of its index but 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Annotations(BTreeMap<Multiplexer, Annotation>);

impl Annotations {
    /// The annotation of an object, if there is one.
    pub fn get(&self, object: Multiplexer) -> Option<&Annotation> {
        let all = Multiplexer::new(object.index.0, 0xFF);
        self.0.get(&object).or_else(|| self.0.get(&all).filter(|_| object.sub.0 != 0))
    }

    /// The annotation of an object of a device of that profile: without its own, that of the object whose bits have the
    /// same meaning.
    pub fn of(&self, object: Multiplexer, profile: Option<u16>) -> Option<&Annotation> {
        self.get(object).or_else(|| {
            let twin = names::same_bits(object.index, profile)?;
            self.get(Multiplexer { index: twin, ..object })
        })
    }

    /// Whether the meaning of an object's values depends on this object.
    pub fn is_condition(&self, object: Multiplexer) -> bool {
        let of = |annotation: &Annotation| {
            let redundancy = annotation.redundancy.and_then(|redundancy| redundancy.same_if);
            [annotation.signed_if, redundancy].into_iter().flatten().any(|condition| condition.at == object)
        };
        self.0.values().any(of)
    }

    /// The annotation of an object, for changes. An object without an annotation gets an empty one.
    pub fn entry(&mut self, object: Multiplexer) -> &mut Annotation {
        self.0.entry(object).or_default()
    }
}

impl Annotation {
    /// The named bit; `None` if the bit has no name.
    pub fn bit(&self, bit: u8) -> Option<&BitName> {
        self.bits.iter().find(|name| name.bit == bit)
    }

    /// The name of a value.
    pub fn choice(&self, value: u64) -> Option<&str> {
        self.choices.iter().find(|choice| choice.0 == value).map(|choice| &*choice.1)
    }
}
