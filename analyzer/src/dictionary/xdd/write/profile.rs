//! Writes the two profiles of a file: the device profile and the communication profile.

use super::markup::Attributes;
use super::{Sheet, objects};
use crate::dictionary::description::{Commissioning, DeviceDescription, DeviceInfo, FileInfo};
use crate::dictionary::moment::{xml_date, xml_time};

/// Writes the identity and kind of the device.
pub(super) fn device(sheet: &mut Sheet, description: &DeviceDescription) {
    open(sheet, description, "Device", "ProfileBody_Device_CANopen");
    let device = &description.device;
    let number = |number: Option<u32>| number.map(|number| format!("0x{number:08X}"));
    let vendor = sheet.text(0, "[DeviceInfo] VendorName", &device.vendor_name);
    let product = sheet.text(0, "[DeviceInfo] ProductName", &device.product_name);
    let order = sheet.text(0, "[DeviceInfo] OrderCode", &device.order_code);
    let markup = &mut sheet.markup;
    markup.open("DeviceIdentity", &[]);
    markup.leaf("vendorName", &[], vendor.as_deref());
    markup.leaf("vendorID", &[], number(device.vendor_number).as_deref());
    markup.leaf("productName", &[], product.as_deref());
    markup.leaf("productID", &[], number(device.product_number).as_deref());
    markup.leaf("orderNumber", &[], order.as_deref());
    markup.close();
    close(sheet);
}

/// Writes the objects, and the device's capabilities on the bus.
pub(super) fn communication(sheet: &mut Sheet, description: &DeviceDescription) {
    open(sheet, description, "CommunicationNetwork", "ProfileBody_CommunicationNetwork_CANopen");
    sheet.markup.open("ApplicationLayers", &[]);
    sheet.markup.open("CANopenObjectList", &[]);
    for object in description.dictionary.objects() {
        objects::write(sheet, object);
    }
    sheet.markup.close();
    if !description.dummy_usage.is_empty() {
        sheet.markup.open("dummyUsage", &[]);
        for (index, usable) in &description.dummy_usage {
            let entry = format!("Dummy{index:04X}={}", u8::from(*usable));
            sheet.markup.empty("dummy", &[("entry", Some(entry))]);
        }
        sheet.markup.close();
    }
    sheet.markup.close();
    bit_rates(sheet, &description.device);
    management(sheet, description);
    close(sheet);
}

/// Writes the profile's header and the beginning of its body.
fn open(sheet: &mut Sheet, description: &DeviceDescription, class: &str, body: &str) {
    let file = &description.file;
    let markup = &mut sheet.markup;
    markup.open("ISO15745Profile", &[]);
    markup.open("ProfileHeader", &[]);
    markup.leaf("ProfileIdentification", &[], Some("CANopen device profile"));
    markup.leaf("ProfileRevision", &[], Some("1.0"));
    markup.leaf("ProfileName", &[], Some(""));
    markup.leaf("ProfileSource", &[], Some(""));
    markup.leaf("ProfileClassID", &[], Some(class));
    markup.open("ISO15745Reference", &[]);
    markup.leaf("ISO15745Part", &[], Some("1"));
    markup.leaf("ISO15745Edition", &[], Some("1"));
    markup.leaf("ProfileTechnology", &[], Some("CANopen"));
    markup.close();
    markup.close();
    // Both profiles have the same attributes; their losses are reported only once.
    let known = sheet.losses.0.len();
    let attributes = body_attributes(sheet, file, body);
    if class == "Device" {
        sheet.losses.0.truncate(known);
    }
    sheet.markup.open("ProfileBody", &attributes);
}

fn body_attributes(sheet: &mut Sheet, file: &FileInfo, body: &str) -> [(&'static str, Option<String>); 11] {
    let mut moment = |field: &str, text: &str, written: Option<String>| {
        if written.is_none() {
            sheet.losses.no_place(0, format!("[FileInfo] {field}"), text);
        }
        written
    };
    let created = moment("CreationDate", &file.created.0, xml_date(&file.created.0));
    let created_at = moment("CreationTime", &file.created.1, xml_time(&file.created.1));
    let modified = moment("ModificationDate", &file.modified.0, xml_date(&file.modified.0));
    let modified_at = moment("ModificationTime", &file.modified.1, xml_time(&file.modified.1));
    [
        ("xsi:type", Some(body.to_owned())),
        ("formatName", Some("CANopen".to_owned())),
        ("formatVersion", Some("1.0".to_owned())),
        ("fileName", sheet.text(0, "[FileInfo] FileName", &file.name)),
        ("fileCreator", sheet.text(0, "[FileInfo] CreatedBy", &file.created_by)),
        ("fileCreationDate", created),
        ("fileCreationTime", created_at),
        ("fileModificationDate", modified),
        ("fileModificationTime", modified_at),
        ("fileModifiedBy", sheet.text(0, "[FileInfo] ModifiedBy", &file.modified_by)),
        ("fileVersion", sheet.text(0, "[FileInfo] FileVersion", &file.version)),
    ]
}

fn close(sheet: &mut Sheet) {
    sheet.markup.close();
    sheet.markup.close();
}

fn bit_rates(sheet: &mut Sheet, device: &DeviceInfo) {
    if device.bit_rates.is_empty() {
        return;
    }
    for element in ["TransportLayers", "PhysicalLayer", "baudRate"] {
        sheet.markup.open(element, &[]);
    }
    for &rate in &device.bit_rates {
        sheet.markup.empty("supportedBaudRate", &[("value", Some(kbps(rate)))]);
    }
    for _ in 0..3 {
        sheet.markup.close();
    }
}

fn management(sheet: &mut Sheet, description: &DeviceDescription) {
    let device = &description.device;
    let flag = |flag: bool| Some(flag.to_string());
    let number = |number: u16| Some(number.to_string());
    sheet.markup.open("NetworkManagement", &[]);
    let general: Attributes<'_> = &[
        ("groupMessaging", flag(device.group_messaging)),
        ("dynamicChannels", number(device.dynamic_channels.into())),
        ("granularity", number(device.granularity.into())),
        ("nrOfRxPDO", number(device.rpdos)),
        ("nrOfTxPDO", number(device.tpdos)),
        ("bootUpSlave", flag(device.simple_boot_up_slave)),
        ("layerSettingServiceSlave", flag(device.lss_supported)),
    ];
    sheet.markup.empty("CANopenGeneralFeatures", general);
    sheet.markup.empty("CANopenMasterFeatures", &[("bootUpMaster", flag(device.simple_boot_up_master))]);
    if let Some(commissioning) = &description.commissioning {
        self::commissioning(sheet, commissioning);
    }
    sheet.markup.close();
}

fn commissioning(sheet: &mut Sheet, commissioning: &Commissioning) {
    let attributes = [
        ("NodeID", commissioning.node_id.map(|id| id.raw().to_string())),
        ("nodeName", sheet.text(0, "[DeviceComissioning] NodeName", &commissioning.node_name)),
        ("actualBaudRate", commissioning.bit_rate.map(kbps)),
        ("networkNumber", commissioning.net_number.map(|number| number.to_string())),
        ("networkName", sheet.text(0, "[DeviceComissioning] NetworkName", &commissioning.network_name)),
        ("CANopenManager", Some(commissioning.is_manager.to_string())),
    ];
    sheet.markup.empty("deviceCommissioning", &attributes);
}

fn kbps(rate: u16) -> String {
    format!("{rate} Kbps")
}
