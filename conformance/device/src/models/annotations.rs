//! The names and units in a model's sheet: units of objects, names of values, names of bits.

use super::sheet::{Sheet, address};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{Annotations, BitName, Unit};
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

impl Sheet {
    /// The annotations. If the device has an object for the bit rate, its codes get the bit rates as names.
    pub(super) fn annotations(&self) -> Annotations {
        let mut annotations = Annotations::default();
        for signal in &self.signals {
            let unit = Unit { factor: signal.factor, offset: signal.offset, symbol: signal.unit.clone().into() };
            annotations.entry(signal.at).unit = Some(unit);
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
        if let Some(object) = self.network.bit_rate_object {
            let named = self.bit_rates.iter().filter_map(|rate| Some((rate.object_code?, rate.kbit)));
            let choices = named.map(|(code, kbit)| (u64::from(code), format!("{kbit} kbit/s").into()));
            annotations.entry(object).choices.extend(choices);
        }
        annotations
    }
}
