//! COB-IDs: defaults of the predefined connection set, restricted CAN-IDs, repeated CAN-IDs.

use super::Check;
use crate::dictionary::object::Setting;
use crate::dictionary::rules::pdo as rules;
use crate::identity::{CobId, Multiplexer, SubIndex};
use crate::object;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

pub(super) fn check(check: &mut Check<'_>) {
    own(check);
    predefined(check);
    first_server(check);
}

/// The COB-IDs of the predefined connection set, by object.
const PREDEFINED: [(u16, u8, u32); 9] = [
    (object::COB_ID_EMCY, 0, 0x80),
    (object::RPDO_COMMUNICATION_PARAMETER, 1, 0x200),
    (0x1401, 1, 0x300),
    (0x1402, 1, 0x400),
    (0x1403, 1, 0x500),
    (object::TPDO_COMMUNICATION_PARAMETER, 1, 0x180),
    (0x1801, 1, 0x280),
    (0x1802, 1, 0x380),
    (0x1803, 1, 0x480),
];
/// Default COB-IDs of messages of the whole network.
const OF_THE_NETWORK: [(u16, u32); 2] = [(object::COB_ID_SYNC, 0x80), (object::COB_ID_TIME, 0x100)];

/// EMCY, the first four PDOs of each direction, SYNC and TIME should have the COB-IDs of the predefined connection
/// set.
fn predefined(check: &mut Check<'_>) {
    for (index, sub, base) in PREDEFINED {
        let at = Multiplexer::new(index, sub);
        // The CAN-ID of a message that is switched off has no meaning.
        let differs = |cob_id: CobId, node: bool| cob_id.is_valid() && !is_of_node(cob_id, node, base);
        report_other(check, at, differs);
    }
    for (index, base) in OF_THE_NETWORK {
        report_other(check, Multiplexer::new(index, 0), |cob_id, node| node || cob_id.can_id() != base);
    }
}

/// Reports the default COB-ID of `at` if `differs` holds for it. `differs` gets the COB-ID, and whether the node-ID is
/// added.
fn report_other(check: &mut Check<'_>, at: Multiplexer, differs: impl Fn(CobId, bool) -> bool) {
    let Some((cob_id, plus_node_id)) = default(check, at) else { return };
    if differs(cob_id, plus_node_id) {
        let found = shown(cob_id, plus_node_id);
        check.report(at, "DefaultValue", &rules::PREDEFINED, "the predefined connection set", &found);
    }
}

/// The default COB-ID, and whether the node-ID is added; `None` if it is 0, which stands for no default.
fn default(check: &Check<'_>, at: Multiplexer) -> Option<(CobId, bool)> {
    let entry = check.description.dictionary.entry(at).ok()?;
    match entry.default.as_ref()? {
        Setting::NodeIdPlus(offset) => Some((CobId(*offset), true)),
        Setting::Fixed(value) => value.to_raw().filter(|&raw| raw != 0).map(|raw| (CobId(raw as u32), false)),
    }
}

/// Whether the CAN-ID is the base plus the node-ID; a fixed CAN-ID may be the base plus any node-ID.
fn is_of_node(cob_id: CobId, plus_node_id: bool, base: u32) -> bool {
    if plus_node_id { cob_id.can_id() == base } else { (base + 1..=base + 127).contains(&cob_id.can_id()) }
}

fn shown(cob_id: CobId, plus_node_id: bool) -> String {
    let node = if plus_node_id { "$NODEID+" } else { "" };
    format!("{node}{:X}h", cob_id.0)
}

/// The first SDO server must have its fixed COB-IDs.
fn first_server(check: &mut Check<'_>) {
    for (sub, base) in [(1, 0x600), (2, 0x580)] {
        let at = Multiplexer::new(object::SDO_SERVER_PARAMETER, sub);
        let Some((cob_id, plus_node_id)) = default(check, at) else { continue };
        // Many files leave out the node-ID, and all readers add it.
        let is_bare = !plus_node_id && cob_id.0 == base;
        if cob_id.is_extended() || !cob_id.is_valid() || !is_of_node(cob_id, plus_node_id, base) && !is_bare {
            let expected = if sub == 1 { "600h plus the node-ID" } else { "580h plus the node-ID" };
            check.report(at, "DefaultValue", &rules::FIRST_SERVER, expected, &shown(cob_id, plus_node_id));
        }
    }
}

/// A COB-ID that the device uses on the bus.
struct Used {
    at: Multiplexer,
    /// The EDS field that holds the COB-ID: `DefaultValue` or `ParameterValue`.
    field: &'static str,
    /// The COB-ID; the node-ID of a DCF is added if required.
    cob_id: CobId,
    plus_node_id: bool,
    /// Whether the device sends the message, or receives it.
    is_sent: bool,
}

impl Used {
    /// The key that equal COB-IDs share. In an EDS, a fixed COB-ID and a formula with the node-ID have different keys:
    /// they are equal for one node-ID only.
    fn key(&self) -> (u32, bool, bool) {
        (self.cob_id.can_id(), self.cob_id.is_extended(), self.plus_node_id)
    }
}

/// COB-IDs must not be restricted, and no two may be the same.
fn own(check: &mut Check<'_>) {
    let mut all: HashMap<(u32, bool, bool), Used> = HashMap::new();
    for (at, is_sent) in of_device(check) {
        let Some(used) = used(check, at, is_sent) else { continue };
        // The check takes node-ID 1: a CAN-ID restricted for the first node is restricted for most.
        let least = if used.plus_node_id { CobId(used.cob_id.0.wrapping_add(1)) } else { used.cob_id };
        if least.is_restricted() {
            let (expected, found) = ("a CAN-ID that is not restricted", format!("{:X}h", least.can_id()));
            check.report(at, used.field, &rules::RESTRICTED, expected, &found);
        }
        match all.entry(used.key()) {
            Entry::Vacant(vacant) => {
                vacant.insert(used);
            }
            Entry::Occupied(other) => twice(check, &used, other.get()),
        }
    }
}

/// Reports two equal COB-IDs: two senders disturb each other, and a receiver would take messages for another node.
fn twice(check: &mut Check<'_>, used: &Used, other: &Used) {
    let found = format!("{} as in {}", shown(CobId(used.cob_id.can_id()), used.plus_node_id), other.at);
    let rule = if used.is_sent && other.is_sent { &rules::COB_ID_TWICE } else { &rules::COB_ID_SHARED };
    check.report(used.at, used.field, rule, "a CAN-ID of its own", &found);
}

/// The COB-ID at that address as the device uses it; `None` if it is switched off or unknown.
fn used(check: &Check<'_>, at: Multiplexer, is_sent: Option<bool>) -> Option<Used> {
    let (setting, field) = check.effective(at)?;
    let node = check.description.commissioning.as_ref().and_then(|commissioning| commissioning.node_id);
    let (cob_id, plus_node_id) = match (setting, node) {
        (Setting::NodeIdPlus(offset), Some(node)) => (offset.wrapping_add(u32::from(node.raw())), false),
        (Setting::NodeIdPlus(offset), None) => (*offset, true),
        (Setting::Fixed(value), _) => (value.to_raw()? as u32, false),
    };
    let cob_id = CobId(cob_id);
    // In SYNC and TIME, bit 30 tells that the device sends the message; bit 31 does not switch it off.
    let is_sent = is_sent.unwrap_or(!cob_id.allows_rtr());
    let is_of_network = matches!(at.index.0, object::COB_ID_SYNC | object::COB_ID_TIME);
    (is_of_network || cob_id.is_valid()).then_some(Used { at, field, cob_id, plus_node_id, is_sent })
}

/// The objects that hold COB-IDs of SYNC, TIME, EMCY, PDOs and SDO servers, and whether the device sends the message. The
/// first SDO server is left out: its CAN-IDs are restricted, so that no other message can have them.
fn of_device(check: &Check<'_>) -> Vec<(Multiplexer, Option<bool>)> {
    let single = [(object::COB_ID_SYNC, None), (object::COB_ID_TIME, None), (object::COB_ID_EMCY, Some(true))];
    let single = single.map(|(index, is_sent)| (Multiplexer::new(index, 0), is_sent));
    let kinds = [
        (0x1400, 0x15FF, 1, Some(false)),
        (0x1800, 0x19FF, 1, Some(true)),
        (0x1201, 0x127F, 1, Some(false)),
        (0x1201, 0x127F, 2, Some(true)),
    ];
    let several = kinds.into_iter().flat_map(|(first, last, sub, is_sent)| {
        let objects = check.objects(first, last).filter(|object| !object.code.is_single());
        objects.map(move |object| (Multiplexer { index: object.index, sub: SubIndex(sub) }, is_sent))
    });
    single.into_iter().chain(several).collect()
}
