//! The interface to device profiles: the objects of a profile that the bench needs. The bench asks the registered
//! profiles and knows none by name.

use super::Bench;
use super::objects::Candidate;
use crate::verdict::Stop;
use crate::zero_point::Objects;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DeviceDescription;
use std::sync::LazyLock;

/// A device profile as the bench sees it.
pub trait Profile: Sync {
    /// The number of the profile, as in the low word of 1000h.
    fn number(&self) -> u16;

    /// The objects of the zero point; `None` if the device is of another profile, or nothing moves its zero point.
    ///
    /// # Errors
    /// The errors of asking the device.
    fn zero_point(&self, _: &mut Bench<'_>) -> Result<Option<Objects>, Stop> {
        Ok(None)
    }

    /// The objects of the profile that can be written and read back without side effects, best first.
    fn scratch(&self) -> &'static [Candidate] {
        &[]
    }

    /// The objects of [`Profile::scratch`] for cases that need an object of the application.
    fn application_scratch(&self) -> &'static [Candidate] {
        &[]
    }

    /// Whether an object is a parameter that keeps its value, rather than a measured value or a command.
    fn is_parameter(&self, _: Multiplexer) -> bool {
        false
    }

    /// Whether an object shows how the device scales its values: it changes only if the device is configured anew.
    fn is_scaling(&self, _: Multiplexer) -> bool {
        false
    }
}

/// A registered profile.
pub struct Registered(pub &'static dyn Profile);

inventory::collect!(Registered);

/// All profiles by number, so that their order does not depend on the linker.
static PROFILES: LazyLock<Vec<&'static dyn Profile>> = LazyLock::new(|| {
    let mut profiles: Vec<_> = inventory::iter::<Registered>.into_iter().map(|registered| registered.0).collect();
    profiles.sort_by_key(|profile| profile.number());
    profiles
});

/// All profiles, by number.
pub(crate) fn all() -> impl Iterator<Item = &'static dyn Profile> {
    PROFILES.iter().copied()
}

/// The objects of the zero point of the device under test.
///
/// # Errors
/// The errors of asking the device.
pub(super) fn zero_point(bench: &mut Bench<'_>) -> Result<Option<Objects>, Stop> {
    for profile in all() {
        if let Some(objects) = profile.zero_point(bench)? {
            return Ok(Some(objects));
        }
    }
    Ok(None)
}

/// Whether an object shows how the device under test scales its values.
pub(super) fn is_scaling(bench: &Bench<'_>, at: Multiplexer) -> bool {
    let profile = bench.target.description.as_ref().and_then(DeviceDescription::device_profile);
    all().any(|known| profile == Some(known.number()) && known.is_scaling(at))
}
