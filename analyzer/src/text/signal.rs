//! The values of a PDO one by one, typed and with units, for outputs other than text.

use super::Meaning;
use super::object::Object;
use crate::dictionary::{DataClass, DataType, Unit, Value};
use crate::message::{Message, PdoNumber};
use crate::network::{Node, Signal};
use crate::{Multiplexer, NodeId};
use std::borrow::Cow;
use std::fmt;

/// A mapped object of a PDO with its value.
pub struct SignalValue<'a> {
    object: Object<'a>,
    /// The number of bits in the PDO.
    pub bits: u8,
    /// The bits as a number of the object's type; `None` if the PDO is too short for them, or there are more than 64.
    pub raw: Option<Number>,
    scale: Option<Cow<'a, Unit>>,
    /// The number, from 0, among the values of the object in the PDO; `None` if the PDO maps the object once.
    pub repetition: Option<u8>,
}

/// A value by its type.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Number {
    /// BOOLEAN.
    Boolean(bool),
    /// A signed number.
    Integer(i64),
    /// An unsigned number, also for an unknown type.
    Unsigned(u64),
    /// REAL32.
    Real32(f32),
    /// REAL64, or a physical value computed from a raw one.
    Real64(f64),
}

/// The name of an object as in its description, unescaped. Empty if the object has no name.
pub struct Name<'a>(pub(super) Object<'a>);

impl Meaning<'_> {
    /// The values of a PDO or SRDO with known layout, in the order of its mapping, or the single value of a
    /// multiplexed PDO; empty for other frames. Gaps in a mapping (dummy entries) are left out.
    pub fn signals(&self) -> impl Iterator<Item = SignalValue<'_>> {
        let id = self.decoded.node;
        let node = id.and_then(|id| self.bus.node(id));
        let (layout, multiplexed) = match &self.decoded.message {
            Message::Pdo(number) => (node.and_then(|node| node.known_layout(*number)), None),
            Message::Srdo(srdo) => (self.srdo_layout(srdo), None),
            Message::Mpdo(_, mpdo) => (None, Some(self.multiplexed(mpdo))),
            _ => (None, None),
        };
        let signals = layout.into_iter().flat_map(|layout| &layout.signals).filter(|signal| !signal.is_dummy());
        let payload = self.record.frame.data();
        let mapped = signals.map(move |signal| SignalValue::new(Object::mapped(id, node, signal), signal, payload));
        mapped.chain(multiplexed)
    }

    /// Whether the frame is a PDO whose mapping is known.
    pub fn has_known_layout(&self) -> bool {
        let Message::Pdo(number) = self.decoded.message else { return false };
        let node = self.decoded.node.and_then(|id| self.bus.node(id));
        node.is_some_and(|node| node.known_layout(number).is_some())
    }

    /// The name of the frame's object; `None` without an object or a name.
    pub fn object_name(&self) -> Option<Name<'_>> {
        let object = self.decoded.object?;
        let named = match &self.decoded.message {
            Message::Mpdo(_, mpdo) => self.mpdo_object(mpdo),
            _ => Object::new(self.decoded.node, self.decoded.node.and_then(|id| self.bus.node(id)), object),
        };
        named.is_named().then_some(Name(named))
    }
}

impl Node {
    /// The signals of a PDO in its current mapping, without gaps, each with its value in a PDO of zeros: their names,
    /// types and units hold for every such PDO. Empty if the mapping is unknown.
    pub fn signals(&mut self, id: NodeId, pdo: PdoNumber) -> impl Iterator<Item = (&Signal, SignalValue<'_>)> {
        // The layout is computed on demand.
        self.layout(id, pdo);
        let node = &*self;
        let signals = node.known_layout(pdo).into_iter().flat_map(|layout| &layout.signals);
        let signals = signals.filter(|signal| !signal.is_dummy());
        signals.map(move |signal| {
            (signal, SignalValue::new(Object::mapped(Some(id), Some(node), signal), signal, &[0; 64]))
        })
    }
}

impl<'a> SignalValue<'a> {
    fn new(object: Object<'a>, signal: &'a Signal, payload: &[u8]) -> Self {
        let raw = signal.raw(payload).map(|raw| typed(raw, signal.bits, object.data_type()));
        let scale = signal.scale.as_ref().map(Cow::Borrowed);
        Self { object, bits: signal.bits, raw, scale, repetition: signal.repetition }
    }

    /// The value of a multiplexed PDO, which has four bytes for any object.
    pub(super) fn multiplexed(object: Object<'a>, data: [u8; 4]) -> Self {
        let bits = object.data_type().and_then(DataType::bits).filter(|&bits| bits <= 32).unwrap_or(32) as u8;
        let raw = u64::from(u32::from_le_bytes(data)) & ((1 << bits) - 1);
        let scale = object.scale().map(Cow::Owned);
        Self { object, bits, raw: Some(typed(raw, bits, object.data_type())), scale, repetition: None }
    }

    /// The object.
    pub const fn multiplexer(&self) -> Multiplexer {
        self.object.multiplexer
    }

    /// The object's name, if it has one.
    pub fn name(&self) -> Option<Name<'_>> {
        self.object.is_named().then_some(Name(self.object))
    }

    /// The value in the unit of the description or the standard, else in the unit that the device's configuration
    /// determines, else the raw value.
    pub fn value(&self) -> Option<(Number, Option<Cow<'_, Unit>>)> {
        let (fixed, configured) = self.object.units(self.scale.as_deref());
        let unit = fixed.or_else(|| configured.map(Cow::Borrowed));
        Some((physical(self.raw?, unit.as_deref()), unit))
    }

    /// In addition to [`SignalValue::value`], the value in the unit that the device's configuration determines, such as
    /// degrees, if known.
    pub fn scaled(&self) -> Option<(Number, &Unit)> {
        let (Some(_), Some(scale)) = self.object.units(self.scale.as_deref()) else { return None };
        Some((physical(self.raw?, Some(scale)), scale))
    }
}

impl Number {
    /// The nearest floating-point number.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::Boolean(value) => f64::from(u8::from(value)),
            Self::Integer(value) => value as f64,
            Self::Unsigned(value) => value as f64,
            Self::Real32(value) => f64::from(value),
            Self::Real64(value) => value,
        }
    }
}

fn physical(raw: Number, unit: Option<&Unit>) -> Number {
    match unit {
        Some(unit) if !unit.is_raw() => Number::Real64(unit.physical(raw.as_f64())),
        _ => raw,
    }
}

/// The bits as a number. If the mapping has another length than a signed type, the highest mapped bit is the sign.
fn typed(raw: u64, bits: u8, data_type: Option<DataType>) -> Number {
    let value = data_type.filter(|data_type| data_type.bits() == Some(u32::from(bits)));
    match value.and_then(|data_type| Value::from_raw(data_type, raw)) {
        Some(Value::Boolean(value)) => Number::Boolean(value),
        Some(Value::Integer(value)) => Number::Integer(value),
        Some(Value::Real32(value)) => Number::Real32(value),
        Some(Value::Real64(value)) => Number::Real64(value),
        Some(_) => Number::Unsigned(raw),
        None if data_type.and_then(DataType::class) == Some(DataClass::Integer) && (1..=64).contains(&bits) => {
            let unused = 64 - u32::from(bits);
            Number::Integer((raw << unused) as i64 >> unused)
        }
        None => Number::Unsigned(raw),
    }
}

impl fmt::Display for Name<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.name(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_is_that_of_the_mapped_bits() {
        assert_eq!(typed(0xFFFF, 16, Some(DataType::INTEGER16)), Number::Integer(-1));
        assert_eq!(typed(0xFFFF, 16, Some(DataType::INTEGER32)), Number::Integer(-1));
        assert_eq!(typed(0xFFFF, 16, Some(DataType::UNSIGNED32)), Number::Unsigned(0xFFFF));
        assert_eq!(typed(1, 1, Some(DataType::BOOLEAN)), Number::Boolean(true));
        assert_eq!(typed(0x3F80_0000, 32, Some(DataType::REAL32)), Number::Real32(1.0));
        assert_eq!(typed(7, 3, None), Number::Unsigned(7));
        assert_eq!(typed(0, 0, Some(DataType::INTEGER8)), Number::Unsigned(0));
    }

    #[test]
    fn whole_units_keep_numbers_whole() {
        let unit = |factor| Unit { factor, offset: 0.0, symbol: Cow::Borrowed("x") };
        assert_eq!(physical(Number::Unsigned(u64::MAX), Some(&unit(1.0))), Number::Unsigned(u64::MAX));
        assert_eq!(physical(Number::Integer(259), Some(&unit(0.1))), Number::Real64(25.9));
    }
}
