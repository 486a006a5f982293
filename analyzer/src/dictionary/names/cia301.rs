//! CiA 301, communication profile area, 1000h to 1EFFh; also the objects of versions before 4 that devices still have
//! (1004h, 100Bh, 100Eh, 100Fh), and the SRDO parameters of CiA 304 (EN 50325-5).

use super::{StandardObject, object, var};

const STANDARD: &str = "CiA 301";

/// The standard of the SRDO parameters.
const SAFETY: &str = "CiA 304";

pub(super) static OBJECTS: &[StandardObject] = &[
    var!(0x1000, "Device type", UNSIGNED32, Ro),
    var!(0x1001, "Error register", UNSIGNED8, Ro),
    var!(0x1002, "Manufacturer status register", UNSIGNED32, Ro),
    object!(0x1003, "Pre-defined error field", ARRAY, [all
        0, "Number of errors", UNSIGNED8, Rw;
        1 => 254, "Standard error field", UNSIGNED32, Ro]),
    object!(0x1004, "Number of PDOs supported", ARRAY, [all
        0, "Number of PDOs supported", UNSIGNED32, Ro;
        1, "Number of synchronous PDOs supported", UNSIGNED32, Ro;
        2, "Number of asynchronous PDOs supported", UNSIGNED32, Ro]),
    var!(0x1005, "COB-ID SYNC message", UNSIGNED32, Rw),
    var!(0x1006, "Communication cycle period", UNSIGNED32, Rw),
    var!(0x1007, "Synchronous window length", UNSIGNED32, Rw),
    var!(0x1008, "Manufacturer device name", VISIBLE_STRING, Ro),
    var!(0x1009, "Manufacturer hardware version", VISIBLE_STRING, Ro),
    var!(0x100A, "Manufacturer software version", VISIBLE_STRING, Ro),
    var!(0x100B, "Node-ID", UNSIGNED32, Ro),
    var!(0x100C, "Guard time", UNSIGNED16, Rw),
    var!(0x100D, "Life time factor", UNSIGNED8, Rw),
    var!(0x100E, "Node guarding identifier", UNSIGNED32, Rw),
    var!(0x100F, "Number of SDOs supported", UNSIGNED32, Ro),
    object!(0x1010, "Store parameters", ARRAY, [
        1, "Save all parameters", UNSIGNED32, Rw;
        2, "Save communication parameters", UNSIGNED32, Rw;
        3, "Save application parameters", UNSIGNED32, Rw;
        4 => 127, "Save manufacturer-defined parameters", UNSIGNED32, Rw]),
    object!(0x1011, "Restore default parameters", ARRAY, [
        1, "Restore all default parameters", UNSIGNED32, Rw;
        2, "Restore communication default parameters", UNSIGNED32, Rw;
        3, "Restore application default parameters", UNSIGNED32, Rw;
        4 => 127, "Restore manufacturer-defined default parameters", UNSIGNED32, Rw]),
    var!(0x1012, "COB-ID time stamp object", UNSIGNED32, Rw),
    var!(0x1013, "High resolution time stamp", UNSIGNED32, Rw),
    var!(0x1014, "COB-ID EMCY", UNSIGNED32, Rw),
    var!(0x1015, "Inhibit time EMCY", UNSIGNED16, Rw),
    object!(0x1016, "Consumer heartbeat time", ARRAY, [1 => 127, "Consumer heartbeat time", UNSIGNED32, Rw]),
    var!(0x1017, "Producer heartbeat time", UNSIGNED16, Rw),
    object!(0x1018, "Identity object", RECORD, [
        1, "Vendor-ID", UNSIGNED32, Ro;
        2, "Product code", UNSIGNED32, Ro;
        3, "Revision number", UNSIGNED32, Ro;
        4, "Serial number", UNSIGNED32, Ro]),
    var!(0x1019, "Synchronous counter overflow value", UNSIGNED8, Rw),
    object!(0x1020, "Verify configuration", ARRAY, [
        1, "Configuration date", UNSIGNED32, Rw;
        2, "Configuration time", UNSIGNED32, Rw]),
    var!(0x1021, "Store EDS", DOMAIN, Ro),
    var!(0x1022, "Store format", UNSIGNED8, Ro),
    object!(0x1023, "OS command", RECORD, [
        1, "Command", OCTET_STRING, Rw;
        2, "Status", UNSIGNED8, Ro;
        3, "Reply", OCTET_STRING, Ro]),
    var!(0x1024, "OS command mode", UNSIGNED8, Wo),
    object!(0x1025, "OS debugger interface", RECORD, [
        1, "Command", OCTET_STRING, Rw;
        2, "Status", UNSIGNED8, Ro;
        3, "Reply", OCTET_STRING, Ro]),
    object!(0x1026, "OS prompt", ARRAY, [
        1, "StdIn", UNSIGNED8, Wo;
        2, "StdOut", UNSIGNED8, Ro;
        3, "StdErr", UNSIGNED8, Ro]),
    object!(0x1027, "Module list", ARRAY, [1 => 254, "Module", UNSIGNED16, Ro]),
    object!(0x1028, "Emergency consumer object", ARRAY, [1 => 127, "Emergency consumer", UNSIGNED32, Rw]),
    object!(0x1029, "Error behaviour object", ARRAY, [
        1, "Communication error", UNSIGNED8, Rw;
        2 => 254, "Profile or manufacturer specific error", UNSIGNED8, Rw]),
    var!(0x102A, "NMT inhibit time", UNSIGNED16, Rw),
    object!(0x1200 => 0x127F, "SDO server parameter", RECORD, [
        1, "COB-ID client to server (rx)", UNSIGNED32, Rw;
        2, "COB-ID server to client (tx)", UNSIGNED32, Rw;
        3, "Node-ID of the SDO client", UNSIGNED8, Rw]),
    object!(0x1280 => 0x12FF, "SDO client parameter", RECORD, [
        1, "COB-ID client to server (tx)", UNSIGNED32, Rw;
        2, "COB-ID server to client (rx)", UNSIGNED32, Rw;
        3, "Node-ID of the SDO server", UNSIGNED8, Rw]),
    StandardObject { standard: SAFETY, ..var!(0x1300, "Global fail-safe command parameter", UNSIGNED8, Rw) },
    StandardObject {
        standard: SAFETY,
        ..object!(0x1301 => 0x1340, "SRDO communication parameter", RECORD, [
        1, "Information direction", UNSIGNED8, Rw;
        2, "Refresh time or safety cycle time", UNSIGNED16, Rw;
        3, "Safety relevant validation time", UNSIGNED8, Rw;
        4, "Transmission type", UNSIGNED8, Ro;
        5, "COB-ID 1", UNSIGNED32, Rw;
        6, "COB-ID 2", UNSIGNED32, Rw])
    },
    StandardObject {
        standard: SAFETY,
        ..object!(0x1381 => 0x13C0, "SRDO mapping parameter", ARRAY, [all
        0, "Number of mapped application objects in SRDO", UNSIGNED8, Rw;
        1 => 128, "Application object", UNSIGNED32, Rw])
    },
    StandardObject { standard: SAFETY, ..var!(0x13FE, "Configuration valid", UNSIGNED8, Rw) },
    StandardObject {
        standard: SAFETY,
        ..object!(0x13FF, "Safety configuration signature", ARRAY, [1 => 64, "SRDO signature", UNSIGNED16, Rw])
    },
    object!(0x1400 => 0x15FF, "RPDO communication parameter", RECORD, [
        1, "COB-ID used by RPDO", UNSIGNED32, Rw;
        2, "Transmission type", UNSIGNED8, Rw;
        3, "Inhibit time", UNSIGNED16, Rw;
        4, "Compatibility entry", UNSIGNED8, Rw;
        5, "Event timer", UNSIGNED16, Rw;
        6, "SYNC start value", UNSIGNED8, Rw]),
    object!(0x1600 => 0x17FF, "RPDO mapping parameter", RECORD, [all
        0, "Number of mapped application objects in PDO", UNSIGNED8, Rw;
        1 => 64, "Application object", UNSIGNED32, Rw]),
    object!(0x1800 => 0x19FF, "TPDO communication parameter", RECORD, [
        1, "COB-ID used by TPDO", UNSIGNED32, Rw;
        2, "Transmission type", UNSIGNED8, Rw;
        3, "Inhibit time", UNSIGNED16, Rw;
        4, "Reserved", UNSIGNED8, Rw;
        5, "Event timer", UNSIGNED16, Rw;
        6, "SYNC start value", UNSIGNED8, Rw]),
    object!(0x1A00 => 0x1BFF, "TPDO mapping parameter", RECORD, [all
        0, "Number of mapped application objects in TPDO", UNSIGNED8, Rw;
        1 => 64, "Application object", UNSIGNED32, Rw]),
];
