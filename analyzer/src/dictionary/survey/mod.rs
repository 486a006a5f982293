//! The answers of a device to reading its object dictionary: compares them with its description, or makes a
//! description from them.
//!
//! Nothing here accesses a device: the caller reads the device and fills a [`Survey`].

pub mod compare;
pub mod describe;

use crate::identity::{Index, Multiplexer, SubIndex};
use crate::object;
use crate::wire::sdo::AbortCode;
use canvass_traces::hex;
use std::collections::BTreeMap;
use std::fmt;

/// The answer of a device to reading an entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A value with these bytes.
    Value(Vec<u8>),
    /// A value longer than the limit; the number is its minimum length in bytes.
    Long(usize),
    /// An abort.
    Aborted(AbortCode),
    /// No answer.
    Silent,
    /// A message that breaks the protocol, in words.
    Violated(String),
}

impl Answer {
    /// Whether the device has the entry; `None` if the answer does not show it.
    pub const fn exists(&self) -> Option<bool> {
        match self {
            Self::Value(_) | Self::Long(_) => Some(true),
            Self::Aborted(AbortCode::NO_OBJECT | AbortCode::NO_SUB_INDEX) => Some(false),
            Self::Aborted(AbortCode::WRITE_ONLY) => Some(true),
            Self::Aborted(_) if self.is_momentary() => Some(true),
            Self::Aborted(_) | Self::Silent | Self::Violated(_) => None,
        }
    }

    /// Whether the entry exists, but has no value at the moment.
    pub const fn is_momentary(&self) -> bool {
        matches!(self, Self::Aborted(AbortCode(0x0800_0020..=0x0800_0024)))
    }
}

/// `4 bytes: 92 01 01 00`, `abort 0602 0000h object does not exist in the object dictionary`.
impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(bytes) => write!(f, "{}", Bytes(bytes)),
            Self::Long(most) => write!(f, "more than {most} bytes"),
            Self::Aborted(code) => write!(f, "abort {code}"),
            Self::Silent => f.write_str("no answer"),
            Self::Violated(violation) => f.write_str(violation),
        }
    }
}

/// Shows the first bytes of a value, few enough to be read at a glance, and the total number of bytes.
struct Bytes<'a>(&'a [u8]);

impl fmt::Display for Bytes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 8;
        match self.0.len() {
            0 => return f.write_str("no bytes"),
            1 => f.write_str("1 byte: ")?,
            more => write!(f, "{more} bytes: ")?,
        }
        hex::spaced(&self.0[..self.0.len().min(SHOWN)]).fmt(f)?;
        f.write_str(if self.0.len() > SHOWN { " …" } else { "" })
    }
}

/// The answers of one device, by address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    answers: BTreeMap<Multiplexer, Answer>,
}

impl Survey {
    /// Stores an answer.
    pub fn insert(&mut self, at: Multiplexer, answer: Answer) {
        self.answers.insert(at, answer);
    }

    /// The answer at that address, if it was read.
    pub fn get(&self, at: Multiplexer) -> Option<&Answer> {
        self.answers.get(&at)
    }

    /// All answers, by address.
    pub fn answers(&self) -> impl Iterator<Item = (Multiplexer, &Answer)> {
        self.answers.iter().map(|(at, answer)| (*at, answer))
    }

    /// The answers of one object.
    pub fn of(&self, index: Index) -> impl Iterator<Item = (SubIndex, &Answer)> {
        let at = |sub| Multiplexer { index, sub: SubIndex(sub) };
        self.answers.range(at(0)..=at(0xFF)).map(|(at, answer)| (at.sub, answer))
    }

    /// The bytes read at that address.
    pub fn value(&self, at: Multiplexer) -> Option<&[u8]> {
        match self.get(at) {
            Some(Answer::Value(bytes)) => Some(bytes),
            _ => None,
        }
    }

    /// The bytes read at that address as a number, if there are at most eight.
    pub fn number(&self, at: Multiplexer) -> Option<u64> {
        let bytes = self.value(at).filter(|bytes| (1..=8).contains(&bytes.len()))?;
        Some(bytes.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    /// The value of sub-index 0, if it can be a count.
    pub fn count(&self, index: Index) -> Option<u8> {
        let at = Multiplexer { index, sub: SubIndex(0) };
        self.value(at).and_then(|bytes| <[u8; 1]>::try_from(bytes).ok()).map(|[count]| count)
    }

    /// The number of the device profile: the low word of 1000h.
    pub fn device_profile(&self) -> Option<u16> {
        self.number(Multiplexer::new(object::DEVICE_TYPE, 0)).map(|device_type| device_type as u16)
    }

    /// The number of answered entries, and of existing ones among them.
    pub fn counts(&self) -> (usize, usize) {
        let existing = self.answers.values().filter(|answer| answer.exists() == Some(true));
        (self.answers.len(), existing.count())
    }
}

impl FromIterator<(Multiplexer, Answer)> for Survey {
    fn from_iter<T: IntoIterator<Item = (Multiplexer, Answer)>>(answers: T) -> Self {
        Self { answers: answers.into_iter().collect() }
    }
}
