//! Faults in what the dictionary of an encoder holds, not in what its firmware does.

use crate::device::parameters::{Content, Parameters};
use crate::{Fault, Faults};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;

/// A single-turn encoder in the upper word of 1000h.
const SINGLE_TURN: u64 = 0x0001_0000;
/// A bit of 6503h and 6504h that is reserved.
const RESERVED_ALARM: u64 = 1 << 3;

/// Changes what the dictionary says, as the faults have it.
pub(in crate::device) fn plant(parameters: &mut Parameters, faults: Faults) {
    let wrong = |fault: Fault, at: Multiplexer, number: u64, parameters: &mut Parameters| {
        if faults.has(fault) {
            parameters.redefine(at, Content::Number(number));
        }
    };
    let at = |index| Multiplexer::new(index, 0);
    let profile = parameters.number_or_zero(0x1000, 0) & 0xFFFF;
    wrong(Fault::DeviceTypeTurnsWrong, at(0x1000), SINGLE_TURN | profile, parameters);
    wrong(Fault::RevolutionsZero, at(0x6502), 0, parameters);
    wrong(Fault::ProfileVersionUnset, at(0x6507), 0xFFFF_FFFF, parameters);
    let half = parameters.number_or_zero(0x650A, 3) / 2;
    wrong(Fault::HighestPositionWrong, Multiplexer::new(0x650A, 3), half, parameters);
    let alarms = parameters.number_or_zero(0x6504, 0) | RESERVED_ALARM;
    wrong(Fault::ReservedAlarmBitSet, at(0x6504), alarms, parameters);
    let serial = parameters.number_or_zero(0x650B, 0) + 1;
    wrong(Fault::SerialNumberDiffers, at(0x650B), serial, parameters);
    if faults.has(Fault::OperatingStatusMissing) {
        parameters.remove(0x6500, None);
    }
    if faults.has(Fault::AlarmsMissing) {
        parameters.remove(0x6503, None);
    }
    if faults.has(Fault::PositionSixteenBit) {
        parameters.retype(at(0x6004), DataType::UNSIGNED16);
    }
    if faults.has(Fault::OperatingParametersThirtyTwoBit) {
        parameters.retype(at(0x6000), DataType::UNSIGNED32);
    }
    if faults.has(Fault::PositionWritable) {
        parameters.open(at(0x6004));
    }
}
