//! PDOs: communication parameters, mapping, COB-IDs.

use std::collections::HashMap;

use super::Check;
use crate::dictionary::data_type::DataType;
use crate::dictionary::object::{Entry, Object, ObjectCode, Setting};
use crate::dictionary::rules::{Rule, pdo as rules};
use crate::identity::{CobId, Index, Multiplexer, NodeId, SubIndex};
use crate::object;

/// The two directions: first communication parameter, first mapping parameter.
const RPDO: (u16, u16) = (0x1400, 0x1600);
const TPDO: (u16, u16) = (0x1800, 0x1A00);

pub(super) fn check(check: &mut Check<'_>) {
    for (communication, mapping) in [RPDO, TPDO] {
        for (one, other) in [(communication, mapping), (mapping, communication)] {
            for object in check.objects(one, one + 0x1FF) {
                pair(check, object, other + (object.index.0 - one));
            }
        }
        for object in check.objects(communication, communication + 0x1FF) {
            transmission_type(check, object, communication == TPDO.0);
            reserved_sub_index(check, object, communication == TPDO.0);
        }
        for object in check.objects(mapping, mapping + 0x1FF) {
            Mapping { object, is_tpdo: mapping == TPDO.1 }.check(check);
        }
    }
    cob_ids(check);
    predefined(check);
}

/// Sub-index 4 of a TPDO is reserved.
fn reserved_sub_index(check: &mut Check<'_>, object: &Object, is_tpdo: bool) {
    let at = Multiplexer { index: object.index, sub: SubIndex(4) };
    if is_tpdo && object.entry(at.sub).is_some_and(|entry| entry.line != 0) {
        check.report(at, "", &rules::RESERVED_SUB, "no sub-index 4 of a TPDO", "a description of it");
    }
}

/// EMCY and the first four PDOs of each direction have the COB-IDs of the predefined connection set.
fn predefined(check: &mut Check<'_>) {
    let emcy = std::iter::once((Multiplexer::new(object::COB_ID_EMCY, 0), 0x80));
    let pdos = (0..4u16).flat_map(|number| {
        let at = |first: u16| Multiplexer::new(first + number, 1);
        [(at(RPDO.0), 0x200 + 0x100 * u32::from(number)), (at(TPDO.0), 0x180 + 0x100 * u32::from(number))]
    });
    for (at, base) in emcy.chain(pdos) {
        let Ok(entry) = check.description.dictionary.entry(at) else { continue };
        let differs = match &entry.default {
            // What is switched off has no CAN-ID of meaning.
            Some(Setting::NodeIdPlus(offset)) => CobId(*offset).is_valid() && CobId(*offset).can_id() != base,
            Some(Setting::Fixed(value)) => value.to_raw().is_some_and(|raw| {
                let cob_id = CobId(raw as u32);
                raw != 0 && cob_id.is_valid() && !(base + 1..=base + 127).contains(&cob_id.can_id())
            }),
            None => false,
        };
        if differs {
            let found = entry.default.as_ref().map(ToString::to_string).unwrap_or_default();
            check.report(at, "DefaultValue", &rules::PREDEFINED, "the predefined connection set", &found);
        }
    }
}

/// Communication and mapping parameters come in pairs.
fn pair(check: &mut Check<'_>, object: &Object, other: u16) {
    if check.object(Index(other)).is_none() {
        let at = Multiplexer { index: object.index, sub: SubIndex(0) };
        let expected = "communication and mapping parameters of each PDO";
        check.report(at, "", &rules::PAIR, expected, &format!("no {other:04X}h"));
    }
}

/// 241 to 251 are reserved; 252 and 253 are for TPDOs only.
fn transmission_type(check: &mut Check<'_>, object: &Object, is_tpdo: bool) {
    let Some(default) = check.default(object.index.0, 2) else { return };
    let last_reserved = if is_tpdo { 251 } else { 253 };
    if (241..=last_reserved).contains(&default) {
        let at = Multiplexer::new(object.index.0, 2);
        let expected = "a transmission type that is not reserved";
        check.report(at, "DefaultValue", &rules::TRANSMISSION_TYPE, expected, &default.to_string());
    }
}

/// The rule that a mapped object breaks, and what is expected.
type Wrong = (&'static Rule, &'static str);

/// A mapping parameter with its direction.
struct Mapping<'a> {
    object: &'a Object,
    is_tpdo: bool,
}

impl Mapping<'_> {
    fn check(&self, check: &mut Check<'_>) {
        let index = self.object.index.0;
        // 254 and 255 are multiplex PDOs, with another structure.
        let Some(count @ ..=64) = check.default(index, 0) else { return };
        let mut bits = 0;
        for sub in 1..=count as u8 {
            let at = Multiplexer::new(index, sub);
            match check.default(index, sub) {
                None | Some(0) if self.is_compact() => {}
                Some(mapped) => bits += self.entry(check, at, mapped as u32),
                None => {
                    let expected = "a mapped object as DefaultValue, since sub-index 0 counts it";
                    check.report(at, "DefaultValue", &rules::ENTRY_MISSING, expected, "none");
                }
            }
        }
        if bits > 64 {
            let at = Multiplexer::new(index, 0);
            let expected = "at most 64 bits in a PDO";
            check.report(at, "DefaultValue", &rules::TOO_LONG, expected, &format!("{bits} bits"));
        }
    }

    /// Whether it is described by `CompactSubObj`: its sub-index 0 then counts the entries that there are, and
    /// `[xxxxValue]` names those that are mapped.
    fn is_compact(&self) -> bool {
        self.object.line != 0 && self.object.entry(SubIndex(0)).is_some_and(|count| count.line == 0)
    }

    /// Checks one mapped object and returns its length in bits.
    fn entry(&self, check: &mut Check<'_>, at: Multiplexer, mapped: u32) -> u32 {
        let [bits, sub, low, high] = mapped.to_le_bytes();
        let target = Multiplexer::new(u16::from_le_bytes([low, high]), sub);
        let wrong = match check.description.dictionary.entry(target) {
            Ok(entry) => self.wrong_with(entry, bits),
            Err(_) => self.wrong_with_dummy(check, target, bits),
        };
        if let Some((rule, expected)) = wrong {
            let found = format!("{target} with {bits} bits");
            check.report(at, "DefaultValue", rule, expected, &found);
        }
        let granularity = check.description.device.granularity;
        if granularity > 0 && !bits.is_multiple_of(granularity) {
            let expected = "lengths that are multiples of Granularity";
            let found = format!("{bits} bits with granularity {granularity}");
            check.report(at, "DefaultValue", &rules::GRANULARITY, expected, &found);
        }
        bits.into()
    }

    fn wrong_with(&self, entry: &Entry, bits: u8) -> Option<Wrong> {
        let fits = if self.is_tpdo { entry.access.allows_tpdo() } else { entry.access.allows_rpdo() };
        if !entry.pdo_mappable {
            Some((&rules::NOT_MAPPABLE, "a mapped object with PDOMapping=1"))
        } else if !fits {
            Some((&rules::DIRECTION, "a mapped object whose access type fits the direction of the PDO"))
        } else if entry.data_type == DataType::BOOLEAN && bits == 8 {
            Some((&rules::BOOLEAN, "the length of a BOOLEAN, 1 bit"))
        } else if entry.data_type.bits().is_some_and(|length| length != u32::from(bits)) {
            Some((&rules::LENGTH, "the length of the mapped object's data type"))
        } else {
            None
        }
    }

    /// Indexes of data types skip bits of an RPDO.
    fn wrong_with_dummy(&self, check: &Check<'_>, target: Multiplexer, bits: u8) -> Option<Wrong> {
        if target.index.0 > 0x1F {
            return Some((&rules::TARGET, "a mapped object that exists"));
        }
        if self.is_tpdo {
            return Some((&rules::DUMMY, "dummy entries in RPDOs only"));
        }
        if check.description.dummy_usage.get(&target.index.0) != Some(&true) {
            return Some((&rules::DUMMY, "a dummy entry that DummyUsage allows"));
        }
        let length = DataType(target.index.0).bits();
        (length != Some(bits.into())).then_some((&rules::DUMMY, "the length of the dummy entry's data type"))
    }
}

/// Default COB-IDs are not restricted, and no two are the same at any node-ID.
fn cob_ids(check: &mut Check<'_>) {
    let single =
        [object::COB_ID_SYNC, object::COB_ID_TIME, object::COB_ID_EMCY].map(|index| Multiplexer::new(index, 0));
    let pdos = [RPDO.0, TPDO.0].into_iter().flat_map(|first| check.objects(first, first + 0x1FF));
    let pdos = pdos.filter(|object| object.code == ObjectCode::RECORD);
    let all: Vec<Multiplexer> =
        single.into_iter().chain(pdos.map(|object| Multiplexer::new(object.index.0, 1))).collect();
    let mut used: HashMap<u32, Multiplexer> = HashMap::new();
    for at in all {
        let Ok(entry) = check.description.dictionary.entry(at) else { continue };
        let value = entry.default.as_ref().map(|default| default.resolve(entry.data_type, NodeId::MIN));
        let Some(value) = value.and_then(|value| value.to_raw()) else { continue };
        // Bit 31 of 1005h and 1012h says that the device consumes, not that the COB-ID is invalid.
        let cob_id = CobId(value as u32);
        if !cob_id.is_valid() && !matches!(at.index.0, object::COB_ID_SYNC | object::COB_ID_TIME) {
            continue;
        }
        let found = format!("{:X}h", cob_id.can_id());
        if cob_id.is_restricted() {
            let expected = "a CAN-ID that is not restricted";
            check.report(at, "DefaultValue", &rules::RESTRICTED, expected, &found);
        }
        if let Some(other) = used.insert(cob_id.can_id(), at) {
            let found = format!("{found} as in {other}");
            check.report(at, "DefaultValue", &rules::COB_ID_TWICE, "a CAN-ID of its own", &found);
        }
    }
}
