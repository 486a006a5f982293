//! Faults and liberties in the content of the dictionary, not in the behaviour of the firmware: an overlay over the
//! description.

use super::parameters::{Content, Parameters};
use crate::{Fault, Firmware};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::object;
use canvass_analyzer::object::encoder;

/// A single-turn encoder in the upper word of 1000h.
const SINGLE_TURN: u64 = 0x0001_0000;
/// A bit of 6503h and 6504h that is reserved.
const RESERVED_ALARM: u64 = 1 << 3;

/// Changes the dictionary by the faults and liberties of the firmware.
pub(super) fn plant(parameters: &mut Parameters, firmware: &Firmware) {
    plant_encoder(parameters, firmware);
    let vendor_id = Multiplexer::new(object::IDENTITY, 1);
    let device_type = Multiplexer::new(object::DEVICE_TYPE, 0);
    if firmware.has(Fault::VendorIdZero) {
        parameters.redefine(vendor_id, Content::Number(0));
    }
    if firmware.has(Fault::DeviceTypeProfileWrong) {
        let other = parameters.number_or_zero(object::DEVICE_TYPE, 0) & 0xFFFF_0000 | 401;
        parameters.redefine(device_type, Content::Number(other));
    }
    if firmware.has(Fault::IdentityRevisionMissing) {
        parameters.remove(object::IDENTITY, Some(3));
    }
    for (fault, at) in [
        (Fault::PdoCountWrong, Multiplexer::new(object::NUMBER_OF_PDOS, 0)),
        (Fault::NodeIdObjectWrong, Multiplexer::new(object::NODE_ID, 0)),
        (Fault::GuardingCobIdWrong, Multiplexer::new(object::COB_ID_GUARDING, 0)),
    ] {
        if firmware.has(fault) {
            parameters.redefine(at, Content::Number(parameters.number_or_zero(at.index.0, at.sub.0) + 1));
        }
    }
    if firmware.has(Fault::ErrorControlMissing) {
        parameters.remove(object::LIFE_TIME_FACTOR, None);
    }
    if firmware.has(Fault::ErrorRegisterMissing) {
        parameters.remove(object::ERROR_REGISTER, None);
    }
    if firmware.has(Fault::DeviceNameWithGarbage) {
        let name = Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0);
        let mut bytes = parameters.entry(name).map_or(Vec::new(), |entry| entry.reading(None).bytes().to_vec());
        bytes.extend([0x00, 0xFF, 0x1B]);
        parameters.redefine(name, Content::Bytes(bytes));
    }
}

/// As [`plant`], for an encoder.
fn plant_encoder(parameters: &mut Parameters, firmware: &Firmware) {
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
