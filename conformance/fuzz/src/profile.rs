//! The interface to device profiles: the properties that a profile adds to the properties of every device, and the
//! dialogues that check them.
//!
//! A profile registers itself; models and generators ask the profiles that a device may have, and name no profile.

use super::Knowledge;
use super::property::ProfileProperty;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::Request;
use std::fmt;
use std::sync::LazyLock;

/// The requirements of a device profile on its devices, written from its standard.
pub trait Profile: Sync + fmt::Debug {
    /// The number of the profile, as in the low word of 1000h.
    fn number(&self) -> u16;

    /// The properties of the profile.
    fn properties(&self) -> &'static [&'static ProfileProperty];

    /// Checks a value that the device has sent by SDO; `expected` gives the values of other objects, as far as they are
    /// certain.
    fn judge(
        &self,
        at: Multiplexer,
        value: &[u8],
        knowledge: &Knowledge,
        expected: &dyn Fn(Multiplexer) -> Option<u64>,
    ) -> Option<Broken>;

    /// Writes a dialogue that may show a violated property; `false` if the device lacks the objects for it.
    fn dialogue(&self, _: &mut dyn Dialogue) -> bool {
        false
    }

    /// Whether an object is a limit that the current value can exceed, so that the device reports an error.
    fn provokes(&self, _: Multiplexer) -> bool {
        false
    }
}

/// A violated property.
#[derive(Clone, Debug)]
pub struct Broken {
    /// The property.
    pub property: &'static ProfileProperty,
    /// The expected answer.
    pub expected: String,
    /// The answer of the device.
    pub actual: String,
}

/// A dialogue under construction.
pub trait Dialogue {
    /// The knowledge of the device.
    fn knowledge(&self) -> &Knowledge;

    /// A random number from 0 to `n` - 1.
    fn below(&mut self, n: usize) -> usize;

    /// A random number.
    fn number(&mut self) -> u64;

    /// A value near the limits of the object, if it is writable.
    fn value_of(&mut self, at: Multiplexer) -> Option<u64>;

    /// Adds an SDO request.
    fn ask(&mut self, request: Request);
}

/// A registered profile.
pub struct Registered(pub &'static dyn Profile);

inventory::collect!(Registered);

/// All profiles, sorted by number so that the order does not depend on the linker.
static PROFILES: LazyLock<Vec<&'static dyn Profile>> = LazyLock::new(|| {
    let mut profiles: Vec<_> = inventory::iter::<Registered>.into_iter().map(|registered| registered.0).collect();
    profiles.sort_by_key(|profile| profile.number());
    profiles
});

/// All profiles, by number.
pub(super) fn all() -> &'static [&'static dyn Profile] {
    &PROFILES
}

/// The profiles that a device may have: the one with its number, or all if the number is unknown.
pub(super) fn possible(number: Option<u16>) -> Vec<&'static dyn Profile> {
    all().iter().copied().filter(|profile| number.is_none_or(|number| profile.number() == number)).collect()
}
