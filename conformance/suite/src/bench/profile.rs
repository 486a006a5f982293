//! What the device profiles add to what every device has. The core asks those that are registered, and names no profile itself.

use super::Bench;
use crate::verdict::Stop;
use crate::zero_point::Objects;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DeviceDescription;

/// What a profile knows of a device.
pub(crate) trait Profile: Sync {
    /// The objects of its zero point; `None`: the device is of another profile, or nothing moves its zero point.
    ///
    /// # Errors
    /// Those of asking the device.
    fn zero_point(&self, bench: &mut Bench<'_>) -> Result<Option<Objects>, Stop>;

    /// Whether an object shows how the device scales its values: it differs only if the device was set up in another way.
    fn is_scaling(&self, profile: Option<u16>, at: Multiplexer) -> bool;
}

/// A profile that there is.
pub(crate) struct Registered(pub &'static dyn Profile);

inventory::collect!(Registered);

/// The objects of the zero point of the device under test.
///
/// # Errors
/// Those of asking the device.
pub(super) fn zero_point(bench: &mut Bench<'_>) -> Result<Option<Objects>, Stop> {
    for Registered(profile) in inventory::iter::<Registered> {
        if let Some(objects) = profile.zero_point(bench)? {
            return Ok(Some(objects));
        }
    }
    Ok(None)
}

/// Whether an object of the device under test shows how it scales its values.
pub(super) fn is_scaling(bench: &Bench<'_>, at: Multiplexer) -> bool {
    let profile = bench.target.description.as_ref().and_then(DeviceDescription::device_profile);
    inventory::iter::<Registered>.into_iter().any(|Registered(known)| known.is_scaling(profile, at))
}
