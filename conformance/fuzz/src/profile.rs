//! The seam for device profiles: the properties that a profile adds to those of every device, and the dialogues in which
//! they show.
//!
//! A profile registers itself; models and generators ask the profiles that a device may have and name none.

use super::Knowledge;
use super::property::ProfileProperty;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::Request;
use std::fmt;
use std::sync::LazyLock;

/// What a device profile demands of its devices, written from its standard.
pub trait Profile: Sync + fmt::Debug {
    /// Its number, as in the low word of 1000h.
    fn number(&self) -> u16;

    /// Its properties.
    fn properties(&self) -> &'static [&'static ProfileProperty];

    /// What a value that the device has given by SDO shows to be wrong, if anything; `expected` tells the values that
    /// other objects hold as far as that is certain.
    fn judge(
        &self,
        at: Multiplexer,
        value: &[u8],
        knowledge: &Knowledge,
        expected: &dyn Fn(Multiplexer) -> Option<u64>,
    ) -> Option<Broken>;

    /// Writes a dialogue in which a property may show to be broken. `false`: the device has not the objects for it.
    fn dialogue(&self, _: &mut dyn Dialogue) -> bool {
        false
    }

    /// Whether an object holds a limit that the present value can exceed, so that the device reports an error.
    fn provokes(&self, _: Multiplexer) -> bool {
        false
    }
}

/// A property that does not hold.
#[derive(Clone, Debug)]
pub struct Broken {
    /// Which.
    pub property: &'static ProfileProperty,
    /// What the device had to answer.
    pub expected: String,
    /// What it did answer.
    pub actual: String,
}

/// A dialogue that is being written.
pub trait Dialogue {
    /// The device.
    fn knowledge(&self) -> &Knowledge;

    /// A random number from 0 to `n` - 1.
    fn below(&mut self, n: usize) -> usize;

    /// A random number.
    fn number(&mut self) -> u64;

    /// A value near the edges of what the object takes, if it can be written.
    fn value_of(&mut self, at: Multiplexer) -> Option<u64>;

    /// Adds a request.
    fn ask(&mut self, request: Request);
}

/// A profile that there is.
pub struct Registered(pub &'static dyn Profile);

inventory::collect!(Registered);

/// All profiles by number: the order does not depend on the linker.
static PROFILES: LazyLock<Vec<&'static dyn Profile>> = LazyLock::new(|| {
    let mut profiles: Vec<_> = inventory::iter::<Registered>.into_iter().map(|registered| registered.0).collect();
    profiles.sort_by_key(|profile| profile.number());
    profiles
});

/// All profiles, by number.
pub(super) fn all() -> &'static [&'static dyn Profile] {
    &PROFILES
}

/// The profiles that a device may have: that of its number, or all where nobody knows it.
pub(super) fn possible(number: Option<u16>) -> Vec<&'static dyn Profile> {
    all().iter().copied().filter(|profile| number.is_none_or(|number| profile.number() == number)).collect()
}
