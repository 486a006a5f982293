//! The names and units in a model's sheet: units of objects, names of values, names of bits.

use super::sheet::{Sheet, address};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{Annotations, BitName, Condition, Redundancy, Unit};
use serde::Deserialize;

/// The unit of an object: physical value = raw value * factor + offset.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Signal {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    unit: String,
    factor: f64,
    #[serde(default)]
    offset: f64,
    /// The state of the device in which the raw value is signed, although its data type is not.
    signed_if: Option<State>,
}

/// A state of the device: an object has this value.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct State {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    value: u32,
}

/// Bits of an object that have no meaning in the device, although the standard names them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Unused {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    bits: Vec<u8>,
}

/// The name of a value of an object.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Choice {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    value: u64,
    name: String,
}

/// The name of a bit of an object; `clear` and `set` name the states of the bit if they need names.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Bit {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    bit: u8,
    name: String,
    clear: Option<String>,
    set: Option<String>,
}

/// How PDOs carry an object, if the manual says more than the data type.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mapped {
    #[serde(deserialize_with = "address")]
    at: Multiplexer,
    /// The number of bits, if the data type has more.
    bits: Option<u8>,
    /// The names of the values in a PDO that maps the object several times.
    #[serde(default)]
    channels: Vec<String>,
    /// How two channels hang together.
    redundant: Option<Redundant>,
}

/// Two channels, of which the second changes against the first one.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Redundant {
    /// The state of the device in which both channels change in the same direction.
    same_if: Option<State>,
    /// The raw value of a full turn of an angle.
    turn: Option<u32>,
}

impl State {
    const fn condition(self) -> Condition {
        Condition { at: self.at, value: self.value }
    }
}

impl Sheet {
    /// The annotations. If the device has an object for the bit rate, its codes get the bit rates as names.
    pub(super) fn annotations(&self) -> Annotations {
        let mut annotations = Annotations::default();
        for signal in &self.signals {
            let unit = Unit { factor: signal.factor, offset: signal.offset, symbol: signal.unit.clone().into() };
            let annotation = annotations.entry(signal.at);
            annotation.unit = Some(unit);
            annotation.signed_if = signal.signed_if.map(State::condition);
        }
        for choice in &self.choices {
            annotations.entry(choice.at).choices.push((choice.value, choice.name.clone().into()));
        }
        for bit in &self.bits {
            let state = |state: &String| format!("{}: {state}", bit.name).into();
            let name = bit.set.as_ref().map_or_else(|| bit.name.clone().into(), state);
            let clear = bit.clear.as_ref().map(state);
            annotations.entry(bit.at).bits.push(BitName { bit: bit.bit, name, clear });
        }
        for unused in &self.unused {
            let without_name = |&bit| BitName { bit, name: "".into(), clear: None };
            annotations.entry(unused.at).bits.extend(unused.bits.iter().map(without_name));
        }
        for mapped in &self.mapped {
            let annotation = annotations.entry(mapped.at);
            annotation.mapped_bits = mapped.bits;
            annotation.redundancy = mapped
                .redundant
                .map(|redundant| Redundancy { same_if: redundant.same_if.map(State::condition), turn: redundant.turn });
            annotation.channels = mapped.channels.iter().map(|name| name.clone().into()).collect();
        }
        if let Some(object) = self.network.bit_rate_object {
            let named = self.bit_rates.iter().filter_map(|rate| Some((rate.object_code?, rate.kbit)));
            let choices = named.map(|(code, kbit)| (u64::from(code), format!("{kbit} kbit/s").into()));
            annotations.entry(object).choices.extend(choices);
        }
        annotations
    }
}
