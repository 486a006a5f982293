//! The shown properties of an entry, each on one line and safe to show.

use super::{Shown, at};
use crate::escape::printable;
use canvass_analyzer::dictionary::difference::Fact;
use canvass_analyzer::dictionary::layout::{PdoField, PdoLayout};
use canvass_analyzer::dictionary::names::{is_cob_id, meaning};
use canvass_analyzer::dictionary::{Entry, Object, Setting};
use canvass_analyzer::wire::pdo::{MappingEntry, TransmissionType};
use canvass_analyzer::{CobId, Multiplexer};

/// The texts of one entry.
pub(super) struct Cells {
    pub name: String,
    pub data_type: String,
    pub access: &'static str,
    /// The kinds of PDOs into which the entry can be mapped.
    pub mapping: &'static str,
    pub default: String,
    pub limits: String,
    /// The value that a DCF or XDC sets.
    pub configured: String,
}

impl Cells {
    pub fn of(shown: &Shown, object: &Object, entry: &Entry) -> Self {
        let at = at(object, entry.sub);
        let text = |of: &Option<Setting>| of.as_ref().map(|of| setting(shown, at, entry, of)).unwrap_or_default();
        let value = |of: &Option<Setting>| of.as_ref().map(|of| with_meaning(shown, at, entry, of)).unwrap_or_default();
        Self {
            name: printable(&entry.name).into_owned(),
            data_type: entry.data_type.to_string(),
            access: entry.access.name(),
            mapping: mapping(entry),
            default: value(&entry.default),
            limits: limits(&text(&entry.low_limit), &text(&entry.high_limit)),
            configured: value(&entry.configured),
        }
    }
}

fn mapping(entry: &Entry) -> &'static str {
    match (entry.pdo_mappable, entry.access.allows_rpdo(), entry.access.allows_tpdo()) {
        (true, true, true) => "RPDO, TPDO",
        (true, true, false) => "RPDO",
        (true, false, true) => "TPDO",
        _ => "",
    }
}

fn limits(low: &str, high: &str) -> String {
    match (low, high) {
        ("", "") => String::new(),
        (low, "") => format!("at least {low}"),
        ("", high) => format!("at most {high}"),
        (low, high) => format!("{low} to {high}"),
    }
}

fn setting(shown: &Shown, at: Multiplexer, entry: &Entry, setting: &Setting) -> String {
    let setting = match shown.node {
        Some(node) => Setting::Fixed(setting.resolve(entry.data_type, node)),
        None => setting.clone(),
    };
    let fact = match mapped(at, &setting) {
        Some(mapped) => Fact::Mapping(vec![mapped]),
        None if is_cob_id(at) => Fact::CobId(setting),
        None => Fact::Setting(setting),
    };
    printable(&fact.to_string()).into_owned()
}

/// A value with its meaning in the standard or the profile. COB-IDs and mapping entries show their parts already.
fn with_meaning(shown: &Shown, at: Multiplexer, entry: &Entry, of: &Setting) -> String {
    let text = setting(shown, at, entry, of);
    let is_in_parts = is_cob_id(at) || canvass_analyzer::object::is_pdo_mapping(at.index.0);
    let raw = of.fixed().filter(|_| !is_in_parts).and_then(|value| i64::try_from(value.to_raw()?).ok());
    match raw.and_then(|raw| meaning(at, raw, shown.description.device_profile())) {
        Some(meaning) => format!("{text} ({meaning})"),
        None => text,
    }
}

/// The object that a mapping entry names.
fn mapped(at: Multiplexer, setting: &Setting) -> Option<MappingEntry> {
    let is_mapping = canvass_analyzer::object::is_pdo_mapping(at.index.0) && at.sub.0 > 0;
    let raw = setting.fixed()?.to_raw().filter(|&raw| is_mapping && raw > 0)?;
    u32::try_from(raw).ok().map(MappingEntry)
}

/// The name in the standard: `CiA 301 7.5.2.21: Identity object, Vendor-ID`. Empty if no standard defines the entry.
pub(super) fn standard(shown: &Shown, at: Multiplexer) -> String {
    let name = shown.standard(at);
    name.map_or_else(String::new, |name| format!("{}: {name}", name.object.clause().brief()))
}

/// The properties of a PDO: `32 bits, CAN-ID $NODEID+180h, no remote frames`.
pub(super) fn about(shown: &Shown, layout: &PdoLayout<'_>) -> String {
    let content = match &layout.fields {
        None => "mapping not described".to_owned(),
        Some(_) => format!("{} bits", layout.bits()),
    };
    let Some(cob_id) = layout.cob_id else { return format!("{content}, COB-ID not described") };
    let (node, raw) = match (cob_id, shown.node) {
        (Setting::NodeIdPlus(offset), Some(node)) => ("", offset.wrapping_add(u32::from(node.raw()))),
        (Setting::NodeIdPlus(offset), None) => ("$NODEID+", *offset),
        (Setting::Fixed(value), _) => ("", value.to_raw().unwrap_or(0) as u32),
    };
    let cob_id = CobId(raw);
    let off = if cob_id.is_valid() { "" } else { ", switched off" };
    let rtr = if cob_id.allows_rtr() { "" } else { ", no remote frames" };
    format!("{content}, CAN-ID {node}{:X}h{off}{rtr}", cob_id.can_id())
}

/// The transmission type: `transmission type 254 (on events of the manufacturer)`. Empty if it is not described.
pub(super) fn transmission_type(layout: &PdoLayout<'_>) -> String {
    layout.transmission_type.map_or_else(String::new, |number| {
        format!("transmission type {number} ({})", transmission(TransmissionType(number)))
    })
}

fn transmission(kind: TransmissionType) -> &'static str {
    match kind {
        TransmissionType::SYNCHRONOUS_ACYCLIC => "at SYNC, after an event",
        TransmissionType::RTR_SYNCHRONOUS => "sampled at SYNC, on remote frames",
        TransmissionType::RTR_EVENT_DRIVEN => "on remote frames",
        TransmissionType::EVENT_MANUFACTURER => "on events of the manufacturer",
        TransmissionType::EVENT_PROFILE => "on events of the device profile",
        _ if kind.cycle().is_some() => "at SYNC",
        _ => "reserved",
    }
}

/// A field of a PDO: `6004h:00 Position value, UNSIGNED32`.
pub(super) fn field(field: &PdoField<'_>) -> String {
    let object = field.mapped.object();
    let text = match field.entry {
        Some(entry) => format!("{object} {}, {}", entry.name, entry.data_type),
        None if field.mapped.is_dummy() => "not used".to_owned(),
        None => format!("{object}, not described"),
    };
    printable(&text).into_owned()
}

/// The place of a field: `bit 3`, `bits 0 to 31`.
pub(super) fn bits(field: &PdoField<'_>) -> String {
    match field.mapped.bits() {
        0 => "no bits".to_owned(),
        1 => format!("bit {}", field.offset),
        _ => format!("bits {} to {}", field.offset, field.end() - 1),
    }
}
