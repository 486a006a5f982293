//! Values as text.

use super::escaped::Escaped;
use super::object::Object;
use crate::dictionary::names::Meaning;
use crate::dictionary::{DataClass, DataType, Unit, Value};
use std::fmt;

/// A value as text, using its type and meaning if known.
pub(super) struct ValueText<'v> {
    pub bytes: &'v [u8],
    pub object: &'v Object<'v>,
    /// The unit that the device's configuration determines, if known already.
    pub scale: Option<&'v Unit>,
    /// Whether the value has fewer bytes than its data type, as the device's manual says.
    pub is_shortened: bool,
}

/// Maximum number of bytes shown of a long value.
const SHOWN: usize = 64;

impl ValueText<'_> {
    fn number(&self, raw: u64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(done) = self.choice(raw, f) {
            return done;
        }
        let meaning = self.object.meaning(raw as i64);
        // A value with a meaning of its own is no quantity.
        if meaning.is_none()
            && let Some(done) = self.physical(raw as f64, f)
        {
            return done;
        }
        if let Some(text) = signature(self.bytes) {
            return write!(f, "\"{text}\"");
        }
        match (meaning, self.bytes.len()) {
            (Some(_), 0..=1) => write!(f, "{raw}")?,
            (_, length) => hexadecimal(raw, length, f)?,
        }
        self.bits(raw, meaning, f)
    }

    /// Writes a value with fewer bytes than its type has; the highest bit of a signed value is its sign.
    fn shortened(&self, class: Option<DataClass>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut raw = [0; 8];
        match raw.get_mut(..self.bytes.len()) {
            Some(low) if class == Some(DataClass::Integer) && !low.is_empty() => {
                let unused = 64 - 8 * low.len() as u32;
                low.copy_from_slice(self.bytes);
                self.integer((u64::from_le_bytes(raw) << unused) as i64 >> unused, f)
            }
            _ => self.untyped(f),
        }
    }

    /// The meaning of the whole value, the names of the set bits, and of clear bits whose clear state has a name.
    fn bits(&self, raw: u64, meaning: Option<Meaning>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bits = 8 * self.bytes.len().min(8) as u8;
        let mut first = meaning.is_none();
        if let Some(meaning) = meaning {
            write!(f, " ({meaning}")?;
        }
        for name in self.object.bits(raw, bits) {
            write!(f, "{}{}", if first { " (" } else { ", " }, Escaped(name))?;
            first = false;
        }
        if first { Ok(()) } else { f.write_str(")") }
    }

    /// The value with the name that the device's manual gives it; `None` if it gives none.
    fn choice(&self, raw: u64, f: &mut fmt::Formatter<'_>) -> Option<fmt::Result> {
        self.object.choice(raw).map(|name| write!(f, "{raw} ({})", Escaped(name)))
    }

    fn integer(&self, value: i64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(done) = u64::try_from(value).ok().and_then(|raw| self.choice(raw, f)) {
            return done;
        }
        if let Some(done) = self.physical(value as f64, f) {
            return done;
        }
        match self.object.meaning(value) {
            Some(name) => write!(f, "{value} ({name})"),
            None => write!(f, "{value}"),
        }
    }

    /// The value in its unit, and in the unit that the device's configuration determines; `None` if it has neither.
    fn physical(&self, raw: f64, f: &mut fmt::Formatter<'_>) -> Option<fmt::Result> {
        let computed = if self.scale.is_none() { self.object.scale() } else { None };
        match self.object.units(self.scale.or(computed.as_ref())) {
            (None, None) => None,
            (Some(unit), None) => Some(physical(raw, &unit, f)),
            (None, Some(scale)) => Some(physical(raw, scale, f)),
            (Some(unit), Some(scale)) => Some(both(raw, &unit, scale, f)),
        }
    }

    /// Writes a value without a type: a short value as a number, a longer one as text if it is printable, else as
    /// bytes.
    fn untyped(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = &self.bytes[..self.bytes.len().min(SHOWN)];
        match self.bytes {
            [] => f.write_str("empty"),
            &[a] => self.number(u64::from(a), f),
            &[a, b] => self.number(u64::from(u16::from_le_bytes([a, b])), f),
            &[a, b, c] => self.number(u64::from(u32::from_le_bytes([a, b, c, 0])), f),
            &[a, b, c, d] => self.number(u64::from(u32::from_le_bytes([a, b, c, d])), f),
            bytes if bytes.iter().all(|byte| matches!(byte, b' '..=b'~')) => {
                write!(f, "{}", Value::VisibleString(shown.to_vec()))?;
                ellipsis(self.bytes.len(), f)
            }
            _ => {
                write!(f, "{}", Value::Domain(shown.to_vec()))?;
                ellipsis(self.bytes.len(), f)
            }
        }
    }
}

impl fmt::Display for ValueText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let class = self.object.data_type().and_then(DataType::class);
        let text = matches!(class, Some(DataClass::VisibleString | DataClass::OctetString | DataClass::Domain));
        let kept = if text { &self.bytes[..self.bytes.len().min(SHOWN)] } else { self.bytes };
        match self.object.data_type().map(|data_type| Value::decode(data_type, kept)) {
            Some(Ok(Value::Unsigned(raw))) => self.number(raw, f),
            Some(Ok(Value::Integer(value))) => self.integer(value, f),
            Some(Ok(value)) => {
                write!(f, "{value}")?;
                if text { ellipsis(self.bytes.len(), f) } else { Ok(()) }
            }
            Some(Err(_)) if self.is_shortened => self.shortened(class, f),
            Some(Err(error)) => {
                self.untyped(f)?;
                write!(f, " [{error}]")
            }
            None => self.untyped(f),
        }
    }
}

/// Writes small numbers in decimal, others in hexadecimal with the width of their type.
fn hexadecimal(raw: u64, bytes: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match (raw, bytes) {
        (0..=9, _) => write!(f, "{raw}"),
        (_, 0..=1) => write!(f, "{raw} ({raw:02X}h)"),
        (_, 2) => {
            digits(raw, bytes, f)?;
            write!(f, "h ({raw})")
        }
        _ => {
            digits(raw, bytes, f)?;
            f.write_str("h")
        }
    }
}

/// Writes two digits for each byte, faster than `{:0width$X}`.
fn digits(raw: u64, bytes: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    const HEX: &[u8; 16] = b"0123456789ABCDEF";
    let mut text = [0; 16];
    for (n, digit) in text.iter_mut().rev().enumerate() {
        *digit = HEX[(raw >> (4 * n) & 15) as usize];
    }
    let kept = &text[text.len() - 2 * bytes.min(8)..];
    f.write_str(std::str::from_utf8(kept).unwrap_or_default())
}

/// Writes `19642 steps (863.173828°)`.
fn both(raw: f64, unit: &Unit, scale: &Unit, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    physical(raw, unit, f)?;
    f.write_str(" (")?;
    physical(raw, scale, f)?;
    f.write_str(")")
}

fn physical(raw: f64, unit: &Unit, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let blank = if unit.symbol == "°" { "" } else { " " };
    write!(f, "{}{blank}{}", unit.physical(raw), Escaped(&unit.symbol))
}

/// The text of signatures such as `save` and `load`.
fn signature(bytes: &[u8]) -> Option<&str> {
    let four_letters = bytes.len() == 4 && bytes.iter().all(u8::is_ascii_lowercase);
    four_letters.then(|| std::str::from_utf8(bytes).ok()).flatten()
}

fn ellipsis(len: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if len > SHOWN { f.write_str("…") } else { Ok(()) }
}
