//! CiA 406, encoders, 6000h to 67FFh, with the types of version 3.2. Later versions and linear devices have other types
//! in places: 6003h and 6004h INTEGER32, 6030h and 6040h INTEGER32.

use super::{StandardObject, object, var};

pub(super) static OBJECTS: &[StandardObject] = &[
    var!(0x6000, "Operating parameters", UNSIGNED16, Rw),
    var!(0x6001, "Measuring units per revolution", UNSIGNED32, Rw),
    var!(0x6002, "Total measuring range in measuring units", UNSIGNED32, Rw),
    var!(0x6003, "Preset value", UNSIGNED32, Rw),
    var!(0x6004, "Position value", UNSIGNED32, Ro),
    object!(0x6005, "Linear encoder measuring step settings", ARRAY, [
        1, "Position measuring step", UNSIGNED32, Rw;
        2, "Speed measuring step", UNSIGNED32, Rw;
        3, "Acceleration measuring step", UNSIGNED32, Rw;
        4, "Jerk measuring step", UNSIGNED32, Rw]),
    var!(0x6008, "High precision position value", UNSIGNED64, Ro),
    var!(0x6009, "High precision preset value", UNSIGNED64, Rw),
    var!(0x600B, "High resolution position raw value", UNSIGNED64, Ro),
    var!(0x600C, "Position raw value", UNSIGNED32, Ro),
    object!(0x6010, "Preset values for multi-sensor devices", ARRAY, [1 => 254, "Preset value channel", INTEGER32, Rw]),
    object!(0x6020, "Position values for multi-sensor devices", ARRAY, [
        1 => 254, "Position value channel", INTEGER32, Ro]),
    object!(0x6030, "Speed value", ARRAY, [1 => 254, "Speed value channel", INTEGER16, Ro]),
    object!(0x6031, "Speed parameter", ARRAY, [
        1, "Speed source selector", UNSIGNED16, Rw;
        2, "Speed integration time", UNSIGNED16, Rw;
        3, "Speed calculation multiplier", UNSIGNED16, Rw;
        4, "Speed calculation divisor", UNSIGNED16, Rw]),
    object!(0x6040, "Acceleration value", ARRAY, [1 => 254, "Acceleration value channel", INTEGER16, Ro]),
    object!(0x6041, "Acceleration parameter", ARRAY, [
        1, "Acceleration source selector", UNSIGNED16, Rw;
        2, "Acceleration integration time", UNSIGNED16, Rw;
        3, "Acceleration calculation multiplier", UNSIGNED16, Rw;
        4, "Acceleration calculation divisor", UNSIGNED16, Rw]),
    object!(0x6050, "Jerk value", ARRAY, [1 => 254, "Jerk value channel", INTEGER16, Ro]),
    var!(0x6200, "Cyclic timer", UNSIGNED16, Rw),
    object!(0x6300, "Cam state register", ARRAY, [1 => 254, "Cam state channel", UNSIGNED8, Ro]),
    object!(0x6301, "Cam enable register", ARRAY, [1 => 254, "Cam enable channel", UNSIGNED8, Rw]),
    object!(0x6302, "Cam polarity register", ARRAY, [1 => 254, "Cam polarity channel", UNSIGNED8, Rw]),
    object!(0x6310 => 0x6317, "Cam low limit", ARRAY, [1 => 254, "Cam low limit channel", INTEGER32, Rw]),
    object!(0x6320 => 0x6327, "Cam high limit", ARRAY, [1 => 254, "Cam high limit channel", INTEGER32, Rw]),
    object!(0x6330 => 0x6337, "Cam hysteresis", ARRAY, [1 => 254, "Cam hysteresis channel", UNSIGNED16, Rw]),
    object!(0x6400, "Area state register", ARRAY, [1 => 254, "Work area state channel", UNSIGNED8, Ro]),
    object!(0x6401, "Work area low limit", ARRAY, [1 => 254, "Work area low limit channel", INTEGER32, Rw]),
    object!(0x6402, "Work area high limit", ARRAY, [1 => 254, "Work area high limit channel", INTEGER32, Rw]),
    var!(0x6500, "Operating status", UNSIGNED16, Ro),
    // For a linear encoder the object is the measuring step.
    var!(0x6501, "Single-turn resolution", UNSIGNED32, Ro),
    var!(0x6502, "Number of distinguishable revolutions", UNSIGNED16, Ro),
    var!(0x6503, "Alarms", UNSIGNED16, Ro),
    var!(0x6504, "Supported alarms", UNSIGNED16, Ro),
    var!(0x6505, "Warnings", UNSIGNED16, Ro),
    var!(0x6506, "Supported warnings", UNSIGNED16, Ro),
    var!(0x6507, "Profile and software version", UNSIGNED32, Ro),
    var!(0x6508, "Operating time", UNSIGNED32, Ro),
    var!(0x6509, "Offset value", INTEGER32, Ro),
    object!(0x650A, "Module identification", ARRAY, [
        1, "Manufacturer offset value", INTEGER32, Ro;
        2, "Manufacturer minimum position value", INTEGER32, Ro;
        3, "Manufacturer maximum position value", INTEGER32, Ro]),
    var!(0x650B, "Serial number", UNSIGNED32, Ro),
    object!(0x650C, "Offset values for multi-sensor devices", ARRAY, [1 => 254, "Offset value channel", INTEGER32, Ro]),
    var!(0x650D, "Absolute accuracy", UNSIGNED8, Ro),
    var!(0x650E, "Device capability", UNSIGNED32, Ro),
];
