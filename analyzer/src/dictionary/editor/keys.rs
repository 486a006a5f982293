//! The fields of each kind of section, with their meanings by CiA 306.

use crate::dictionary::data_type::DataType;
use crate::dictionary::source::{Section, SectionName};

/// A field of a section.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// The name of the field.
    pub name: &'static str,
    /// The meaning of the field.
    pub meaning: &'static str,
    /// The allowed values, if there are few.
    pub values: &'static [&'static str],
}

const fn key(name: &'static str, meaning: &'static str) -> Key {
    Key { name, meaning, values: &[] }
}

const fn one_of(name: &'static str, meaning: &'static str, values: &'static [&'static str]) -> Key {
    Key { name, meaning, values }
}

const FLAG: &[&str] = &["0", "1"];

/// Fields of objects and entries.
const OBJECT: &[Key] = &[
    key("ParameterName", "The name of the object or entry."),
    one_of(
        "ObjectType",
        "The object code: 0x7 VAR, 0x8 ARRAY, 0x9 RECORD, 0x2 DOMAIN. Default: 0x7.",
        &["0x7", "0x8", "0x9", "0x2"],
    ),
    key("DataType", "The data type, by its index in the dictionary: 0x0005 UNSIGNED8, 0x0007 UNSIGNED32 and so on."),
    one_of(
        "AccessType",
        "The access type: ro, wo, rw, const; rwr can be mapped to a TPDO only, rww to an RPDO only.",
        &["ro", "wo", "rw", "rwr", "rww", "const"],
    ),
    key("DefaultValue", "The value after power-on with default parameters. $NODEID stands for the node-ID."),
    one_of("PDOMapping", "Whether the entry can be mapped to a PDO.", FLAG),
    key("LowLimit", "The lowest value that the device accepts."),
    key("HighLimit", "The highest value that the device accepts."),
    key("SubNumber", "The number of described sub-indexes; 0 or missing for a VAR."),
    key("CompactSubObj", "The number of sub-indexes of an array that are described together."),
    key(
        "ObjFlags",
        "Bit 0: tools skip the entry when they download all parameters. Bit 1: tools skip it when they read all.",
    ),
    key("ParameterValue", "The configured value, in a DCF."),
    key("Denotation", "The name of the object in this network, in a DCF."),
];

const DEVICE_INFO: &[Key] = &[
    key("VendorName", "The name of the manufacturer."),
    key("VendorNumber", "The vendor-ID: 1018h:01."),
    key("ProductName", "The name of the device."),
    key("ProductNumber", "The product code: 1018h:02."),
    key("RevisionNumber", "The revision number: 1018h:03."),
    key("OrderCode", "The order code."),
    one_of("BaudRate_10", "Whether the device supports 10 kbit/s.", FLAG),
    one_of("BaudRate_20", "Whether the device supports 20 kbit/s.", FLAG),
    one_of("BaudRate_50", "Whether the device supports 50 kbit/s.", FLAG),
    one_of("BaudRate_125", "Whether the device supports 125 kbit/s.", FLAG),
    one_of("BaudRate_250", "Whether the device supports 250 kbit/s.", FLAG),
    one_of("BaudRate_500", "Whether the device supports 500 kbit/s.", FLAG),
    one_of("BaudRate_800", "Whether the device supports 800 kbit/s.", FLAG),
    one_of("BaudRate_1000", "Whether the device supports 1 Mbit/s.", FLAG),
    one_of("SimpleBootUpMaster", "Whether the device can be the master of a simple boot-up.", FLAG),
    one_of("SimpleBootUpSlave", "Whether the device can be the slave of a simple boot-up.", FLAG),
    key("Granularity", "The smallest number of bits that can be mapped, 1 to 64; 0: the mapping is fixed."),
    one_of("DynamicChannelsSupported", "Whether the device creates objects at run time (CiA 302).", FLAG),
    one_of("GroupMessaging", "Whether the device has multiplexed PDOs.", FLAG),
    key("NrOfRXPDO", "The number of RPDOs."),
    key("NrOfTXPDO", "The number of TPDOs."),
    one_of("LSS_Supported", "Whether node-ID and bit rate can be set by LSS.", FLAG),
];

const FILE_INFO: &[Key] = &[
    key("FileName", "The name of the file, without folders."),
    key("FileVersion", "The version of the file, 0 to 255."),
    key("FileRevision", "The revision of the file, 0 to 255."),
    one_of("EDSVersion", "The version of CiA 306 that the file follows.", &["4.0"]),
    key("Description", "A description of the file."),
    key("CreationTime", "hh:mm(AM|PM), such as 01:30PM."),
    key("CreationDate", "mm-dd-yyyy, such as 11-21-2026."),
    key("CreatedBy", "The author of the file."),
    key("ModificationTime", "hh:mm(AM|PM), such as 01:30PM."),
    key("ModificationDate", "mm-dd-yyyy, such as 11-21-2026."),
    key("ModifiedBy", "The author of the last change."),
    key("LastEDS", "The EDS from which the DCF was made."),
];

const COMMISSIONING: &[Key] = &[
    key("NodeID", "The node-ID of the device in its network."),
    key("NodeName", "The name of the device in its network."),
    key("Baudrate", "The bit rate of the network in kbit/s."),
    key("NetNumber", "The number of the network."),
    key("NetworkName", "The name of the network."),
    one_of("CANopenManager", "Whether the device manages the network.", FLAG),
    key("LSS_SerialNumber", "The serial number of the device: 1018h:04."),
];

/// The fields that a section may have.
pub fn of(section: Section<'_>) -> &'static [Key] {
    match section.about() {
        SectionName::Object(_) | SectionName::Sub(..) => OBJECT,
        SectionName::FileInfo => FILE_INFO,
        SectionName::DeviceInfo => DEVICE_INFO,
        SectionName::DeviceCommissioning => COMMISSIONING,
        _ => &[],
    }
}

/// The data types that an entry can have, by index and name.
pub fn data_types() -> impl Iterator<Item = (u16, &'static str)> {
    (0x0001..=0x0025).filter_map(|index| DataType(index).name().map(|name| (index, name)))
}
