//! The interface for device profiles: the objects of a profile, and the list of registered profiles.
//!
//! A profile registers itself; nothing else names it. Look-ups for frames use tables that are built once from all
//! profiles, so that a frame costs no virtual call.

use super::{Meaning, StandardObject, Unit};
use crate::identity::{Index, Multiplexer};
use crate::object::Acting;
use crate::wire::emcy::EmcyCode;
use std::sync::LazyLock;

/// The objects of a device profile, from 6000h on, and properties of the devices that have them.
pub trait Profile: Sync {
    /// The number of the profile, as in the low word of 1000h.
    fn number(&self) -> u16;

    /// The standard of the profile, such as `CiA 401`.
    fn standard(&self) -> &'static str;

    /// The objects of the profile by rising index, from 6000h to 67FFh.
    fn objects(&self) -> &'static [StandardObject];

    /// Maximum number of logical devices with objects of their own: the objects of each further logical device are 800h
    /// higher.
    fn logical_devices(&self) -> u16 {
        1
    }

    /// The profile's word for a logical device.
    fn logical_device(&self) -> &'static str {
        "logical device"
    }

    /// The meaning of a whole value of an object of the first logical device, such as the name of a state.
    fn meaning(&self, _: Multiplexer, _value: i64) -> Option<Meaning> {
        None
    }

    /// The kind of a device by the high word of its device type (1000h).
    fn device_kind(&self, _: u16) -> Option<&'static str> {
        None
    }

    /// The names of an object's bits, from bit 0 on; empty if the profile does not define them, and an empty name for a
    /// bit that the meaning of the whole value includes.
    fn bits(&self, _: Index) -> &'static [&'static str] {
        &[]
    }

    /// The object whose bits have the same meaning as the bits of this object, and whose bits the manual describes.
    fn same_bits(&self, _: Index) -> Option<Index> {
        None
    }

    /// The unit of an entry, if the profile fixes it.
    fn unit(&self, _: Multiplexer) -> Option<Unit> {
        None
    }

    /// The unit of an entry, if the device's configuration determines it.
    fn scale(&self, _: Multiplexer, _: &dyn Configured) -> Option<Unit> {
        None
    }

    /// The meaning of an error code that CiA 301 leaves to the profile.
    fn emergency(&self, _: EmcyCode) -> Option<&'static str> {
        None
    }

    /// The action of writing an object; `None` for a setting or a read-only object.
    fn acting(&self, _: Multiplexer) -> Option<Acting> {
        None
    }

    /// The objects that have a role, each with its roles.
    fn roles(&self) -> &'static [(u16, &'static [Role])] {
        &[]
    }

    /// Whether the devices of a manufacturer (vendor-ID, 1018h:01) store the object on each download.
    fn keeps_at_once(&self, _: Multiplexer, _vendor: u32) -> bool {
        false
    }

    /// Whether a correct device of this type (1000h) may send nothing after a reset until it gets a request.
    fn may_be_silent(&self, _device_type: u32) -> bool {
        false
    }
}

/// The current configuration of a device, as far as it is known.
pub trait Configured {
    /// The value of a parameter.
    fn parameter(&self, at: Multiplexer) -> Option<u32>;

    /// The manual's name for the state of a bit. The bit is the first bit of the object whose name begins with `name`.
    fn state_of_bit(&self, at: Multiplexer, name: &str) -> Option<&str>;
}

/// The meaning of an object's value for other objects or for the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// The value determines the unit of other objects.
    Scaling,
    /// The value configures the device; the analyzer keeps it once the trace has shown it.
    Parameter,
    /// The construction of the device determines the value; neither restoring defaults nor a client changes it.
    Constant,
    /// The value identifies the model of the device.
    Identity,
    /// The value is the period of the first TPDO, in milliseconds, if the event timer (1800h:05) does not give it.
    EventTimer,
}

/// A registered profile.
pub struct Registered(pub &'static dyn Profile);

inventory::collect!(Registered);

/// A profile with its number and objects, cached for the look-ups of frames.
struct Known {
    number: u16,
    objects: &'static [StandardObject],
    devices: u16,
    profile: &'static dyn Profile,
}

/// All profiles by number: the order does not depend on the linker.
static PROFILES: LazyLock<Vec<Known>> = LazyLock::new(|| {
    let registered = inventory::iter::<Registered>.into_iter();
    let mut profiles: Vec<Known> = registered
        .map(|&Registered(profile)| Known {
            number: profile.number(),
            objects: profile.objects(),
            devices: profile.logical_devices(),
            profile,
        })
        .collect();
    profiles.sort_by_key(|known| known.number);
    debug_assert!(profiles.windows(2).all(|two| two[0].number != two[1].number), "two profiles of one number");
    profiles
});

/// The standardized profile area of the first logical device (CiA 301, 7.4.1): its first index, and its number of
/// indexes. The objects of profiles lie there.
const OBJECTS: (u16, usize) = (0x6000, 0x800);

/// For each index, one bit for each role that the object has in any profile. Every decoded SDO transfer needs this
/// look-up.
static ROLES: LazyLock<[u8; OBJECTS.1]> = LazyLock::new(|| {
    let mut roles = [0; OBJECTS.1];
    for (index, of_object) in profiles().flat_map(Profile::roles) {
        let row = place(Index(*index)).and_then(|at| roles.get_mut(at));
        debug_assert!(row.is_some(), "{index:04X}h is no object of a profile");
        if let Some(row) = row {
            *row |= of_object.iter().fold(0, |bits, role| bits | role.bit());
        }
    }
    roles
});

fn place(index: Index) -> Option<usize> {
    index.0.checked_sub(OBJECTS.0).map(usize::from).filter(|&at| at < OBJECTS.1)
}

impl Role {
    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// All profiles, by number.
pub fn profiles() -> impl Iterator<Item = &'static dyn Profile> {
    PROFILES.iter().map(|known| known.profile)
}

/// The profile of that number, if it is registered.
pub fn known_profile(number: u16) -> Option<&'static dyn Profile> {
    known(number).map(|known| known.profile)
}

/// Whether the profile of that number is registered.
pub fn is_profile(number: u16) -> bool {
    known(number).is_some()
}

/// The profiles that a device may have: the profile of its number, or all if the number is unknown.
pub fn possible(number: Option<u16>) -> impl Iterator<Item = &'static dyn Profile> {
    profiles().filter(move |profile| number.is_none_or(|number| profile.number() == number))
}

/// The action of writing an object of a device of a profile.
///
/// A device of unknown profile may have the action of any profile: taking a setting for an acting object does no harm,
/// but taking an acting object for a setting loses, for example, a zero point.
pub fn acting(at: Multiplexer, number: Option<u16>) -> Option<Acting> {
    possible(number).find_map(|profile| profile.acting(at))
}

/// Whether an object has that role in any profile.
pub fn has_role(index: Index, role: Role) -> bool {
    place(index).and_then(|at| ROLES.get(at)).is_some_and(|roles| roles & role.bit() != 0)
}

/// The objects that have that role in a profile, by rising index.
pub fn with_role(profile: &dyn Profile, role: Role) -> impl Iterator<Item = Index> {
    profile.roles().iter().filter(move |row| row.1.contains(&role)).map(|row| Index(row.0))
}

/// The objects of the profile of that number.
pub(super) fn objects(number: u16) -> &'static [StandardObject] {
    known(number).map_or(&[], |known| known.objects)
}

/// An object of a logical device.
#[derive(Clone, Copy)]
pub(super) struct LogicalDevice {
    /// The object of the first logical device with the same meaning.
    pub object: Index,
    /// The number of the logical device, from 1.
    pub number: u16,
    /// The profile.
    pub profile: &'static dyn Profile,
}

/// The logical device of an object in a profile: each logical device has 800h indexes (CiA 301, 7.4.1). `None` if the
/// profile is not registered, or has no such logical device.
pub(super) fn logical_device(index: Index, number: u16) -> Option<LogicalDevice> {
    let (offset, size) = (index.0.checked_sub(OBJECTS.0)?, OBJECTS.1 as u16);
    let known = known(number)?;
    let device = offset / size;
    let object = Index(OBJECTS.0 + offset % size);
    (device < known.devices).then_some(LogicalDevice { object, number: device + 1, profile: known.profile })
}

fn known(number: u16) -> Option<&'static Known> {
    PROFILES.iter().find(|known| known.number == number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_well_formed() {
        assert!(profiles().next().is_some());
        for profile in profiles() {
            let number = profile.number();
            assert!(known_profile(number).is_some() && is_profile(number));
            assert!(profile.standard().ends_with(&number.to_string()), "{}", profile.standard());
            let objects = profile.objects();
            assert!(objects.iter().all(|object| matches!((object.first, object.last), (0x6000.., ..=0x67FF))));
            assert!(objects.iter().all(|object| object.standard == profile.standard()));
            super::super::tests::is_sorted_and_complete(objects);
            let has_object = |index: u16| objects.iter().any(|object| (object.first..=object.last).contains(&index));
            assert!(profile.roles().iter().all(|row| has_object(row.0) && !row.1.is_empty()), "{number}");
        }
        assert!(!is_profile(0) && possible(Some(0)).next().is_none());
        assert_eq!(possible(None).count(), profiles().count());
    }
}
