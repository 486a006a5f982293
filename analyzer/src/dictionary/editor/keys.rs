//! The fields of each kind of section, with what CiA 306 says of them in our words.

use crate::dictionary::data_type::DataType;
use crate::dictionary::source::{Section, SectionName};

/// A field.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it says.
    pub meaning: &'static str,
    /// What it may be, where that is a short list.
    pub values: &'static [&'static str],
}

const fn key(name: &'static str, meaning: &'static str) -> Key {
    Key { name, meaning, values: &[] }
}

const fn one_of(name: &'static str, meaning: &'static str, values: &'static [&'static str]) -> Key {
    Key { name, meaning, values }
}

const FLAG: &[&str] = &["0", "1"];

/// Of objects and entries.
const OBJECT: &[Key] = &[
    key("ParameterName", "The name of the object or entry."),
    one_of(
        "ObjectType",
        "The object code: 0x7 VAR, 0x8 ARRAY, 0x9 RECORD, 0x2 DOMAIN. 0x7 without the field.",
        &["0x7", "0x8", "0x9", "0x2"],
    ),
    key("DataType", "The data type, by its index in the dictionary: 0x0005 UNSIGNED8, 0x0007 UNSIGNED32 and so on."),
    one_of(
        "AccessType",
        "How it can be reached: ro, wo, rw, const; rwr can be mapped to a TPDO only, rww to an RPDO only.",
        &["ro", "wo", "rw", "rwr", "rww", "const"],
    ),
    key("DefaultValue", "The value after power-on with default parameters. $NODEID stands for the node-ID."),
    one_of("PDOMapping", "Whether it can be mapped to a PDO.", FLAG),
    key("LowLimit", "The least value that the device takes."),
    key("HighLimit", "The greatest value that the device takes."),
    key("SubNumber", "How many sub-indexes are described. 0 or missing for a VAR."),
    key("CompactSubObj", "How many sub-indexes of an array there are that are described all at once."),
    key(
        "ObjFlags",
        "Bit 0: a tool does not write it with a download of all parameters. Bit 1: nor reads it with a scan.",
    ),
    key("ParameterValue", "The configured value, in a DCF."),
    key("Denotation", "What the object is called in this network, in a DCF."),
];

const DEVICE_INFO: &[Key] = &[
    key("VendorName", "The name of the manufacturer."),
    key("VendorNumber", "The vendor-ID: 1018h:01."),
    key("ProductName", "The name of the device."),
    key("ProductNumber", "The product code: 1018h:02."),
    key("RevisionNumber", "The revision number: 1018h:03."),
    key("OrderCode", "The order code."),
    one_of("BaudRate_10", "Whether the device knows 10 kbit/s.", FLAG),
    one_of("BaudRate_20", "Whether the device knows 20 kbit/s.", FLAG),
    one_of("BaudRate_50", "Whether the device knows 50 kbit/s.", FLAG),
    one_of("BaudRate_125", "Whether the device knows 125 kbit/s.", FLAG),
    one_of("BaudRate_250", "Whether the device knows 250 kbit/s.", FLAG),
    one_of("BaudRate_500", "Whether the device knows 500 kbit/s.", FLAG),
    one_of("BaudRate_800", "Whether the device knows 800 kbit/s.", FLAG),
    one_of("BaudRate_1000", "Whether the device knows 1 Mbit/s.", FLAG),
    one_of("SimpleBootUpMaster", "Whether it can be the master of a simple boot-up.", FLAG),
    one_of("SimpleBootUpSlave", "Whether it can be the slave of a simple boot-up.", FLAG),
    key("Granularity", "The least number of bits that can be mapped, 1 to 64; 0: the mapping is fixed."),
    one_of("DynamicChannelsSupported", "Whether objects are made at run time (CiA 302).", FLAG),
    one_of("GroupMessaging", "Whether it has multiplexed PDOs.", FLAG),
    key("NrOfRXPDO", "How many RPDOs there are."),
    key("NrOfTXPDO", "How many TPDOs there are."),
    one_of("LSS_Supported", "Whether node-ID and bit rate can be set by LSS.", FLAG),
];

const FILE_INFO: &[Key] = &[
    key("FileName", "The name of the file, without folders."),
    key("FileVersion", "The version of the file, 0 to 255."),
    key("FileRevision", "The revision of the file, 0 to 255."),
    one_of("EDSVersion", "The version of CiA 306 that the file keeps to.", &["4.0"]),
    key("Description", "What the file describes."),
    key("CreationTime", "hh:mm(AM|PM), such as 01:30PM."),
    key("CreationDate", "mm-dd-yyyy, such as 11-21-2026."),
    key("CreatedBy", "Who has made the file."),
    key("ModificationTime", "hh:mm(AM|PM), such as 01:30PM."),
    key("ModificationDate", "mm-dd-yyyy, such as 11-21-2026."),
    key("ModifiedBy", "Who has changed the file."),
    key("LastEDS", "The EDS that a DCF was made of."),
];

const COMMISSIONING: &[Key] = &[
    key("NodeID", "The node-ID of the device in its network."),
    key("NodeName", "What the device is called there."),
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
