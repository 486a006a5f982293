//! Annotations of objects: units, names of values, names of bits.

use super::names::Unit;
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
