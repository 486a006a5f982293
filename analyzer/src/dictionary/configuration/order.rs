//! The order in which CiA 301 requires that objects are written: a PDO, EMCY or SYNC is switched off, its parameters and
//! mapping follow, and its COB-ID is last (7.5.2.37, 7.5.2.38).
//!
//! A device may refuse writes to a PDO in use; a device that accepts any order accepts this one, too.

use super::Download;
use crate::identity::{CobId, Multiplexer};
use crate::object;

/// A write, with its place in the order.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct Step {
    /// The index of the COB-ID of the object's communication object: objects of one communication object are written
    /// together.
    group: u16,
    order: Order,
    multiplexer: Multiplexer,
    value: Vec<u8>,
}

/// The order within a communication object.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Order {
    /// Switches the communication object off with its current identifier: bits 0 to 29 of a valid COB-ID must not
    /// change (7.5.2.17, 7.5.2.37).
    SwitchOff,
    /// Writes the communication object's own identifier while it is still off: some devices accept an identifier only
    /// this way.
    OwnIdentifier,
    Parameter,
    MappingOff,
    MappingEntry,
    MappingOn,
    CobId,
}

/// The objects of EMCY (COB-ID and inhibit time), of SYNC (COB-ID, period and counter overflow) and of TIME (COB-ID).
const EMCY_ID: u16 = object::COB_ID_EMCY;
const EMCY_INHIBIT: u16 = object::INHIBIT_TIME_EMCY;
const SYNC_ID: u16 = object::COB_ID_SYNC;
const SYNC_PERIOD: u16 = object::COMMUNICATION_CYCLE_PERIOD;
const SYNC_OVERFLOW: u16 = object::SYNCHRONOUS_COUNTER_OVERFLOW;
const TIME_ID: u16 = object::COB_ID_TIME;

/// Bit 30 of 1005h or 1012h is set if the device produces SYNC or TIME.
const PRODUCES: u32 = 1 << 30;
/// Bit 31 of 1012h is set if the device consumes TIME.
const CONSUMES: u32 = 1 << 31;

/// The writes, in order, that give objects these values. `held`: the current COB-IDs of the device.
pub fn ordered<'a>(downloads: impl IntoIterator<Item = &'a Download>, held: &[(Multiplexer, u32)]) -> Vec<Download> {
    let steps = steps(downloads, held).into_iter();
    steps.map(|step| Download { at: step.multiplexer, value: step.value }).collect()
}

/// Whether an object holds a COB-ID that must be switched off before it changes.
pub const fn is_cob_id(at: Multiplexer) -> bool {
    matches!((at.index.0, at.sub.0), (0x1400..=0x15FF | 0x1800..=0x19FF, 1) | (EMCY_ID | TIME_ID | SYNC_ID, 0))
}

/// The COB-ID with its communication object switched off.
const fn switched_off(index: u16, cob_id: u32) -> u32 {
    match index {
        SYNC_ID => cob_id & !PRODUCES,
        TIME_ID => cob_id & !(PRODUCES | CONSUMES),
        _ => cob_id | CobId::INVALID,
    }
}

/// The writes that give objects these values, in their order.
fn steps<'a>(downloads: impl IntoIterator<Item = &'a Download>, held: &[(Multiplexer, u32)]) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for Download { at: multiplexer, value } in downloads {
        let (index, sub) = (multiplexer.index.0, multiplexer.sub.0);
        let step =
            |order: Order, value: Vec<u8>| Step { group: group_of(index), order, multiplexer: *multiplexer, value };
        match (index, sub) {
            _ if is_cob_id(*multiplexer) => {
                let own = switched_off(index, number(value));
                let held = held.iter().find(|(at, _)| at == multiplexer);
                let off = held.map_or(own, |&(_, held)| switched_off(index, held));
                steps.push(step(Order::SwitchOff, off.to_le_bytes().to_vec()));
                if own != off {
                    steps.push(step(Order::OwnIdentifier, own.to_le_bytes().to_vec()));
                }
                steps.push(step(Order::CobId, value.clone()));
            }
            (0x1600..=0x17FF | 0x1A00..=0x1BFF, 0) => {
                steps.push(step(Order::MappingOff, vec![0]));
                steps.push(step(Order::MappingOn, value.clone()));
            }
            (0x1600..=0x17FF | 0x1A00..=0x1BFF, _) => steps.push(step(Order::MappingEntry, value.clone())),
            _ => steps.push(step(Order::Parameter, value.clone())),
        }
    }
    steps.sort();
    steps
}

/// The first bytes of a value as a number.
fn number(value: &[u8]) -> u32 {
    value.iter().take(4).rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

/// The communication object to which an object belongs, given by the index of its COB-ID.
const fn group_of(index: u16) -> u16 {
    match index {
        0x1600..=0x17FF | 0x1A00..=0x1BFF => index - 0x200,
        EMCY_INHIBIT => EMCY_ID,
        SYNC_PERIOD | SYNC_OVERFLOW => SYNC_ID,
        // Every other write clears the date of the configuration (7.5.2.23), so it comes last.
        object::VERIFY_CONFIGURATION => u16::MAX,
        _ => index,
    }
}

/// Objects that must be written together with an object: if the mapping of a PDO changes, the PDO and its mapping are
/// switched off and on again, even if they have not changed themselves. The object itself may be among them.
pub fn companions(multiplexer: Multiplexer) -> [Option<Multiplexer>; 2] {
    let (index, group) = (multiplexer.index.0, group_of(multiplexer.index.0));
    let cob_id = match group {
        0x1400..=0x15FF | 0x1800..=0x19FF => Some(Multiplexer::new(group, 1)),
        EMCY_ID | SYNC_ID => Some(Multiplexer::new(group, 0)),
        _ => None,
    };
    [cob_id, (index != group && cob_id.is_some_and(|at| at.sub.0 == 1)).then(|| Multiplexer::new(index, 0))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pdo_is_off_while_it_is_set_up_and_on_at_the_end() {
        let original = |index, sub, value: &[u8]| Download { at: Multiplexer::new(index, sub), value: value.to_vec() };
        let originals = [
            original(object::TPDO_COMMUNICATION_PARAMETER, 1, &[0xBF, 1, 0, 0x40]),
            original(object::TPDO_MAPPING_PARAMETER, 0, &[1]),
            original(object::TPDO_MAPPING_PARAMETER, 1, &[0x20, 0, 4, 0x60]),
            original(object::TPDO_COMMUNICATION_PARAMETER, 2, &[254]),
            original(object::PRODUCER_HEARTBEAT_TIME, 0, &[0, 0]),
        ];
        let written = |held: &[(Multiplexer, u32)]| -> Vec<String> {
            steps(&originals, held).iter().map(|step| format!("{} {:02X?}", step.multiplexer, step.value)).collect()
        };
        assert_eq!(
            written(&[]),
            [
                "1017h:00 [00, 00]",
                "1800h:01 [BF, 01, 00, C0]",
                "1800h:02 [FE]",
                "1A00h:00 [00]",
                "1A00h:01 [20, 00, 04, 60]",
                "1A00h:00 [01]",
                "1800h:01 [BF, 01, 00, 40]",
            ]
        );
        // The COB-ID is valid with another identifier, which stays until the COB-ID is off.
        let cob_id = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 1);
        let moved = written(&[(cob_id, 0x4000_06B0)]);
        assert_eq!(moved[1..3], ["1800h:01 [B0, 06, 00, C0]", "1800h:01 [BF, 01, 00, C0]"]);
        assert_eq!(moved[3..], written(&[])[2..]);
    }

    #[test]
    fn sync_and_time_are_off_without_their_bits() {
        let off = |index, cob_id| format!("{:08X}", switched_off(index, cob_id));
        assert_eq!(off(SYNC_ID, 0x4000_0080), "00000080");
        assert_eq!(off(TIME_ID, 0xC000_0100), "00000100");
        assert_eq!(off(EMCY_ID, 0x85), "80000085");
    }
}
