//! Faults and liberties in the content of the object dictionary, not in the behaviour of the firmware: an overlay over
//! the description.

use super::application;
use super::parameters::{Content, Parameters};
use crate::{Fault, Firmware};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;

/// The profile number of input and output modules. No device with the fault has this profile.
const ANOTHER_PROFILE: u64 = 401;

/// Changes the dictionary by the faults and liberties of the firmware.
pub(super) fn plant(parameters: &mut Parameters, firmware: &Firmware) {
    application::plant(parameters, firmware);
    let vendor_id = Multiplexer::new(object::IDENTITY, 1);
    let device_type = Multiplexer::new(object::DEVICE_TYPE, 0);
    if firmware.has(Fault::VendorIdZero) {
        parameters.redefine(vendor_id, Content::Number(0));
    }
    if firmware.has(Fault::DeviceTypeProfileWrong) {
        let other = parameters.number_or_zero(object::DEVICE_TYPE, 0) & 0xFFFF_0000 | ANOTHER_PROFILE;
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
    if firmware.has(Fault::SyncObjectMissing) {
        parameters.remove(object::COB_ID_SYNC, None);
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
