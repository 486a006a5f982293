//! The identity that a device reports.

use canvass_suite::runner::DeviceIdentity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The identity that a device reports. A member is `null` if the object was not read or does not exist.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Device {
    /// 1000h.
    pub device_type: Option<u32>,
    /// 1009h.
    pub hardware_version: Option<String>,
    /// 1008h.
    pub name: Option<String>,
    /// 1018h:02.
    pub product_code: Option<u32>,
    /// 1018h:03.
    pub revision_number: Option<u32>,
    /// 1018h:04.
    pub serial_number: Option<u32>,
    /// 100Ah.
    pub software_version: Option<String>,
    /// 1018h:01.
    pub vendor_id: Option<u32>,
}

impl From<&DeviceIdentity> for Device {
    fn from(DeviceIdentity { device_type, identity, names }: &DeviceIdentity) -> Self {
        let [vendor_id, product_code, revision_number, serial_number] = *identity;
        let [name, hardware_version, software_version] = names.clone();
        let device_type = *device_type;
        Self {
            device_type,
            hardware_version,
            name,
            product_code,
            revision_number,
            serial_number,
            software_version,
            vendor_id,
        }
    }
}

impl From<&Device> for DeviceIdentity {
    fn from(device: &Device) -> Self {
        let names = [&device.name, &device.hardware_version, &device.software_version];
        Self {
            device_type: device.device_type,
            identity: [device.vendor_id, device.product_code, device.revision_number, device.serial_number],
            names: names.map(Clone::clone),
        }
    }
}
