//! What the device profiles add to what every device has. The core asks this list and names no profile itself.

use crate::bench::Bench;
use crate::cases::cia406;
use crate::verdict::Stop;
use crate::zero_point::Objects;

/// What a profile knows of a device.
pub(crate) trait Profile: Sync {
    /// The objects of its zero point; `None`: the device is of another profile, or nothing moves its zero point.
    ///
    /// # Errors
    /// Those of asking the device.
    fn zero_point(&self, bench: &mut Bench<'_>) -> Result<Option<Objects>, Stop>;
}

/// All of them.
const PROFILES: [&dyn Profile; 1] = [&cia406::Encoders];

/// The objects of the zero point of the device under test.
///
/// # Errors
/// Those of asking the device.
pub(crate) fn zero_point(bench: &mut Bench<'_>) -> Result<Option<Objects>, Stop> {
    for profile in PROFILES {
        if let Some(objects) = profile.zero_point(bench)? {
            return Ok(Some(objects));
        }
    }
    Ok(None)
}
