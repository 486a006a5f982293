//! CiA 302, additional application layer functions, 1F00h to 1FFFh: SDO manager, configuration manager, program
//! download, network management, multiplex PDOs.

use super::{StandardObject, object, var};

const STANDARD: &str = "CiA 302";

pub(super) static OBJECTS: &[StandardObject] = &[
    var!(0x1F00, "Request SDO", UNSIGNED32, Wo),
    var!(0x1F01, "Release SDO", UNSIGNED32, Wo),
    object!(0x1F02, "SDO manager COB-IDs", ARRAY, [1 => 254, "COB-ID", UNSIGNED32, Rw]),
    object!(0x1F20, "Store DCF", ARRAY, [1 => 127, "Store DCF of node", DOMAIN, Rw]),
    object!(0x1F21, "Storage format", ARRAY, [1 => 127, "Storage format of node", UNSIGNED8, Rw]),
    object!(0x1F22, "Concise DCF", ARRAY, [1 => 127, "Concise DCF of node", DOMAIN, Rw]),
    object!(0x1F23, "Store EDS NMT slave", ARRAY, [1 => 127, "Store EDS of node", DOMAIN, Rw]),
    object!(0x1F24, "Storage format EDS NMT slave", ARRAY, [1 => 127, "Storage format of node", UNSIGNED8, Rw]),
    object!(0x1F25, "Configuration request", ARRAY, [1 => 128, "Configuration request of node", UNSIGNED32, Wo]),
    object!(0x1F26, "Expected configuration date", ARRAY, [1 => 127, "Expected date of node", UNSIGNED32, Rw]),
    object!(0x1F27, "Expected configuration time", ARRAY, [1 => 127, "Expected time of node", UNSIGNED32, Rw]),
    object!(0x1F50, "Program data", ARRAY, [1 => 254, "Program number", DOMAIN, Rw]),
    object!(0x1F51, "Program control", ARRAY, [1 => 254, "Program number", UNSIGNED8, Rw]),
    object!(0x1F52, "Verify application software", ARRAY, [
        1, "Application software date", UNSIGNED32, Rw;
        2, "Application software time", UNSIGNED32, Rw]),
    object!(0x1F53, "Expected application software date", ARRAY, [1 => 127, "Expected date of node", UNSIGNED32, Rw]),
    object!(0x1F54, "Expected application software time", ARRAY, [1 => 127, "Expected time of node", UNSIGNED32, Rw]),
    object!(0x1F55, "Expected software identification", ARRAY, [
        1 => 127, "Expected identification of node", UNSIGNED32, Rw]),
    object!(0x1F56, "Program software identification", ARRAY, [1 => 254, "Program number", UNSIGNED32, Ro]),
    object!(0x1F57, "Flash status identification", ARRAY, [1 => 254, "Program number", UNSIGNED32, Ro]),
    var!(0x1F80, "NMT startup", UNSIGNED32, Rw),
    object!(0x1F81, "NMT slave assignment", ARRAY, [1 => 127, "Assignment of node", UNSIGNED32, Rw]),
    object!(0x1F82, "Request NMT", ARRAY, [1 => 128, "Request NMT service of node", UNSIGNED8, Rw]),
    object!(0x1F83, "Request node guarding", ARRAY, [1 => 128, "Request guarding of node", UNSIGNED8, Rw]),
    object!(0x1F84, "Device type identification", ARRAY, [1 => 127, "Device type of node", UNSIGNED32, Rw]),
    object!(0x1F85, "Vendor identification", ARRAY, [1 => 127, "Vendor-ID of node", UNSIGNED32, Rw]),
    object!(0x1F86, "Product code", ARRAY, [1 => 127, "Product code of node", UNSIGNED32, Rw]),
    object!(0x1F87, "Revision number", ARRAY, [1 => 127, "Revision number of node", UNSIGNED32, Rw]),
    object!(0x1F88, "Serial number", ARRAY, [1 => 127, "Serial number of node", UNSIGNED32, Rw]),
    var!(0x1F89, "Boot time", UNSIGNED32, Rw),
    object!(0x1F8A, "Restore configuration", ARRAY, [1 => 127, "Restore configuration of node", UNSIGNED8, Rw]),
    object!(0x1F90, "NMT flying master timing parameter", ARRAY, [
        1, "NMT master timeout", UNSIGNED16, Rw;
        2, "NMT master negotiation time delay", UNSIGNED16, Rw;
        3, "NMT master priority", UNSIGNED16, Rw;
        4, "Priority time slot", UNSIGNED16, Rw;
        5, "CANopen device time slot", UNSIGNED16, Rw;
        6, "Multiple NMT master detect cycle time", UNSIGNED16, Rw]),
    object!(0x1FA0 => 0x1FCF, "Object scanner list", ARRAY, [1 => 254, "Scan", UNSIGNED32, Rw]),
    object!(0x1FD0 => 0x1FFF, "Object dispatching list", ARRAY, [1 => 254, "Dispatch", UNSIGNED64, Rw]),
];
