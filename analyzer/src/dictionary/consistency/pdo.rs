//! PDOs: communication parameters and mapping.

use super::Check;
use crate::dictionary::data_type::DataType;
use crate::dictionary::object::{Access, Entry, Object};
use crate::dictionary::rules::{Rule, pdo as rules};
use crate::identity::{Index, Multiplexer, SubIndex};
use crate::object;

/// The first communication parameter and the first mapping parameter of each direction.
const RPDO: (u16, u16) = (object::RPDO_COMMUNICATION_PARAMETER, object::RPDO_MAPPING_PARAMETER);
const TPDO: (u16, u16) = (object::TPDO_COMMUNICATION_PARAMETER, object::TPDO_MAPPING_PARAMETER);

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
    directions(check);
}

/// A mappable entry that can be read and written must state its PDO direction; one entry of each object is reported.
fn directions(check: &mut Check<'_>) {
    for object in check.description.dictionary.objects() {
        let either = object.entries().iter().find(|entry| entry.pdo_mappable && entry.access == Access::Rw);
        if let Some(entry) = either {
            let at = Multiplexer { index: object.index, sub: entry.sub };
            check.report(
                at,
                "AccessType",
                &rules::EITHER,
                "rwr or rww, if only one kind of PDO can carry the entry",
                "rw",
            );
        }
    }
}

/// Sub-index 4 of a TPDO is reserved.
fn reserved_sub_index(check: &mut Check<'_>, object: &Object, is_tpdo: bool) {
    let at = Multiplexer { index: object.index, sub: SubIndex(4) };
    if is_tpdo && object.entry(at.sub).is_some_and(|entry| entry.line != 0) {
        check.report(at, "", &rules::RESERVED_SUB, "no sub-index 4 of a TPDO", "a description of sub-index 4");
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

/// Transmission types 241 to 251 are reserved; 252 and 253 are for TPDOs only.
fn transmission_type(check: &mut Check<'_>, object: &Object, is_tpdo: bool) {
    let at = Multiplexer::new(object.index.0, 2);
    let Some((kind, field)) = check.effective_number(at) else { return };
    let last_reserved = if is_tpdo { 251 } else { 253 };
    if (241..=last_reserved).contains(&kind) {
        let expected = "a transmission type that is not reserved";
        check.report(at, field, &rules::TRANSMISSION_TYPE, expected, &kind.to_string());
    }
}

/// The broken rule of a mapped object, and the expected text.
type Wrong = (&'static Rule, &'static str);

/// A mapping parameter with its direction.
struct Mapping<'a> {
    object: &'a Object,
    is_tpdo: bool,
}

impl Mapping<'_> {
    fn check(&self, check: &mut Check<'_>) {
        let index = self.object.index.0;
        let whole = Multiplexer::new(index, 0);
        // 254 and 255 are multiplex PDOs, with another structure.
        let Some((count @ ..=64, counted)) = check.effective_number(whole) else { return };
        let (mut bits, mut empty) = (0, 0);
        for sub in 1..=count as u8 {
            let at = Multiplexer::new(index, sub);
            match check.effective_number(at) {
                None | Some((0, _)) if self.is_compact() => {}
                Some((0, _)) => empty += 1,
                Some((mapped, field)) => bits += self.entry(check, at, field, mapped as u32),
                None => {
                    let expected = "a mapped object as the value, since sub-index 0 counts it";
                    check.report(at, "DefaultValue", &rules::ENTRY_MISSING, expected, "none");
                }
            }
        }
        if empty > 0 {
            let expected = "mapped objects as the values, since sub-index 0 counts them";
            check.report(whole, counted, &rules::ENTRY_MISSING, expected, &format!("{empty} empty entries"));
        }
        if bits > 64 {
            check.report(whole, counted, &rules::TOO_LONG, "at most 64 bits in a PDO", &format!("{bits} bits"));
        }
    }

    /// Whether `CompactSubObj` describes the mapping: sub-index 0 then counts the existing entries, and `[xxxxValue]`
    /// lists the mapped ones.
    fn is_compact(&self) -> bool {
        self.object.line != 0 && self.object.entry(SubIndex(0)).is_some_and(|count| count.line == 0)
    }

    /// Checks one mapped object and returns its length in bits.
    fn entry(&self, check: &mut Check<'_>, at: Multiplexer, field: &str, mapped: u32) -> u32 {
        let [bits, sub, low, high] = mapped.to_le_bytes();
        let target = Multiplexer::new(u16::from_le_bytes([low, high]), sub);
        let wrong = match check.description.dictionary.entry(target) {
            Ok(entry) => self.wrong_with(entry, bits),
            Err(_) => self.wrong_with_dummy(check, target, bits),
        };
        if let Some((rule, expected)) = wrong {
            let found = format!("{target} with {bits} bits");
            check.report(at, field, rule, expected, &found);
        }
        let granularity = check.description.device.granularity;
        if granularity > 0 && !bits.is_multiple_of(granularity) {
            let expected = "lengths that are multiples of Granularity";
            let found = format!("{bits} bits with granularity {granularity}");
            check.report(at, field, &rules::GRANULARITY, expected, &found);
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

    /// The broken rule of a dummy entry: the index of a data type, which skips bits of an RPDO.
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
