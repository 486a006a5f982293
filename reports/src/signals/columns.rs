//! The columns of a sheet: one for each object, channel of the object, unit and type in the PDOs.

use canvass_analyzer::{Multiplexer, NodeId, Number, SignalValue};
use canvass_traces::ChannelId;
use std::collections::{HashMap, HashSet};

/// A column of values of one type.
pub struct Column {
    /// The name of the column: `node 63 Position value [steps]`, and for other channels than that of the first column
    /// `can1 node 63 Position value [steps]`.
    pub name: String,
    /// The channel of the PDO.
    pub channel: ChannelId,
    /// The node that the PDO belongs to.
    pub node: NodeId,
    /// The name of the object as in the description, such as `Position value`. If it has no name, the object's address.
    pub label: String,
    /// The symbol of the unit. Empty if there is none.
    pub unit: String,
    number: usize,
}

/// All columns, in the order of their first values.
#[derive(Default)]
pub struct Columns {
    columns: Vec<Column>,
    by_key: HashMap<Key, Vec<usize>>,
    names: HashSet<String>,
    /// Number of values without a column, because there are too many columns.
    pub left_out: u64,
}

/// The properties that distinguish columns, apart from the unit.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    channel: ChannelId,
    node: NodeId,
    object: Multiplexer,
    /// The number of the value among the values of the object in its PDO.
    repetition: Option<u8>,
    scaled: bool,
    kind: u8,
}

/// The place of a value.
pub struct Place<'a> {
    pub channel: ChannelId,
    pub channel_name: &'a str,
    pub node: NodeId,
    pub signal: &'a SignalValue<'a>,
    pub scaled: bool,
}

impl Columns {
    /// Maximum number of columns. It is far more than any network has, and limits the length of rows for a hostile
    /// capture.
    pub const MOST: usize = 4096;

    /// The columns.
    pub fn iter(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter()
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether no PDO of a known mapping was seen.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// The column of a value, made if it is new; `None` if there are too many.
    pub(super) fn of(&mut self, place: &Place<'_>, number: Number, unit: &str) -> Option<usize> {
        let Place { channel, node, signal, scaled, .. } = *place;
        let (object, repetition) = (signal.multiplexer(), signal.repetition);
        let key = Key { channel, node, object, repetition, scaled, kind: kind(number) };
        let known = self.by_key.get(&key).into_iter().flatten();
        if let Some(column) = known.filter_map(|&at| self.columns.get(at)).find(|column| column.unit == unit) {
            return Some(column.number);
        }
        if self.columns.len() >= Self::MOST {
            self.left_out += 1;
            return None;
        }
        let number = self.columns.len();
        let name = self.free_name(place, unit);
        let label = signal.name().map_or_else(|| signal.multiplexer().to_string(), |name| name.to_string());
        self.columns.push(Column { name, channel, node, label, unit: unit.to_owned(), number });
        self.by_key.entry(key).or_default().push(number);
        Some(number)
    }

    /// A name that no other column has.
    fn free_name(&mut self, place: &Place<'_>, unit: &str) -> String {
        let object = place.signal.multiplexer();
        let is_first = self.columns.first().is_none_or(|first| first.channel == place.channel);
        let channel = if is_first { String::new() } else { format!("{} ", place.channel_name) };
        let of_node = format!("{channel}node {}", place.node);
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        let name = place.signal.name().map(|name| name.to_string());
        let plain = name.as_deref().map_or_else(|| format!("{object}"), ToOwned::to_owned);
        let first = format!("{of_node} {plain}{unit}");
        let second = || format!("{of_node} {plain} {object}{unit}");
        let further = || (2..).map(|n| format!("{of_node} {plain} {object} #{n}{unit}"));
        let mut candidates = std::iter::once(first).chain(std::iter::once_with(second)).chain(further());
        // One of the names is free, because there are more names than columns.
        let free = candidates.find(|name| !self.names.contains(name)).unwrap_or_default();
        self.names.insert(free.clone());
        free
    }
}

const fn kind(number: Number) -> u8 {
    match number {
        Number::Boolean(_) => 0,
        Number::Integer(_) | Number::Unsigned(_) => 1,
        Number::Real32(_) | Number::Real64(_) => 2,
    }
}
