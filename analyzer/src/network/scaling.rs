//! Physical values of encoders (CiA 406) in the current configuration: degrees or millimetres of a position, the unit
//! of a speed.

use super::node::Node;
use crate::dictionary::Unit;
use crate::dictionary::names::ENCODER_PROFILE;
use crate::object;
use crate::object::encoder;
use crate::{Multiplexer, NodeId};
use std::borrow::Cow;

/// Vendor-ID (1018h:01) of Fritz Kübler GmbH.
const KUEBLER: u32 = 0x13;

/// Whether the values of other objects depend on that object.
pub const fn is_scaling_parameter(object: Multiplexer) -> bool {
    matches!(
        object.index.0,
        object::DEVICE_TYPE
            | encoder::OPERATING_PARAMETERS
            | encoder::UNITS_PER_REVOLUTION
            | encoder::MEASURING_STEPS
            | encoder::SPEED_PARAMETER
            | encoder::OPERATING_STATUS
            | encoder::SINGLE_TURN_RESOLUTION
            | encoder::PROFILE_AND_SOFTWARE_VERSION
    )
}

/// The physical unit of an object that the device's configuration determines; `None` if there is none or too little
/// is known.
pub fn scale(node: &Node, id: NodeId, object: Multiplexer) -> Option<Unit> {
    if !may_scale(object) || node.profile(id) != Some(ENCODER_PROFILE) {
        return None;
    }
    let of = |index, sub| node.parameter(id, Multiplexer::new(index, sub));
    match object.index.0 {
        encoder::SPEED_VALUE => speed(node, of),
        encoder::POSITION_RAW_VALUE => position(of, true),
        _ => position(of, false),
    }
}

/// Positions, limits and offsets of positions, and speeds.
const fn may_scale(object: Multiplexer) -> bool {
    match object.index.0 {
        encoder::PRESET_VALUE | encoder::POSITION_VALUE | encoder::POSITION_RAW_VALUE | encoder::OFFSET_VALUE => {
            object.sub.0 == 0
        }
        encoder::CHANNEL_PRESET_VALUES
        | encoder::CHANNEL_POSITION_VALUES
        | encoder::SPEED_VALUE
        | 0x6310..=0x6317
        | 0x6320..=0x6327
        | 0x6330..=0x6337
        | encoder::WORK_AREA_LOW_LIMIT
        | encoder::WORK_AREA_HIGH_LIMIT => object.sub.0 != 0,
        _ => false,
    }
}

/// The unit of a position in steps. `raw` steps are the sensor's own, independent of the scaling.
fn position(of: impl Fn(u16, u8) -> Option<u32>, raw: bool) -> Option<Unit> {
    match of(object::DEVICE_TYPE, 0)? >> 16 {
        // Rotary: 01h to 05h of CiA 406; 0Bh of newer devices.
        0x01..=0x05 | 0x0B => {
            let physical = || of(encoder::SINGLE_TURN_RESOLUTION, 0);
            // Bit 2 switches the scaling function.
            let scaled = of(encoder::OPERATING_PARAMETERS, 0)
                .or_else(|| of(encoder::OPERATING_STATUS, 0))
                .map(|operating| operating & 4 != 0);
            let steps = match scaled {
                _ if raw => physical(),
                Some(false) => physical(),
                Some(true) | None => of(encoder::UNITS_PER_REVOLUTION, 0),
            };
            let steps = steps.filter(|&steps| steps > 0)?;
            Some(unit(360.0 / f64::from(steps), Cow::Borrowed("°")))
        }
        // Linear: 08h and 09h. 6005h:01 counts in steps of 0.001 µm, and so does 6501h.
        0x08 | 0x09 => {
            let configured = of(encoder::MEASURING_STEPS, 1).filter(|_| !raw);
            let nanometres = configured.or_else(|| of(encoder::SINGLE_TURN_RESOLUTION, 0)).filter(|&step| step > 0)?;
            Some(unit(f64::from(nanometres) / 1e6, Cow::Borrowed("mm")))
        }
        _ => None,
    }
}

/// The unit of a speed: from a bit of 6000h that the description calls "Speed format"; else by the rule of one
/// manufacturer; else from multiplier and divisor in 6031h.
fn speed(node: &Node, of: impl Fn(u16, u8) -> Option<u32>) -> Option<Unit> {
    let format = named_format(node, &of).or_else(|| format_of_kuebler(&of));
    match format {
        Some(rpm) if rpm == "rpm" => Some(unit(1.0, rpm)),
        _ => {
            // speed = steps / s * multiplier / divisor
            let (multiplier, divisor) = (
                of(encoder::SPEED_PARAMETER, 3).filter(|&m| m > 0),
                of(encoder::SPEED_PARAMETER, 4).filter(|&d| d > 0),
            );
            match (multiplier.zip(divisor), format) {
                (Some((multiplier, divisor)), _) => {
                    Some(unit(f64::from(divisor) / f64::from(multiplier), Cow::Borrowed("steps/s")))
                }
                (None, Some(format)) => Some(unit(1.0, format)),
                (None, None) => None,
            }
        }
    }
}

/// The state of the bit of 6000h that an annotation calls "Speed format".
fn named_format(node: &Node, of: &impl Fn(u16, u8) -> Option<u32>) -> Option<Cow<'static, str>> {
    let device = node.device.as_ref()?;
    let operating = of(encoder::OPERATING_PARAMETERS, 0)?;
    let annotation = device.manual.annotations.get(Multiplexer::new(encoder::OPERATING_PARAMETERS, 0))?;
    let bit = annotation.bits.iter().find(|bit| bit.name.starts_with("Speed format"))?;
    let state = if operating >> bit.bit.min(31) & 1 != 0 { Some(&bit.name) } else { bit.clear.as_ref() };
    Some(match state?.split_once(": ")?.1 {
        "units per second" => Cow::Borrowed("steps/s"),
        other => Cow::Owned(other.to_owned()),
    })
}

/// Bit 13 of 6000h up to version 3.2 of the profile, bit 12 from 4.1 on.
fn format_of_kuebler(of: &impl Fn(u16, u8) -> Option<u32>) -> Option<Cow<'static, str>> {
    if of(object::IDENTITY, 1)? != KUEBLER {
        return None;
    }
    // The low word of 6507h is the version of the profile: 0302h is 3.2.
    let bit = if of(encoder::PROFILE_AND_SOFTWARE_VERSION, 0)? as u16 >= 0x0400 { 12 } else { 13 };
    let units_per_second = of(encoder::OPERATING_PARAMETERS, 0)? >> bit & 1 != 0;
    Some(Cow::Borrowed(if units_per_second { "steps/s" } else { "rpm" }))
}

const fn unit(factor: f64, symbol: Cow<'static, str>) -> Unit {
    Unit { factor, offset: 0.0, symbol }
}
