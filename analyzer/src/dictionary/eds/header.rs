//! `FileInfo`, `DeviceInfo`, `DummyUsage`, `Comments` and `DeviceComissioning`.

use super::fields::Fields;
use super::lexer::{Document, Section, canonical};
use crate::dictionary::description::{Commissioning, DeviceDescription, DeviceInfo, FileInfo};
use crate::dictionary::moment::{is_eds_date, is_eds_time};
use crate::dictionary::problem::{Place, Problems};
use crate::dictionary::rules::{self, Rule};
use crate::identity::NodeId;
use std::collections::BTreeMap;

pub(super) const FILE_INFO: [&str; 12] = [
    "filename",
    "fileversion",
    "filerevision",
    "edsversion",
    "description",
    "creationtime",
    "creationdate",
    "createdby",
    "modificationtime",
    "modificationdate",
    "modifiedby",
    "lasteds",
];

/// What every FileInfo has.
const EACH_FILE_INFO: [&str; 6] =
    ["FileName", "FileVersion", "FileRevision", "Description", "CreationDate", "CreatedBy"];

/// What every DeviceInfo has.
const EACH_DEVICE_INFO: [&str; 9] = [
    "VendorName",
    "VendorNumber",
    "ProductName",
    "ProductNumber",
    "RevisionNumber",
    "Granularity",
    "NrOfRXPDO",
    "NrOfTXPDO",
    "LSS_Supported",
];

/// The bit rates of CiA 301 in kbit/s.
pub(super) const BIT_RATES: [u16; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1000];

/// The node-ID of a device that has none (CiA 305).
const UNCONFIGURED: u32 = 255;

const DEVICE_INFO: [&str; 18] = [
    "vendorname",
    "vendornumber",
    "productname",
    "productnumber",
    "revisionnumber",
    "ordercode",
    "simplebootupmaster",
    "simplebootupslave",
    "granularity",
    "dynamicchannelssupported",
    "compactpdo",
    "groupmessaging",
    "nrofrxpdo",
    "nroftxpdo",
    "lss_supported",
    "canopensafetysupported",
    "extendedbootupmaster",
    "extendedbootupslave",
];

const COMMISSIONING: [&str; 9] = [
    "nodeid",
    "nodename",
    "noderefd",
    "baudrate",
    "netnumber",
    "networkname",
    "netrefd",
    "canopenmanager",
    "lss_serialnumber",
];

pub(super) fn file_info(section: &Section<'_>, problems: &mut Problems) -> FileInfo {
    let mut fields = Fields { section, problems };
    fields.check_known(|name| FILE_INFO.contains(&name));
    for field in ["CreationDate", "ModificationDate"] {
        check_form(&mut fields, field, is_eds_date, &rules::file::DATE, "a date as mm-dd-yyyy");
    }
    for field in ["CreationTime", "ModificationTime"] {
        check_form(&mut fields, field, is_eds_time, &rules::file::TIME, "a time as hh:mm(AM|PM)");
    }
    check_present(&mut fields, &EACH_FILE_INFO);
    let version = fields.optional_text("EDSVersion").unwrap_or("3.0");
    let major = version.split('.').next().unwrap_or_default();
    if !version.is_empty() && !matches!(major, "3" | "4") {
        fields.report("EDSVersion", &rules::file::VERSION, "3.0 or 4.0", version);
    }
    FileInfo {
        name: fields.text("FileName"),
        version: fields.text("FileVersion"),
        revision: fields.text("FileRevision"),
        eds_version: fields.optional_text("EDSVersion").unwrap_or("3.0").to_owned(),
        description: fields.text("Description"),
        created: (fields.text("CreationDate"), fields.text("CreationTime")),
        created_by: fields.text("CreatedBy"),
        modified: (fields.text("ModificationDate"), fields.text("ModificationTime")),
        modified_by: fields.text("ModifiedBy"),
        last_eds: fields.optional_text("LastEDS").map(str::to_owned),
    }
}

/// Reports fields that every such section has, and this one has not.
fn check_present(fields: &mut Fields<'_, '_>, names: &[&str]) {
    for name in names {
        if fields.optional_text(name).is_none() {
            fields.report(name, &rules::file::FIELD_MISSING, "this field", "none");
        }
    }
}

/// The standard writes `DeviceComissioning`, with one m.
pub(super) fn check_spelling(section: &Section<'_>, problems: &mut Problems) {
    if canonical(section.name) != "devicecomissioning" {
        let expected = "DeviceComissioning, with one m";
        problems.report(section.place(""), &rules::file::COMMISSIONING, expected, section.name);
    }
}

/// Only a DCF names the EDS that it was made from.
pub(super) fn check_last_eds(document: &Document<'_>, description: &DeviceDescription, problems: &mut Problems) {
    let Some(section) = document.section("FileInfo") else { return };
    if let (Some(last), false) = (&description.file.last_eds, description.is_configuration()) {
        problems.report(section.place("LastEDS"), &rules::file::LAST_EDS, "LastEDS in a DCF only", last);
    }
}

/// A field without a value is left to those who want no date.
fn check_form(
    fields: &mut Fields<'_, '_>,
    field: &str,
    is_right: fn(&str) -> bool,
    rule: &'static Rule,
    expected: &'static str,
) {
    let text = fields.optional_text(field).filter(|text| !text.is_empty());
    if let Some(text) = text.filter(|text| !is_right(text)) {
        fields.report(field, rule, expected, text);
    }
}

pub(super) fn device_info(section: &Section<'_>, problems: &mut Problems) -> DeviceInfo {
    let mut fields = Fields { section, problems };
    fields.check_known(is_device_info);
    check_present(&mut fields, &EACH_DEVICE_INFO);
    let mut bit_rates: Vec<u16> = Vec::new();
    for rate in BIT_RATES {
        if fields.flag(&format!("BaudRate_{rate}")) {
            bit_rates.push(rate);
        }
    }
    if bit_rates.is_empty() {
        let expected = "at least one bit rate";
        fields.report("", &rules::file::BIT_RATE_MISSING, expected, "no BaudRate_x=1");
    }
    DeviceInfo {
        vendor_name: fields.text("VendorName"),
        vendor_number: fields.number("VendorNumber", u32::MAX),
        product_name: fields.text("ProductName"),
        product_number: fields.number("ProductNumber", u32::MAX),
        revision_number: fields.number("RevisionNumber", u32::MAX),
        order_code: fields.text("OrderCode"),
        bit_rates,
        simple_boot_up_master: fields.flag("SimpleBootUpMaster"),
        simple_boot_up_slave: fields.flag("SimpleBootUpSlave"),
        granularity: fields.number("Granularity", 64).unwrap_or(0) as u8,
        dynamic_channels: fields.number("DynamicChannelsSupported", u32::MAX).unwrap_or(0) != 0,
        compact_pdo: fields.number("CompactPDO", 0xFF).unwrap_or(0) as u8,
        group_messaging: fields.flag("GroupMessaging"),
        rpdos: fields.number("NrOfRXPDO", 512).unwrap_or(0) as u16,
        tpdos: fields.number("NrOfTXPDO", 512).unwrap_or(0) as u16,
        lss_supported: fields.flag("LSS_Supported"),
    }
}

/// Whether `DeviceInfo` has a field of that name, in lower case.
pub(super) fn is_device_info(name: &str) -> bool {
    DEVICE_INFO.contains(&name) || bit_rate_of(name).is_some()
}

fn bit_rate_of(field: &str) -> Option<u16> {
    let rate = field.strip_prefix("baudrate_")?.parse().ok()?;
    BIT_RATES.contains(&rate).then_some(rate)
}

pub(super) fn commissioning(section: &Section<'_>, problems: &mut Problems) -> Commissioning {
    let mut fields = Fields { section, problems };
    fields.check_known(|name| COMMISSIONING.contains(&name));
    let number = fields.number("NodeID", u32::MAX);
    let node_id = number.and_then(|number| NodeId::new(u8::try_from(number).ok()?));
    if let (Some(number), None) = (number, node_id) {
        let found = number.to_string();
        let rule = if number == UNCONFIGURED { &rules::file::OPEN } else { &rules::file::NODE_ID };
        fields.report("NodeID", rule, "a node-ID from 1 to 127", &found);
    }
    let bit_rate = fields.number("Baudrate", u32::MAX);
    let known = bit_rate.and_then(|rate| u16::try_from(rate).ok()).filter(|rate| BIT_RATES.contains(rate));
    if let (Some(rate), None) = (bit_rate, known) {
        let expected = "a bit rate of CiA 301 in kbit/s";
        let rule = if rate == 0 { &rules::file::OPEN } else { &rules::file::BIT_RATE };
        fields.report("Baudrate", rule, expected, &rate.to_string());
    }
    Commissioning {
        node_id,
        node_name: fields.text("NodeName"),
        bit_rate: known,
        net_number: fields.number("NetNumber", u32::MAX),
        network_name: fields.text("NetworkName"),
        is_manager: fields.flag("CANopenManager"),
        lss_serial_number: fields.number("LSS_SerialNumber", u32::MAX),
    }
}

pub(super) fn dummy_usage(section: &Section<'_>, problems: &mut Problems) -> BTreeMap<u16, bool> {
    let mut dummies = BTreeMap::new();
    for field in &section.fields {
        let name = canonical(field.name);
        let digits = name.strip_prefix("dummy").filter(|digits| digits.len() == 4);
        let digits = digits.filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        // The four digits are the index of the data type.
        match digits.and_then(|digits| u16::from_str_radix(digits, 16).ok()) {
            Some(index) => {
                let usable = Fields { section, problems }.flag(field.name);
                dummies.insert(index, usable);
            }
            None => {
                let place = Place { line: field.line, section: section.name, field: field.name };
                let expected = "Dummy and the four digits of a data type";
                problems.report(place, &rules::file::DUMMY, expected, field.name);
            }
        }
    }
    dummies
}

/// The fields `Line1`, `Line2`… in the order of the file. `Lines` should be their number.
pub(super) fn comments(section: &Section<'_>, problems: &mut Problems) -> Vec<String> {
    let is_line = |name: &str| {
        let number = name.strip_prefix("line").unwrap_or_default();
        !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit())
    };
    let lines: Vec<String> = section
        .fields
        .iter()
        .filter(|field| is_line(&canonical(field.name)))
        .map(|field| field.value.to_owned())
        .collect();
    let mut fields = Fields { section, problems };
    fields.check_known(|name| name == "lines" || is_line(name));
    let announced = fields.number("Lines", u32::MAX).unwrap_or(0);
    if announced as usize != lines.len() {
        let found = format!("{} lines", lines.len());
        fields.report("Lines", &rules::file::COMMENT_COUNT, "the number of lines that follow", &found);
    }
    lines
}

/// Reports required sections that are missing.
pub(super) fn check_sections(document: &Document<'_>, problems: &mut Problems) {
    let required = [
        "FileInfo",
        "DeviceInfo",
        "DummyUsage",
        "Comments",
        "MandatoryObjects",
        "OptionalObjects",
        "ManufacturerObjects",
    ];
    for name in required {
        if document.section(name).is_none() {
            let place = Place { line: 0, section: name, field: "" };
            problems.report(place, &rules::section::MISSING, "a section of this name", "none");
        }
    }
}
