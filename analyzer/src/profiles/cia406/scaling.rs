//! Physical values of encoders in the current configuration: degrees or millimetres of a position, the units of speed
//! and acceleration.

use super::kind::Kind;
use super::{makers, objects};
use crate::dictionary::Unit;
use crate::dictionary::names::Configured;
use crate::identity::Multiplexer;
use crate::object;
use std::borrow::Cow;

/// The physical unit of an object that the device's configuration determines; `None` if there is none or too little
/// is known.
pub(super) fn scale(at: Multiplexer, device: &dyn Configured) -> Option<Unit> {
    if !may_scale(at) {
        return None;
    }
    match at.index.0 {
        objects::SPEED_VALUE => speed(device),
        objects::ACCELERATION_VALUE => acceleration(device),
        objects::POSITION_RAW_VALUE => position(device, true),
        _ => position(device, false),
    }
}

/// Whether an object may have a configured unit: positions, limits and offsets of positions, and speeds.
const fn may_scale(object: Multiplexer) -> bool {
    match object.index.0 {
        objects::PRESET_VALUE | objects::POSITION_VALUE | objects::POSITION_RAW_VALUE | objects::OFFSET_VALUE => {
            object.sub.0 == 0
        }
        objects::CHANNEL_PRESET_VALUES
        | objects::CHANNEL_POSITION_VALUES
        | objects::SPEED_VALUE
        | objects::ACCELERATION_VALUE
        | 0x6310..=0x6317
        | 0x6320..=0x6327
        | 0x6330..=0x6337
        | objects::WORK_AREA_LOW_LIMIT
        | objects::WORK_AREA_HIGH_LIMIT => object.sub.0 != 0,
        _ => false,
    }
}

/// The value of a parameter.
fn of(device: &dyn Configured, index: u16, sub: u8) -> Option<u32> {
    device.parameter(Multiplexer::new(index, sub))
}

/// The value of a parameter; `None` for 0, which has no meaning.
fn positive(device: &dyn Configured, index: u16, sub: u8) -> Option<u32> {
    of(device, index, sub).filter(|&value| value > 0)
}

/// The unit of a position in steps. With `raw` the steps are those of the sensor, independent of the scaling.
fn position(device: &dyn Configured, raw: bool) -> Option<Unit> {
    match Kind::of(of(device, object::DEVICE_TYPE, 0)?)? {
        Kind::Rotary => {
            let index = if raw || is_scaled(device) == Some(false) {
                objects::SINGLE_TURN_RESOLUTION
            } else {
                objects::UNITS_PER_REVOLUTION
            };
            let steps = positive(device, index, 0)?;
            Some(Unit::new(360.0 / f64::from(steps), "°"))
        }
        // 6005h:01 counts in steps of 0.001 µm, and so does 6501h.
        Kind::Linear => {
            let configured = of(device, objects::MEASURING_STEPS, 1).filter(|_| !raw);
            let nanometres = configured.or_else(|| of(device, objects::SINGLE_TURN_RESOLUTION, 0));
            Some(Unit::new(f64::from(nanometres.filter(|&step| step > 0)?) / 1e6, "mm"))
        }
    }
}

/// Whether the scaling function is on: bit 2 of 6000h or, if 6000h is unknown, of 6500h.
fn is_scaled(device: &dyn Configured) -> Option<bool> {
    let operating =
        of(device, objects::OPERATING_PARAMETERS, 0).or_else(|| of(device, objects::OPERATING_STATUS, 0))?;
    Some(operating & 4 != 0)
}

/// The unit of a speed: from a bit of 6000h that the description calls "Speed format"; else by the rule of the
/// manufacturer; else from multiplier and divisor in 6031h.
fn speed(device: &dyn Configured) -> Option<Unit> {
    let format = named_format(device).or_else(|| format_of_maker(device));
    if format.as_deref() == Some("rpm") {
        return Some(Unit::new(1.0, "rpm"));
    }
    // speed = steps / s * multiplier / divisor
    let multiplier = positive(device, objects::SPEED_PARAMETER, 3);
    match (multiplier.zip(positive(device, objects::SPEED_PARAMETER, 4)), format) {
        (Some((multiplier, divisor)), _) => Some(Unit::new(f64::from(divisor) / f64::from(multiplier), "steps/s")),
        (None, Some(symbol)) => Some(Unit { factor: 1.0, offset: 0.0, symbol }),
        (None, None) => None,
    }
}

/// The unit of an acceleration: the unit of the speed per second, with multiplier and divisor of 6041h.
fn acceleration(device: &dyn Configured) -> Option<Unit> {
    let speed = speed(device)?;
    let of = |sub| positive(device, objects::ACCELERATION_PARAMETER, sub).map(f64::from);
    let factor = of(3).zip(of(4)).map_or(1.0, |(multiplier, divisor)| divisor / multiplier);
    let symbol = match &*speed.symbol {
        "steps/s" => Cow::Borrowed("steps/s²"),
        other => Cow::Owned(format!("{other}/s")),
    };
    Some(Unit { factor: speed.factor * factor, offset: 0.0, symbol })
}

/// The state of the bit of 6000h that an annotation calls "Speed format".
fn named_format(device: &dyn Configured) -> Option<Cow<'static, str>> {
    let state = device.state_of_bit(Multiplexer::new(objects::OPERATING_PARAMETERS, 0), "Speed format")?;
    Some(match state.split_once(": ")?.1 {
        "units per second" => Cow::Borrowed("steps/s"),
        other => Cow::Owned(other.to_owned()),
    })
}

/// The state of the bit of 6000h that all encoders of the manufacturer have for the format.
fn format_of_maker(device: &dyn Configured) -> Option<Cow<'static, str>> {
    let format = makers::of(of(device, object::IDENTITY, 1)?)?.speed_format.as_ref()?;
    let version = of(device, objects::PROFILE_AND_SOFTWARE_VERSION, 0)? as u16;
    let bit = if version >= format.from { format.after } else { format.before };
    let units_per_second = of(device, objects::OPERATING_PARAMETERS, 0)? >> bit & 1 != 0;
    Some(Cow::Borrowed(if units_per_second { "steps/s" } else { "rpm" }))
}
