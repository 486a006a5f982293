//! Faults in the object dictionary of an encoder, as an overlay over the description.

use crate::device::{Content, Parameters};
use crate::{Fault, Firmware};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;

/// The encoder type "single-turn" in the upper word of 1000h.
const SINGLE_TURN: u64 = 0x0001_0000;
/// A reserved bit of 6503h and 6504h.
const RESERVED_ALARM: u64 = 1 << 3;

/// Changes the objects of an encoder in the object dictionary according to the firmware's faults.
pub(super) fn plant(parameters: &mut Parameters, firmware: &Firmware) {
    let wrong = |fault: Fault, at: Multiplexer, number: u64, parameters: &mut Parameters| {
        if firmware.has(fault) {
            parameters.redefine(at, Content::Number(number));
        }
    };
    let at = |index| Multiplexer::new(index, 0);
    let profile = parameters.number_or_zero(object::DEVICE_TYPE, 0) & 0xFFFF;
    wrong(Fault::DeviceTypeTurnsWrong, at(object::DEVICE_TYPE), SINGLE_TURN | profile, parameters);
    wrong(Fault::RevolutionsZero, at(encoder::NUMBER_OF_REVOLUTIONS), 0, parameters);
    wrong(Fault::ProfileVersionUnset, at(encoder::PROFILE_AND_SOFTWARE_VERSION), 0xFFFF_FFFF, parameters);
    let half = parameters.number_or_zero(encoder::MODULE_IDENTIFICATION, 3) / 2;
    wrong(Fault::HighestPositionWrong, Multiplexer::new(encoder::MODULE_IDENTIFICATION, 3), half, parameters);
    let alarms = parameters.number_or_zero(encoder::SUPPORTED_ALARMS, 0) | RESERVED_ALARM;
    wrong(Fault::ReservedAlarmBitSet, at(encoder::SUPPORTED_ALARMS), alarms, parameters);
    let serial = parameters.number_or_zero(encoder::SERIAL_NUMBER, 0) + 1;
    wrong(Fault::SerialNumberDiffers, at(encoder::SERIAL_NUMBER), serial, parameters);
    if firmware.has(Fault::OperatingStatusMissing) {
        parameters.remove(encoder::OPERATING_STATUS, None);
    }
    if firmware.has(Fault::AlarmsMissing) {
        parameters.remove(encoder::ALARMS, None);
    }
    if firmware.has(Fault::PositionSixteenBit) {
        parameters.retype(at(encoder::POSITION_VALUE), DataType::UNSIGNED16);
    }
    if firmware.has(Fault::OperatingParametersThirtyTwoBit) {
        parameters.retype(at(encoder::OPERATING_PARAMETERS), DataType::UNSIGNED32);
    }
    if firmware.has(Fault::PositionWritable) {
        parameters.open(at(encoder::POSITION_VALUE));
    }
}
