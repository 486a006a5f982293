//! Device descriptions in XML: XDD for a type of device, XDC for one configured device (CiA 311).

mod objects;
mod parameters;
mod unkept;
mod write;

use crate::object;
pub(super) use unkept::unkept;
pub use write::write;

use std::collections::BTreeMap;

use super::description::{Commissioning, DeviceDescription, DeviceInfo, FileInfo, ObjectLists};
use super::rules;
use super::source::{DescriptionError, Format, Section, Source};
use crate::identity::NodeId;

/// Reads an XDD or XDC.
pub fn read(bytes: &[u8]) -> Result<DeviceDescription, DescriptionError> {
    describe(&Source::read_as(Format::Xml, bytes)?)
}

/// Describes the device in an XDD or XDC.
pub(super) fn describe(source: &Source<'_>) -> Result<DeviceDescription, DescriptionError> {
    let mut problems = source.problems();
    if source.named("CANopenObjectList").next().is_none() {
        if let Some(problem) = problems.first_of(&rules::xdd::MALFORMED) {
            return Err(DescriptionError::Malformed { line: problem.line, found: problem.found.clone() });
        }
        let root = source.named("ProfileBody").last().and_then(|body| body.attribute("type"));
        return Err(DescriptionError::NotCanopen { found: root.unwrap_or("none").to_owned() });
    }
    let parameters = parameters::read(source);
    let dictionary = objects::read(source, &parameters, &mut problems);
    let mut lists = ObjectLists::default();
    for object in dictionary.objects() {
        let list = match object.index.0 {
            object::DEVICE_TYPE | object::ERROR_REGISTER | object::IDENTITY => &mut lists.mandatory,
            0x2000..=0x5FFF => &mut lists.manufacturer,
            _ => &mut lists.optional,
        };
        list.push((object.index, object.line));
    }
    Ok(DeviceDescription {
        file: file_info(source),
        device: device_info(source),
        commissioning: source.named("deviceCommissioning").next().map(commissioning),
        dummy_usage: dummy_usage(source),
        dictionary,
        lists,
        problems: problems.into_sorted(),
        ..DeviceDescription::default()
    })
}

/// The data about the file, from the last profile body, which describes the communication.
fn file_info(source: &Source<'_>) -> FileInfo {
    let Some(body) = source.named("ProfileBody").last() else { return FileInfo::default() };
    let text = |name: &str| body.attribute(name).unwrap_or_default().to_owned();
    FileInfo {
        name: text("fileName"),
        version: text("fileVersion"),
        created: (text("fileCreationDate"), text("fileCreationTime")),
        created_by: text("fileCreator"),
        modified: (text("fileModificationDate"), text("fileModificationTime")),
        modified_by: text("fileModifiedBy"),
        ..FileInfo::default()
    }
}

fn device_info(source: &Source<'_>) -> DeviceInfo {
    let text = |name: &str| source.named(name).map(Section::text).find(|text| !text.is_empty()).unwrap_or_default();
    let feature = |element: &str, name: &str| {
        source.named(element).find_map(|element| element.attribute(name)).map(str::to_owned).unwrap_or_default()
    };
    let general = |name: &str| feature("CANopenGeneralFeatures", name);
    let number = |name: &str| general(name).parse().unwrap_or(0);
    let mut bit_rates: Vec<u16> =
        source.named("supportedBaudRate").filter_map(|element| kbit(element.attribute("value")?)).collect();
    bit_rates.sort_unstable();
    bit_rates.dedup();
    DeviceInfo {
        vendor_name: text("vendorName").to_owned(),
        vendor_number: decimal_or_hexadecimal(text("vendorID")),
        product_name: text("productName").to_owned(),
        product_number: decimal_or_hexadecimal(text("productID")),
        revision_number: None,
        order_code: text("orderNumber").to_owned(),
        bit_rates,
        simple_boot_up_master: is_true(&feature("CANopenMasterFeatures", "bootUpMaster")),
        simple_boot_up_slave: is_true(&general("bootUpSlave")),
        granularity: number("granularity").min(64) as u8,
        dynamic_channels: number("dynamicChannels") != 0,
        compact_pdo: 0,
        group_messaging: is_true(&general("groupMessaging")),
        rpdos: number("nrOfRxPDO"),
        tpdos: number("nrOfTxPDO"),
        lss_supported: is_true(&general("layerSettingServiceSlave")),
    }
}

fn commissioning(element: Section<'_>) -> Commissioning {
    let text = |name: &str| element.attribute(name).unwrap_or_default().to_owned();
    Commissioning {
        // The schema of CiA 311 names the attribute `NodeID`; other programs write `nodeID`.
        node_id: element
            .attribute("NodeID")
            .and_then(|number| NodeId::new(u8::try_from(decimal_or_hexadecimal(number)?).ok()?)),
        node_name: text("nodeName"),
        bit_rate: element.attribute("actualBaudRate").and_then(kbit),
        net_number: element.attribute("networkNumber").and_then(decimal_or_hexadecimal),
        network_name: text("networkName"),
        is_manager: is_true(&text("CANopenManager")),
        lss_serial_number: None,
    }
}

/// Reads the data types that may skip bits: `<dummy entry="Dummy0005=1"/>`.
fn dummy_usage(source: &Source<'_>) -> BTreeMap<u16, bool> {
    let entries = source.named("dummy").filter_map(|element| element.attribute("entry"));
    let dummies = entries.filter_map(|entry| {
        let (name, usable) = entry.split_once('=')?;
        let (dummy, index) = name.trim().split_at_checked("Dummy".len())?;
        if !dummy.eq_ignore_ascii_case("Dummy") {
            return None;
        }
        Some((u16::from_str_radix(index.trim(), 16).ok()?, usable.trim() == "1"))
    });
    dummies.collect()
}

/// Parses a bit rate such as `250 Kbps`, the schema's form; also `250`, `250kbps` and `1 Mbps`.
fn kbit(text: &str) -> Option<u16> {
    let end = text.find(|character: char| !character.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at_checked(end)?;
    let thousand = if unit.trim_start().starts_with(['M', 'm']) { 1000 } else { 1 };
    number.parse::<u16>().ok()?.checked_mul(thousand)
}

fn decimal_or_hexadecimal(text: &str) -> Option<u32> {
    match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u32::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

fn is_true(text: &str) -> bool {
    text.eq_ignore_ascii_case("true") || text == "1"
}
