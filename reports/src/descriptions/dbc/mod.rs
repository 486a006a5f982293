//! The PDOs of a node as a CAN database (DBC) for CAN tools without CANopen.
//!
//! Frames decoded with the database have the same values as in [`crate::signals`].

mod names;
mod text;

use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice, Setting, Unit};
use canvass_analyzer::network::{Node, Signal as Mapped};
use canvass_analyzer::{CobId, Multiplexer, NodeId, Number, PdoNumber, SignalValue};
use names::Names;
use std::borrow::Cow;
use std::sync::Arc;

/// A CAN database, and the parts of the description that it leaves out.
#[derive(Clone, Debug)]
pub struct Database {
    /// The bytes of the file. The character set is Windows-1252, as tools expect.
    pub bytes: Vec<u8>,
    /// The PDOs that are left out, each with the reason.
    pub left_out: Vec<String>,
    /// Number of PDOs in the database.
    pub messages: usize,
}

/// A PDO in the database.
struct Message {
    pdo: PdoNumber,
    name: String,
    cob_id: CobId,
    /// The length of the PDO in bytes.
    length: usize,
    comment: String,
    signals: Vec<Signal>,
}

/// A value within a PDO.
struct Signal {
    name: String,
    /// The number of the first bit, counted as in CANopen: the lowest bit of the first byte is 0.
    offset: usize,
    bits: u8,
    kind: Number,
    unit: Option<Unit>,
    /// The lowest and the highest physical value, if the description has them.
    limits: Option<(f64, f64)>,
    comment: String,
}

/// Maximum length of a PDO of classical CAN in bytes.
const LONGEST: usize = 8;

/// The PDOs of a device with this node-ID after a start with nothing stored.
pub fn database(device: KnownDevice, id: NodeId) -> Database {
    let node_name = names::of_node(&device.description, id);
    let device = Arc::new(device);
    let mut node = Node::default();
    node.describe(Arc::clone(&device));
    let mut left_out = Vec::new();
    let mut messages: Vec<Message> = Vec::new();
    let objects = device.description.dictionary.objects().iter();
    for pdo in objects.filter_map(|object| PdoNumber::of_communication_index(object.index.0)) {
        match message(&device.description, &mut node, id, pdo, &node_name) {
            Ok(message) => messages.push(message),
            Err(reason) => left_out.push(format!("{pdo}: {reason}")),
        }
    }
    let mut kept: Vec<Message> = Vec::new();
    for message in messages {
        match kept.iter().find(|other| other.cob_id.can_id() == message.cob_id.can_id()) {
            Some(other) => left_out.push(format!("{}: {} has the same CAN-ID", message.pdo, other.pdo)),
            None => kept.push(message),
        }
    }
    Database { bytes: text::render(&node_name, &kept), left_out, messages: kept.len() }
}

fn message(
    description: &DeviceDescription,
    node: &mut Node,
    id: NodeId,
    pdo: PdoNumber,
    node_name: &str,
) -> Result<Message, String> {
    let of = |node: &Node, sub| node.parameter(id, Multiplexer::new(pdo.communication_index(), sub));
    let cob_id = CobId(of(node, 1).ok_or("its COB-ID is not described")?);
    if !cob_id.is_valid() {
        return Err("it is switched off".to_owned());
    }
    let length = node.layout(id, pdo).map(canvass_analyzer::network::Layout::length);
    let length = length.ok_or("nothing is mapped, or the mapping is not described")?;
    if length > LONGEST {
        return Err(format!("{length} bytes are mapped, and a CAN frame has {LONGEST}"));
    }
    let comment = comment(pdo, &|sub| of(node, sub));
    let mut names = Names::default();
    let signals = node.signals(id, pdo).filter(|(mapped, _)| mapped.bits > 0);
    let signals = signals.map(|(mapped, value)| signal(description, mapped, &value, &mut names)).collect();
    let direction = match pdo {
        PdoNumber::Transmit(_) => "TPDO",
        PdoNumber::Receive(_) => "RPDO",
    };
    let name = names::identifier(&format!("{node_name}_{direction}{}", pdo.number()));
    Ok(Message { pdo, name, cob_id, length, comment, signals })
}

/// The comment of a PDO: `TPDO 1 (1800h, 1A00h), transmission type 255, event timer 100 ms`.
fn comment(pdo: PdoNumber, parameter: &dyn Fn(u8) -> Option<u32>) -> String {
    let mut comment = format!("{pdo} ({:04X}h, {:04X}h)", pdo.communication_index(), pdo.mapping_index());
    if let Some(kind) = parameter(2) {
        comment.push_str(&format!(", transmission type {kind}"));
    }
    if let Some(time) = parameter(5).filter(|&time| time > 0) {
        comment.push_str(&format!(", event timer {time} ms"));
    }
    comment
}

fn signal(description: &DeviceDescription, mapped: &Mapped, value: &SignalValue<'_>, names: &mut Names) -> Signal {
    let plain = value.name().map(|name| name.to_string()).unwrap_or_default();
    let named = match plain.split_once(", ") {
        // Names are short here, so the name of the object is not repeated in the name of its entry.
        Some((object, entry)) if entry.starts_with(object) => entry.to_owned(),
        _ if plain.is_empty() => format!("Object_{:04X}_{:02X}", mapped.object.index.0, mapped.object.sub.0),
        _ => plain.clone(),
    };
    // A signal has only one unit. The unit that the device's configuration determines is preferred, because it says
    // more than the unit "steps".
    let unit = value.scaled().map(|(_, unit)| unit.clone()).or_else(|| value.value()?.1.map(Cow::into_owned));
    Signal {
        name: names.free(&named),
        offset: mapped.offset,
        bits: mapped.bits,
        kind: value.raw.unwrap_or(Number::Unsigned(0)),
        limits: limits(description, mapped.object, unit.as_ref()),
        unit,
        comment: format!("{} {plain}", mapped.object).trim_end().to_owned(),
    }
}

/// Both limits of the description as physical values.
fn limits(description: &DeviceDescription, object: Multiplexer, unit: Option<&Unit>) -> Option<(f64, f64)> {
    let entry = description.dictionary.entry(object).ok()?;
    let number = |setting: &Option<Setting>| setting.as_ref().and_then(Setting::fixed)?.as_number();
    let (low, high) = (number(&entry.low_limit)? as f64, number(&entry.high_limit)? as f64);
    let physical = |raw: f64| unit.map_or(raw, |unit| unit.physical(raw));
    (low < high).then(|| (physical(low), physical(high)))
}

#[cfg(test)]
mod tests;
