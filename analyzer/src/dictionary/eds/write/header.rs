//! `FileInfo`, `DeviceInfo`, `DeviceComissioning`, `DummyUsage` and `Comments`.

use super::Sheet;
use crate::dictionary::description::{Commissioning, DeviceDescription, DeviceInfo, FileInfo};
use crate::dictionary::eds::header::BIT_RATES;
use crate::dictionary::loss::LossKind;
use crate::dictionary::moment::{eds_date, eds_time};
use crate::dictionary::object::Setting;
use crate::identity::Multiplexer;
use crate::object;

/// The data types that a file lists in `DummyUsage`.
const BASIC_TYPES: std::ops::RangeInclusive<u16> = 0x0001..=0x0007;

/// The version of CiA 306 of the written files.
const EDS_VERSION: &str = "4.0";
/// The largest number of PDOs of each direction.
const MOST_PDOS: u16 = 512;

pub(super) fn write(sheet: &mut Sheet, description: &DeviceDescription) {
    file_info(sheet, &description.file);
    device_info(sheet, description);
    // The section makes the file a DCF, which alone has configured values.
    let is_configured = || description.dictionary.entries().any(|(_, entry)| entry.configured.is_some());
    match &description.commissioning {
        Some(commissioning) => self::commissioning(sheet, commissioning),
        None if is_configured() => self::commissioning(sheet, &Commissioning::default()),
        None => {}
    }
    sheet.section("DummyUsage");
    // Some readers fail if one of the types from BOOLEAN to UNSIGNED32 is missing.
    let others = description.dummy_usage.keys().copied().filter(|index| !BASIC_TYPES.contains(index));
    for index in BASIC_TYPES.chain(others) {
        let is_usable = description.dummy_usage.get(&index) == Some(&true);
        sheet.flag(&format!("Dummy{index:04X}"), is_usable);
    }
    sheet.section("Comments");
    sheet.field("Lines", &description.comments.len().to_string());
    for (number, line) in (1..).zip(&description.comments) {
        sheet.text(&format!("Line{}", u32::to_string(&number)), line, 0);
    }
}

fn file_info(sheet: &mut Sheet, file: &FileInfo) {
    sheet.section("FileInfo");
    let moment = |(date, time): &(String, String)| {
        (eds_date(date).unwrap_or_else(|| date.clone()), eds_time(time).unwrap_or_else(|| time.clone()))
    };
    let (created, modified) = (moment(&file.created), moment(&file.modified));
    let fields = [
        ("FileName", &file.name),
        ("FileVersion", &file.version),
        ("FileRevision", &file.revision),
        ("EDSVersion", &EDS_VERSION.to_owned()),
        ("Description", &file.description),
        ("CreationTime", &created.1),
        ("CreationDate", &created.0),
        ("CreatedBy", &file.created_by),
        ("ModificationTime", &modified.1),
        ("ModificationDate", &modified.0),
        ("ModifiedBy", &file.modified_by),
    ];
    for (name, text) in fields {
        sheet.text(name, text, 0);
    }
    if let Some(last) = &file.last_eds {
        sheet.text("LastEDS", last, 0);
    }
}

fn device_info(sheet: &mut Sheet, description: &DeviceDescription) {
    let device = &description.device;
    sheet.section("DeviceInfo");
    // By CiA 306 the numbers are the defaults of 1018h; a description in XML may have them only there.
    let or_identity = |number: Option<u32>, sub| number.or_else(|| identity(description, sub));
    sheet.text("VendorName", &device.vendor_name, 0);
    sheet.code("VendorNumber", or_identity(device.vendor_number, 1));
    sheet.text("ProductName", &device.product_name, 0);
    sheet.code("ProductNumber", or_identity(device.product_number, 2));
    sheet.code("RevisionNumber", or_identity(device.revision_number, 3));
    sheet.text("OrderCode", &device.order_code, 0);
    bit_rates(sheet, device);
    sheet.flag("SimpleBootUpMaster", device.simple_boot_up_master);
    sheet.flag("SimpleBootUpSlave", device.simple_boot_up_slave);
    sheet.number("Granularity", device.granularity);
    sheet.flag("DynamicChannelsSupported", device.dynamic_channels);
    if device.compact_pdo != 0 {
        sheet.number("CompactPDO", device.compact_pdo);
    }
    sheet.flag("GroupMessaging", device.group_messaging);
    for (name, pdos) in [("NrOfRXPDO", device.rpdos), ("NrOfTXPDO", device.tpdos)] {
        let written = pdos.min(MOST_PDOS);
        if written != pdos {
            let place = format!("[DeviceInfo] {name}");
            sheet.losses.add(0, place, &pdos.to_string(), LossKind::Changed(written.to_string()));
        }
        sheet.number(name, written);
    }
    sheet.flag("LSS_Supported", device.lss_supported);
}

fn bit_rates(sheet: &mut Sheet, device: &DeviceInfo) {
    for rate in BIT_RATES {
        sheet.flag(&format!("BaudRate_{rate}"), device.bit_rates.contains(&rate));
    }
    for rate in device.bit_rates.iter().filter(|rate| !BIT_RATES.contains(rate)) {
        sheet.losses.no_place(0, "a bit rate in kbit/s", &rate.to_string());
    }
}

fn identity(description: &DeviceDescription, sub: u8) -> Option<u32> {
    let entry = description.dictionary.entry(Multiplexer::new(object::IDENTITY, sub)).ok()?;
    u32::try_from(entry.default.as_ref().and_then(Setting::fixed)?.to_raw()?).ok()
}

fn commissioning(sheet: &mut Sheet, commissioning: &Commissioning) {
    // The spelling of CiA 306, with one m.
    sheet.section("DeviceComissioning");
    if let Some(id) = commissioning.node_id {
        sheet.number("NodeID", id.raw());
    }
    sheet.text("NodeName", &commissioning.node_name, 0);
    if let Some(rate) = commissioning.bit_rate {
        if BIT_RATES.contains(&rate) {
            sheet.number("Baudrate", rate);
        } else {
            sheet.losses.no_place(0, "the bit rate of the node", &rate.to_string());
        }
    }
    if let Some(number) = commissioning.net_number {
        sheet.number("NetNumber", number);
    }
    sheet.text("NetworkName", &commissioning.network_name, 0);
    sheet.flag("CANopenManager", commissioning.is_manager);
    sheet.code("LSS_SerialNumber", commissioning.lss_serial_number);
}
