//! Limit switches (2104h, 2105h) of some devices: bits 12 and 13 of 6000h enable them, the same bits of 6500h show
//! their states.

use crate::device::Parameters;
use crate::{Fault, Firmware};
use canvass_analyzer::profiles::cia406::objects as encoder;

/// "Limit switch min": the position is below 2104h.
const MINIMUM: u64 = 1 << 12;
/// "Limit switch max": the position is above 2105h.
const MAXIMUM: u64 = 1 << 13;

/// The value of 6500h: 6000h, with the state of each limit switch in place of its enabling bit.
pub(super) fn operating_status(position: u64, parameters: &Parameters, firmware: &Firmware) -> u64 {
    let operating = parameters.number_or_zero(encoder::OPERATING_PARAMETERS, 0);
    let (low, high) = (parameters.number_or_zero(0x2104, 0), parameters.number_or_zero(0x2105, 0));
    let (below, above) = match firmware.has(Fault::LimitSwitchInclusive) {
        true => (position <= low, position >= high),
        false => (position < low, position > high),
    };
    let (minimum, maximum) = match firmware.has(Fault::LimitSwitchesSwapped) {
        true => (MAXIMUM, MINIMUM),
        false => (MINIMUM, MAXIMUM),
    };
    let mut status = operating & !(MINIMUM | MAXIMUM);
    if below && operating & MINIMUM != 0 {
        status |= minimum;
    }
    if above && operating & MAXIMUM != 0 {
        status |= maximum;
    }
    status
}
