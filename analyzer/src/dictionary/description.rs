//! The content of a device description (EDS, DCF, XDD, XDC).

use super::object::{Object, ObjectDictionary};
use super::problem::EdsProblem;
use crate::identity::{Index, Multiplexer, NodeId};
use crate::object;
use std::collections::BTreeMap;

/// A device description, as far as it could be read. Its texts come from the file and may contain any characters.
#[derive(Clone, Debug, Default)]
pub struct DeviceDescription {
    /// Data about the file.
    pub file: FileInfo,
    /// Data about the device.
    pub device: DeviceInfo,
    /// Settings of a DCF or XDC for one device in one network.
    pub commissioning: Option<Commissioning>,
    /// The data types that an RPDO mapping may use to skip bits, by index: `DummyUsage`.
    pub dummy_usage: BTreeMap<u16, bool>,
    /// The lines of `Comments`.
    pub comments: Vec<String>,
    /// The objects.
    pub dictionary: ObjectDictionary,
    /// The file's lists of objects.
    pub lists: ObjectLists,
    /// The modules of a modular device.
    pub modules: Vec<Module>,
    /// The modules that a DCF plugs in, by their number in `modules`, in the order of the slots.
    pub connected_modules: Vec<u16>,
    /// The problems found, by line.
    pub problems: Vec<EdsProblem>,
}

/// `FileInfo`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileInfo {
    /// `FileName`.
    pub name: String,
    /// `FileVersion`.
    pub version: String,
    /// `FileRevision`.
    pub revision: String,
    /// `EDSVersion`: `3.0` if not given, as CiA 306 says.
    pub eds_version: String,
    /// `Description`.
    pub description: String,
    /// `CreationDate`, mm-dd-yyyy, and `CreationTime`, hh:mm(AM|PM).
    pub created: (String, String),
    /// `CreatedBy`.
    pub created_by: String,
    /// `ModificationDate` and `ModificationTime`.
    pub modified: (String, String),
    /// `ModifiedBy`.
    pub modified_by: String,
    /// `LastEDS` of a DCF: the file that it was made from.
    pub last_eds: Option<String>,
}

/// `DeviceInfo`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceInfo {
    /// `VendorName`.
    pub vendor_name: String,
    /// `VendorNumber`: 1018h:01.
    pub vendor_number: Option<u32>,
    /// `ProductName`.
    pub product_name: String,
    /// `ProductNumber`: 1018h:02.
    pub product_number: Option<u32>,
    /// `RevisionNumber`: 1018h:03.
    pub revision_number: Option<u32>,
    /// `OrderCode`.
    pub order_code: String,
    /// The bit rates that the device supports, in kbit/s, rising.
    pub bit_rates: Vec<u16>,
    /// `SimpleBootUpMaster`.
    pub simple_boot_up_master: bool,
    /// `SimpleBootUpSlave`.
    pub simple_boot_up_slave: bool,
    /// `Granularity`: the smallest number of bits that can be mapped, 0 if the mapping is fixed.
    pub granularity: u8,
    /// `DynamicChannelsSupported`.
    pub dynamic_channels: bool,
    /// `CompactPDO`: a mask of the sub-indexes that PDO communication parameters have, if the file does not describe
    /// them.
    pub compact_pdo: u8,
    /// `GroupMessaging`.
    pub group_messaging: bool,
    /// `NrOfRXPDO`.
    pub rpdos: u16,
    /// `NrOfTXPDO`.
    pub tpdos: u16,
    /// `LSS_Supported`.
    pub lss_supported: bool,
}

/// `DeviceComissioning` (the standard's spelling).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Commissioning {
    /// `NodeID`.
    pub node_id: Option<NodeId>,
    /// `NodeName`.
    pub node_name: String,
    /// `Baudrate`, in kbit/s.
    pub bit_rate: Option<u16>,
    /// `NetNumber`.
    pub net_number: Option<u32>,
    /// `NetworkName`.
    pub network_name: String,
    /// `CANopenManager`.
    pub is_manager: bool,
    /// `LSS_SerialNumber`.
    pub lss_serial_number: Option<u32>,
}

/// The lists of objects, each with the line of its entry.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObjectLists {
    /// `MandatoryObjects`.
    pub mandatory: Vec<(Index, u32)>,
    /// `OptionalObjects`.
    pub optional: Vec<(Index, u32)>,
    /// `ManufacturerObjects`.
    pub manufacturer: Vec<(Index, u32)>,
}

/// A module of a modular device (CiA 306, `SupportedModules`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Module {
    /// The number of the module in the file, from 1.
    pub number: u16,
    /// `ProductName`.
    pub product_name: String,
    /// `ProductVersion`.
    pub product_version: Option<u32>,
    /// `ProductRevision`.
    pub product_revision: Option<u32>,
    /// `OrderCode`.
    pub order_code: String,
    /// Objects that the device has once such a module is plugged in.
    pub fixed_objects: Vec<Object>,
    /// Sub-indexes that each such module adds.
    pub extensions: Vec<SubExtension>,
}

/// The extension of an object by a module (CiA 306, `MxSubExtxxxx`).
#[derive(Clone, Debug, PartialEq)]
pub struct SubExtension {
    /// The form of the new sub-indexes: one entry, whose sub-index has no meaning.
    pub template: Object,
    /// `Count`: the number of sub-indexes that each module adds; if modules share a sub-index, the number of bits.
    pub count: u32,
    /// `ObjExtend`: 0 = new sub-indexes of the same object; otherwise a full object is continued in further objects.
    pub object_extend: u32,
}

impl DeviceDescription {
    /// The number of the device profile: the low word of 1000h, 0 (none) included; `None` if 1000h has no default.
    pub fn device_profile(&self) -> Option<u16> {
        let device_type = self.dictionary.entry(Multiplexer::new(object::DEVICE_TYPE, 0)).ok()?;
        let value = device_type.configured.as_ref().or(device_type.default.as_ref())?.fixed()?.to_raw()?;
        Some((value & 0xFFFF) as u16)
    }

    /// Whether the description is of one configured device (DCF, XDC), not of a type of device (EDS, XDD).
    pub const fn is_configuration(&self) -> bool {
        self.commissioning.is_some()
    }
}
