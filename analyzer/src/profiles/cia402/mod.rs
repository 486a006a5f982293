//! CiA 402: drives. A device has up to eight axes: the objects of each further axis are 800h higher.

mod bits;
mod error_codes;
mod findings;
mod names;
pub mod objects;
pub mod state;
mod units;

use crate::dictionary::Unit;
use crate::dictionary::names::{Meaning, Profile, Registered, StandardObject, find_error};
use crate::identity::{Index, Multiplexer};
use crate::object::Acting;
use crate::wire::emcy::EmcyCode;
use state::{Command, State};

/// The number of the profile, as in the low word of 1000h.
pub const NUMBER: u16 = 402;

/// The first object of the first axis, and the number of indexes of each axis.
const FIRST: u16 = 0x6000;
const OF_AXIS: u16 = 0x800;

/// Maximum number of axes of a device.
pub const AXES: usize = 8;

/// The profile.
struct Cia402;

inventory::submit! { Registered(&Cia402) }

impl Profile for Cia402 {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn standard(&self) -> &'static str {
        names::STANDARD
    }

    fn objects(&self) -> &'static [StandardObject] {
        names::OBJECTS
    }

    fn logical_devices(&self) -> u16 {
        AXES as u16
    }

    fn logical_device(&self) -> &'static str {
        "axis"
    }

    fn bits(&self, index: Index) -> &'static [&'static str] {
        bits::of(index)
    }

    fn unit(&self, at: Multiplexer) -> Option<Unit> {
        units::of(at)
    }

    fn meaning(&self, at: Multiplexer, value: i64) -> Option<Meaning> {
        let word = u16::try_from(value).ok();
        let name = match at.index.0 {
            objects::STATUSWORD => State::of(word?).map(State::name),
            objects::CONTROLWORD => Some(Command::of(word?).name()),
            objects::MODE | objects::MODE_DISPLAY => state::mode(i8::try_from(value).ok()?),
            objects::ERROR_CODE => {
                let code = EmcyCode(word?);
                self.emergency(code).or_else(|| code.name())
            }
            _ => None,
        };
        name.map(Meaning::Name)
    }

    fn emergency(&self, code: EmcyCode) -> Option<&'static str> {
        find_error(error_codes::CODES, code)
    }

    /// The controlword and the set-points move a drive.
    fn acting(&self, at: Multiplexer) -> Option<Acting> {
        let index = at.index.0.checked_sub(FIRST).filter(|offset| *offset < AXES as u16 * OF_AXIS)? % OF_AXIS + FIRST;
        let moves = matches!(
            index,
            objects::CONTROLWORD
                | objects::VL_TARGET_VELOCITY
                | objects::TARGET_TORQUE
                | objects::TARGET_POSITION
                | objects::POSITION_OFFSET
                ..=objects::TORQUE_OFFSET
                    | objects::INTERPOLATION_DATA
                    | objects::DIGITAL_OUTPUTS
                    | objects::TARGET_VELOCITY
        );
        moves.then_some(Acting::Commands)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dictionary::names::{bit_name, object_name, unit};

    #[test]
    fn error_codes_are_sorted() {
        assert!(error_codes::CODES.is_sorted_by(|a, b| a.0 < b.0));
    }

    #[test]
    fn each_axis_has_the_objects() {
        let name = |index, profile| object_name(Multiplexer::new(index, 0), Some(profile)).map(|name| name.to_string());
        assert_eq!(name(0x6041, NUMBER).as_deref(), Some("Statusword"));
        assert_eq!(name(0x6841, NUMBER).as_deref(), Some("Statusword (axis 2)"));
        assert_eq!(name(0x9841, NUMBER).as_deref(), Some("Statusword (axis 8)"));
        assert_eq!((name(0xA041, NUMBER), name(0x6841, 406)), (None, None));
        assert_eq!(bit_name(Index(0x7041), 10, Some(NUMBER)), Some("target reached"));
        assert_eq!(bit_name(Index(0x6041), 0, Some(NUMBER)), None);
        assert!(unit(Multiplexer::new(0x6877, 0), Some(NUMBER)).is_some());
    }

    #[test]
    fn values_have_meanings() {
        let of = |index, value| match Cia402.meaning(Multiplexer::new(index, 0), value) {
            Some(Meaning::Name(name)) => Some(name),
            _ => None,
        };
        assert_eq!(of(objects::STATUSWORD, 0x0237), Some("operation enabled"));
        assert_eq!(of(objects::MODE_DISPLAY, 8), Some("cyclic synchronous position"));
        assert_eq!(of(objects::MODE, -3), None);
        assert_eq!(of(objects::ERROR_CODE, 0x7121), Some("motor blocked"));
        assert_eq!(of(objects::ERROR_CODE, 0x8130), Some("life guard error or heartbeat error"));
    }
}
