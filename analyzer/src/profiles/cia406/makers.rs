//! Properties by which the encoders of a manufacturer differ from others. The vendor-ID (1018h:01) of a node selects
//! them, even if the model is unknown.

use super::objects;
use crate::identity::Multiplexer;

/// Properties that all encoders of a manufacturer have by their manuals.
pub struct Maker {
    /// Vendor-ID.
    vendor: u32,
    /// The bit of 6000h that is set for speeds in steps per second and clear for revolutions per minute.
    pub speed_format: Option<SpeedFormat>,
    /// Objects that the device stores on each write, without 1010h.
    pub kept_at_once: &'static [u16],
    /// The objects with the lowest and the highest temperature without a warning, in degrees Celsius plus 64.
    pub temperature_limits: Option<[Multiplexer; 2]>,
}

/// A bit whose place depends on the version of the profile. The low word of 6507h holds the version: 0302h is 3.2.
pub struct SpeedFormat {
    /// The first version of the profile in which the bit has its new place.
    pub from: u16,
    /// The number of the bit before version `from`.
    pub before: u8,
    /// The number of the bit from version `from` on.
    pub after: u8,
}

static MAKERS: &[Maker] = &[
    // Fritz Kübler GmbH.
    Maker {
        vendor: 0x13,
        speed_format: Some(SpeedFormat { from: 0x0400, before: 13, after: 12 }),
        kept_at_once: &[],
        temperature_limits: Some([Multiplexer::new(0x2120, 2), Multiplexer::new(0x2120, 3)]),
    },
    // TR-Electronic GmbH.
    Maker {
        vendor: 0xD4,
        speed_format: None,
        kept_at_once: &[objects::OPERATING_PARAMETERS, objects::PRESET_VALUE, objects::CYCLIC_TIMER],
        temperature_limits: None,
    },
];

/// The manufacturer with this vendor-ID, if its encoders are known to differ.
pub fn of(vendor: u32) -> Option<&'static Maker> {
    MAKERS.iter().find(|maker| maker.vendor == vendor)
}

/// The objects with temperature limits, of all manufacturers.
pub fn temperature_limits() -> impl Iterator<Item = Multiplexer> {
    MAKERS.iter().flat_map(|maker| maker.temperature_limits).flatten()
}
