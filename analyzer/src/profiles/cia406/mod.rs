//! CiA 406: encoders.

mod bits;
mod description;
mod description_rules;
mod findings;
mod kind;
pub mod makers;
mod names;
pub mod objects;
mod scaling;
mod units;

use crate::dictionary::Unit;
use crate::dictionary::names::{Configured, Meaning, Profile, Registered, Role, StandardObject};
use crate::identity::{Index, Multiplexer};
use crate::object::Acting;

/// The number of the profile, as in the low word of 1000h.
pub const NUMBER: u16 = 406;

/// The profile.
struct Cia406;

inventory::submit! { Registered(&Cia406) }

impl Profile for Cia406 {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn standard(&self) -> &'static str {
        names::STANDARD
    }

    fn objects(&self) -> &'static [StandardObject] {
        names::OBJECTS
    }

    fn bits(&self, index: Index) -> &'static [&'static str] {
        bits::of(index)
    }

    fn same_bits(&self, index: Index) -> Option<Index> {
        bits::same(index)
    }

    fn meaning(&self, at: Multiplexer, value: i64) -> Option<Meaning> {
        let value = u32::try_from(value).ok()?;
        match (at.index.0, at.sub.0, value) {
            (objects::PROFILE_AND_SOFTWARE_VERSION, 0, _) => {
                Some(Meaning::Versions(value as u16, (value >> 16) as u16))
            }
            (objects::OPERATING_TIME | objects::SERIAL_NUMBER, 0, UNUSED) => Some(Meaning::Name("not used")),
            _ => None,
        }
    }

    fn device_kind(&self, high_word: u16) -> Option<&'static str> {
        kind::name(high_word)
    }

    fn unit(&self, at: Multiplexer) -> Option<Unit> {
        units::of(at)
    }

    fn scale(&self, at: Multiplexer, device: &dyn Configured) -> Option<Unit> {
        scaling::scale(at, device)
    }

    fn acting(&self, at: Multiplexer) -> Option<Acting> {
        let moves = matches!(
            at.index.0,
            objects::PRESET_VALUE | objects::HIGH_PRECISION_PRESET | objects::CHANNEL_PRESET_VALUES
        );
        moves.then_some(Acting::MovesZeroPoint)
    }

    fn roles(&self) -> &'static [(u16, &'static [Role])] {
        ROLES
    }

    fn keeps_at_once(&self, at: Multiplexer, vendor: u32) -> bool {
        makers::of(vendor).is_some_and(|maker| maker.kept_at_once.contains(&at.index.0))
    }

    fn may_be_silent(&self, device_type: u32) -> bool {
        kind::Kind::of(device_type) == Some(kind::Kind::Linear)
    }
}

/// The value of 6508h and 650Bh in a device that does not support them.
const UNUSED: u32 = u32::MAX;

/// The roles of objects, by index.
const ROLES: &[(u16, &[Role])] = &[
    (objects::OPERATING_PARAMETERS, &[Role::Scaling]),
    (objects::UNITS_PER_REVOLUTION, &[Role::Scaling]),
    (objects::MEASURING_STEPS, &[Role::Scaling]),
    (objects::SPEED_PARAMETER, &[Role::Scaling]),
    (objects::ACCELERATION_PARAMETER, &[Role::Scaling]),
    (objects::CYCLIC_TIMER, &[Role::Parameter, Role::EventTimer]),
    (objects::OPERATING_STATUS, &[Role::Scaling]),
    (objects::SINGLE_TURN_RESOLUTION, &[Role::Scaling, Role::Constant]),
    (objects::NUMBER_OF_REVOLUTIONS, &[Role::Parameter, Role::Constant]),
    (objects::SUPPORTED_ALARMS, &[Role::Constant]),
    (objects::SUPPORTED_WARNINGS, &[Role::Constant]),
    (objects::PROFILE_AND_SOFTWARE_VERSION, &[Role::Scaling, Role::Constant, Role::Identity]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dictionary::DataType;
    use crate::dictionary::names::{acting, bit_name, meaning, object_name, unit};

    #[test]
    fn roles_are_in_the_order_of_the_objects() {
        assert!(ROLES.is_sorted_by(|a, b| a.0 < b.0));
    }

    #[test]
    fn presets_act_and_settings_do_not() {
        let of = |index, profile| acting(Multiplexer::new(index, 0), profile);
        for profile in [Some(NUMBER), None] {
            assert!([0x6003, 0x6009, 0x6010].into_iter().all(|at| of(at, profile) == Some(Acting::MovesZeroPoint)));
            assert!([0x6000, 0x6001, 0x6002, 0x6004, 0x6200].into_iter().all(|at| of(at, profile).is_none()));
        }
        assert_eq!(of(0x6003, Some(0)), None);
    }

    #[test]
    fn objects_and_bits_have_names_and_units_with_this_profile_only() {
        let name = |index, sub| object_name(Multiplexer::new(index, sub), Some(NUMBER)).map(|name| name.to_string());
        assert_eq!(name(0x6004, 0).as_deref(), Some("Position value"));
        assert_eq!(name(0x650A, 3).as_deref(), Some("Module identification, Manufacturer maximum position value"));
        assert_eq!((name(0x6007, 0), name(0x2100, 0)), (None, None));
        for other in [Some(0), None] {
            assert_eq!(object_name(Multiplexer::new(0x6004, 0), other), None);
            assert_eq!((bit_name(Index(0x6000), 2, other), unit(Multiplexer::new(0x6200, 0), other)), (None, None));
        }
        assert_eq!(bit_name(Index(0x6000), 2, Some(NUMBER)), Some("scaling function"));
        assert_eq!(bit_name(Index(0x6000), 13, Some(NUMBER)), None);
        assert_eq!(
            unit(Multiplexer::new(0x6200, 0), Some(NUMBER)).map(|unit| unit.symbol.to_string()),
            Some("ms".into())
        );
        let object = object_name(Multiplexer::new(0x6004, 0), Some(NUMBER)).unwrap().object;
        assert_eq!(object.clause().to_string(), "CiA 406, section unknown");
    }

    /// The values that the manuals of Kübler, Lika and TR-Electronic print.
    #[test]
    fn versions_types_and_unused_values_have_a_meaning() {
        let of = |index, value| meaning(Multiplexer::new(index, 0), value, Some(NUMBER)).map(|text| text.to_string());
        assert_eq!(of(0x6507, 0x0101_0301).as_deref(), Some("profile 3.1, software 1.01"));
        assert_eq!(of(0x6507, 0x2201_0140).as_deref(), Some("profile 1.40, software 22.01"));
        assert_eq!(of(0x6508, 0xFFFF_FFFF).as_deref(), Some("not used"));
        assert_eq!(of(0x1000, 0x0002_0196).as_deref(), Some("profile 406, multi-turn absolute rotary encoder"));
        assert_eq!(of(0x1000, 0x0009_0196).as_deref(), Some("profile 406, absolute linear encoder with cyclic coding"));
        assert_eq!((of(0x1000, 0x196).as_deref(), of(0x6508, 5)), (Some("profile 406"), None));
    }

    #[test]
    fn types_are_those_of_version_3_2() {
        let of =
            |index, sub| object_name(Multiplexer::new(index, sub), Some(NUMBER)).and_then(|name| name.entry).unwrap();
        assert_eq!(of(0x6030, 1).data_type, Some(DataType::INTEGER16));
        assert_eq!(of(0x6401, 1).data_type, Some(DataType::INTEGER32));
    }
}
