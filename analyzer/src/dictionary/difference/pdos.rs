//! Differences of PDOs, as delivered or as a DCF configures them: mapping, CAN-ID, transmission.

use super::kind::kinds;
use super::{Comparison, Fact, Subject};
use crate::PdoNumber;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::object::Setting;
use crate::identity::{CobId, Index, Multiplexer, NodeId, SubIndex};
use crate::wire::pdo::MappingEntry;
use std::collections::BTreeSet;

kinds! {
    /// the PDO carries other values
    ///
    /// Programs that read or write values at the old places get other values: the layout is not transmitted.
    LAYOUT: Breaking "pdo/layout";

    /// the PDO has another CAN-ID
    ///
    /// Nodes that are configured for the old one receive nothing, and the new one may be in use.
    COB_ID: Breaking "pdo/cob-id";

    /// the PDO is switched off
    ///
    /// Bit 31 of its COB-ID is set: the consumer of a TPDO receives nothing, and the device ignores the producer of
    /// an RPDO.
    SWITCHED_OFF: Breaking "pdo/switched-off";

    /// the PDO is switched on
    ///
    /// Bit 31 of its COB-ID was set: the bus has more traffic, on a CAN-ID that may be in use.
    SWITCHED_ON: Notable "pdo/switched-on";

    /// whether the PDO answers remote frames has changed
    ///
    /// Bit 30 of its COB-ID has changed. If it is set now, a master that polls the PDO gets no answer.
    REMOTE: Notable "pdo/remote-frames";

    /// the time at which the PDO is sent, or takes effect, has changed
    ///
    /// Its values come more or less often, or no longer with SYNC: a consumer may run into its time-out, the bus may
    /// get full.
    TRANSMISSION: Notable "pdo/transmission";
}

/// Compares the PDOs of both descriptions. A removed PDO is reported as removed objects.
pub(super) fn compare(comparison: &mut Comparison<'_>) {
    let objects = comparison.old.dictionary.objects().iter();
    let of = |index| PdoNumber::of_mapping_index(index).or(PdoNumber::of_communication_index(index));
    let pdos: BTreeSet<PdoNumber> = objects.filter_map(|object| of(object.index.0)).collect();
    for pdo in pdos {
        layout(comparison, pdo);
        cob_id(comparison, pdo);
        transmission(comparison, pdo);
    }
}

fn layout(comparison: &mut Comparison<'_>, pdo: PdoNumber) {
    let (old, new) = (mapping(comparison.old, pdo), mapping(comparison.new, pdo));
    if let (Some(old), Some(new)) = (old, new)
        && old != new
    {
        comparison.told.extend((0..=64).map(|sub| Multiplexer::new(pdo.mapping_index(), sub)));
        comparison.report(&LAYOUT, Subject::Pdo(pdo), Some(Fact::Mapping(old)), Some(Fact::Mapping(new)));
    }
}

/// The mapping of a PDO after a start with nothing stored; `None` if the description does not give it.
pub(in crate::dictionary) fn mapping(description: &DeviceDescription, pdo: PdoNumber) -> Option<Vec<MappingEntry>> {
    let object = description.dictionary.object(Index(pdo.mapping_index()))?;
    // Mappings contain no formula, so the node-ID does not matter.
    let number = |sub| u32::try_from(object.entry(SubIndex(sub))?.start_value(NodeId::MIN)?.to_raw()?).ok();
    // 254 and 255 stand for multiplexed PDOs, which have no layout.
    let count = u8::try_from(number(0)?).ok().filter(|&count| count <= 64)?;
    (1..=count).map(|sub| number(sub).map(MappingEntry)).collect()
}

fn cob_id(comparison: &mut Comparison<'_>, pdo: PdoNumber) {
    let at = Multiplexer::new(pdo.communication_index(), 1);
    let (Some(old), Some(new)) = (start(comparison.old, at), start(comparison.new, at)) else { return };
    if old == new {
        return;
    }
    let is_on = |setting: &Setting| CobId(parts(setting).0).is_valid();
    let without_remote = |setting: &Setting| (parts(setting).0 & !CobId::NO_RTR, parts(setting).1);
    let kind = match (is_on(&old), is_on(&new)) {
        (true, true) if without_remote(&old) == without_remote(&new) => &REMOTE,
        (true, true) => &COB_ID,
        (true, false) => &SWITCHED_OFF,
        (false, true) => &SWITCHED_ON,
        // The CAN-ID of a switched-off PDO has no effect.
        (false, false) => return,
    };
    comparison.told.insert(at);
    comparison.report(kind, Subject::Pdo(pdo), Some(Fact::CobId(old)), Some(Fact::CobId(new)));
}

/// The COB-ID or its offset, and whether the node-ID is added.
fn parts(setting: &Setting) -> (u32, bool) {
    match setting {
        Setting::NodeIdPlus(offset) => (*offset, true),
        Setting::Fixed(value) => (value.to_raw().unwrap_or(0) as u32, false),
    }
}

/// Compares transmission type, inhibit time, event timer and SYNC start value.
fn transmission(comparison: &mut Comparison<'_>, pdo: PdoNumber) {
    for sub in [2, 3, 5, 6] {
        let at = Multiplexer::new(pdo.communication_index(), sub);
        let (Some(old), Some(new)) = (start(comparison.old, at), start(comparison.new, at)) else { continue };
        if old != new {
            comparison.told.insert(at);
            let setting = |setting| Some(Fact::Setting(setting));
            comparison.report(&TRANSMISSION, Subject::Entry(at), setting(old), setting(new));
        }
    }
}

/// The value after a start with nothing stored.
fn start(description: &DeviceDescription, at: Multiplexer) -> Option<Setting> {
    let entry = description.dictionary.entry(at).ok()?;
    entry.configured.clone().or(entry.default.clone())
}
