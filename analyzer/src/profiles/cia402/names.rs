//! The usual objects of drives, 6000h to 67FFh, with their types.
//!
//! Sources: the object tables in the manuals of Faulhaber MC 5010 and Novanta (drives.novantamotion.com), and the
//! device descriptions of these drives.

use crate::dictionary::names::{StandardObject, object, var};

pub(super) const STANDARD: &str = "CiA 402";

pub(super) static OBJECTS: &[StandardObject] = &[
    var!(0x603F, "Error code", UNSIGNED16, Ro),
    var!(0x6040, "Controlword", UNSIGNED16, Rw),
    var!(0x6041, "Statusword", UNSIGNED16, Ro),
    var!(0x6042, "vl target velocity", INTEGER16, Rw),
    var!(0x6043, "vl velocity demand", INTEGER16, Ro),
    var!(0x6044, "vl velocity actual value", INTEGER16, Ro),
    var!(0x605A, "Quick stop option code", INTEGER16, Rw),
    var!(0x605B, "Shutdown option code", INTEGER16, Rw),
    var!(0x605C, "Disable operation option code", INTEGER16, Rw),
    var!(0x605D, "Halt option code", INTEGER16, Rw),
    var!(0x605E, "Fault reaction option code", INTEGER16, Rw),
    var!(0x6060, "Modes of operation", INTEGER8, Rw),
    var!(0x6061, "Modes of operation display", INTEGER8, Ro),
    var!(0x6062, "Position demand value", INTEGER32, Ro),
    var!(0x6063, "Position actual internal value", INTEGER32, Ro),
    var!(0x6064, "Position actual value", INTEGER32, Ro),
    var!(0x6065, "Following error window", UNSIGNED32, Rw),
    var!(0x6066, "Following error time out", UNSIGNED16, Rw),
    var!(0x6067, "Position window", UNSIGNED32, Rw),
    var!(0x6068, "Position window time", UNSIGNED16, Rw),
    var!(0x6069, "Velocity sensor actual value", INTEGER32, Ro),
    var!(0x606B, "Velocity demand value", INTEGER32, Ro),
    var!(0x606C, "Velocity actual value", INTEGER32, Ro),
    var!(0x606D, "Velocity window", UNSIGNED16, Rw),
    var!(0x606E, "Velocity window time", UNSIGNED16, Rw),
    var!(0x606F, "Velocity threshold", UNSIGNED16, Rw),
    var!(0x6070, "Velocity threshold time", UNSIGNED16, Rw),
    var!(0x6071, "Target torque", INTEGER16, Rw),
    var!(0x6072, "Max torque", UNSIGNED16, Rw),
    var!(0x6073, "Max current", UNSIGNED16, Rw),
    var!(0x6074, "Torque demand", INTEGER16, Ro),
    var!(0x6075, "Motor rated current", UNSIGNED32, Rw),
    var!(0x6076, "Motor rated torque", UNSIGNED32, Rw),
    var!(0x6077, "Torque actual value", INTEGER16, Ro),
    var!(0x6078, "Current actual value", INTEGER16, Ro),
    var!(0x6079, "DC link circuit voltage", UNSIGNED32, Ro),
    var!(0x607A, "Target position", INTEGER32, Rw),
    object!(0x607B, "Position range limit", ARRAY, [
        1, "Min position range limit", INTEGER32, Rw;
        2, "Max position range limit", INTEGER32, Rw]),
    var!(0x607C, "Home offset", INTEGER32, Rw),
    object!(0x607D, "Software position limit", ARRAY, [
        1, "Min position limit", INTEGER32, Rw;
        2, "Max position limit", INTEGER32, Rw]),
    var!(0x607E, "Polarity", UNSIGNED8, Rw),
    var!(0x607F, "Max profile velocity", UNSIGNED32, Rw),
    var!(0x6080, "Max motor speed", UNSIGNED32, Rw),
    var!(0x6081, "Profile velocity", UNSIGNED32, Rw),
    var!(0x6082, "End velocity", UNSIGNED32, Rw),
    var!(0x6083, "Profile acceleration", UNSIGNED32, Rw),
    var!(0x6084, "Profile deceleration", UNSIGNED32, Rw),
    var!(0x6085, "Quick stop deceleration", UNSIGNED32, Rw),
    var!(0x6086, "Motion profile type", INTEGER16, Rw),
    var!(0x6087, "Torque slope", UNSIGNED32, Rw),
    object!(0x608F, "Position encoder resolution", ARRAY, [
        1, "Encoder increments", UNSIGNED32, Rw;
        2, "Motor revolutions", UNSIGNED32, Rw]),
    object!(0x6091, "Gear ratio", ARRAY, [
        1, "Motor revolutions", UNSIGNED32, Rw;
        2, "Shaft revolutions", UNSIGNED32, Rw]),
    object!(0x6092, "Feed constant", ARRAY, [
        1, "Feed", UNSIGNED32, Rw;
        2, "Shaft revolutions", UNSIGNED32, Rw]),
    var!(0x6098, "Homing method", INTEGER8, Rw),
    object!(0x6099, "Homing speeds", ARRAY, [
        1, "Speed during search for switch", UNSIGNED32, Rw;
        2, "Speed during search for zero", UNSIGNED32, Rw]),
    var!(0x609A, "Homing acceleration", UNSIGNED32, Rw),
    var!(0x60B0, "Position offset", INTEGER32, Rw),
    var!(0x60B1, "Velocity offset", INTEGER32, Rw),
    var!(0x60B2, "Torque offset", INTEGER16, Rw),
    var!(0x60B8, "Touch probe function", UNSIGNED16, Rw),
    var!(0x60B9, "Touch probe status", UNSIGNED16, Ro),
    var!(0x60C0, "Interpolation sub mode select", INTEGER16, Rw),
    // 60C1h, the set-points of the interpolation, has another type in each sub mode.
    object!(0x60C2, "Interpolation time period", RECORD, [
        1, "Interpolation time units", UNSIGNED8, Rw;
        2, "Interpolation time index", INTEGER8, Rw]),
    var!(0x60C5, "Max acceleration", UNSIGNED32, Rw),
    var!(0x60C6, "Max deceleration", UNSIGNED32, Rw),
    var!(0x60E0, "Positive torque limit value", UNSIGNED16, Rw),
    var!(0x60E1, "Negative torque limit value", UNSIGNED16, Rw),
    var!(0x60F4, "Following error actual value", INTEGER32, Ro),
    var!(0x60FA, "Control effort", INTEGER32, Ro),
    var!(0x60FC, "Position demand internal value", INTEGER32, Ro),
    var!(0x60FD, "Digital inputs", UNSIGNED32, Ro),
    object!(0x60FE, "Digital outputs", ARRAY, [
        1, "Physical outputs", UNSIGNED32, Rw;
        2, "Bit mask", UNSIGNED32, Rw]),
    var!(0x60FF, "Target velocity", INTEGER32, Rw),
    var!(0x6402, "Motor type", UNSIGNED16, Rw),
    var!(0x6502, "Supported drive modes", UNSIGNED32, Ro),
];
