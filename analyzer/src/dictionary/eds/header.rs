//! `FileInfo`, `DeviceInfo`, `DummyUsage`, `Comments` and `DeviceComissioning`.

use super::fields::{Fields, flag_in};
use crate::dictionary::description::{Commissioning, DeviceDescription, DeviceInfo, FileInfo};
use crate::dictionary::moment::{is_eds_date, is_eds_time};
use crate::dictionary::place::Place;
use crate::dictionary::problem::Problems;
use crate::dictionary::rules::{self, Rule};
use crate::dictionary::source::{Field, FieldName, Section, Source, canonical};
use crate::identity::NodeId;
use std::collections::BTreeMap;

pub(super) const FILE_INFO: [FieldName; 12] = [
    FieldName::FileName,
    FieldName::FileVersion,
    FieldName::FileRevision,
    FieldName::EdsVersion,
    FieldName::Description,
    FieldName::CreationTime,
    FieldName::CreationDate,
    FieldName::CreatedBy,
    FieldName::ModificationTime,
    FieldName::ModificationDate,
    FieldName::ModifiedBy,
    FieldName::LastEds,
];

/// The fields that every `FileInfo` must have.
const EACH_FILE_INFO: [FieldName; 6] = [
    FieldName::FileName,
    FieldName::FileVersion,
    FieldName::FileRevision,
    FieldName::Description,
    FieldName::CreationDate,
    FieldName::CreatedBy,
];

/// The fields that every `DeviceInfo` must have.
const EACH_DEVICE_INFO: [FieldName; 9] = [
    FieldName::VendorName,
    FieldName::VendorNumber,
    FieldName::ProductName,
    FieldName::ProductNumber,
    FieldName::RevisionNumber,
    FieldName::Granularity,
    FieldName::NrOfRxPdo,
    FieldName::NrOfTxPdo,
    FieldName::LssSupported,
];

/// The bit rates of CiA 301 in kbit/s.
pub(super) const BIT_RATES: [u16; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1000];

/// The fields for support of each bit rate.
const BIT_RATE_FIELDS: [FieldName; 9] = [
    FieldName::BaudRate10,
    FieldName::BaudRate20,
    FieldName::BaudRate50,
    FieldName::BaudRate100,
    FieldName::BaudRate125,
    FieldName::BaudRate250,
    FieldName::BaudRate500,
    FieldName::BaudRate800,
    FieldName::BaudRate1000,
];

/// The node-ID of an unconfigured device (CiA 305).
const UNCONFIGURED: u32 = 255;

const DEVICE_INFO: [FieldName; 18] = [
    FieldName::VendorName,
    FieldName::VendorNumber,
    FieldName::ProductName,
    FieldName::ProductNumber,
    FieldName::RevisionNumber,
    FieldName::OrderCode,
    FieldName::SimpleBootUpMaster,
    FieldName::SimpleBootUpSlave,
    FieldName::Granularity,
    FieldName::DynamicChannelsSupported,
    FieldName::CompactPdo,
    FieldName::GroupMessaging,
    FieldName::NrOfRxPdo,
    FieldName::NrOfTxPdo,
    FieldName::LssSupported,
    FieldName::CanopenSafetySupported,
    FieldName::ExtendedBootUpMaster,
    FieldName::ExtendedBootUpSlave,
];

const COMMISSIONING: [FieldName; 9] = [
    FieldName::NodeId,
    FieldName::NodeName,
    FieldName::NodeRefd,
    FieldName::Baudrate,
    FieldName::NetNumber,
    FieldName::NetworkName,
    FieldName::NetRefd,
    FieldName::CanopenManager,
    FieldName::LssSerialNumber,
];

pub(super) fn file_info(section: Section<'_>, problems: &mut Problems) -> FileInfo {
    let mut fields = Fields { section, problems };
    fields.check_known(|field| field.known().is_some_and(|field| FILE_INFO.contains(&field)));
    for field in [FieldName::CreationDate, FieldName::ModificationDate] {
        check_form(&mut fields, field, is_eds_date, &rules::file::DATE, "a date as mm-dd-yyyy");
    }
    for field in [FieldName::CreationTime, FieldName::ModificationTime] {
        check_form(&mut fields, field, is_eds_time, &rules::file::TIME, "a time as hh:mm(AM|PM)");
    }
    check_present(&mut fields, &EACH_FILE_INFO);
    let version = fields.optional_text(FieldName::EdsVersion).unwrap_or("3.0");
    let major = version.split('.').next().unwrap_or_default();
    if !version.is_empty() && !matches!(major, "3" | "4") {
        fields.report(FieldName::EdsVersion, &rules::file::VERSION, "3.0 or 4.0", version);
    }
    FileInfo {
        name: fields.text(FieldName::FileName).to_owned(),
        version: fields.text(FieldName::FileVersion).to_owned(),
        revision: fields.text(FieldName::FileRevision).to_owned(),
        eds_version: fields.optional_text(FieldName::EdsVersion).unwrap_or("3.0").to_owned(),
        description: fields.text(FieldName::Description).to_owned(),
        created: (fields.text(FieldName::CreationDate).to_owned(), fields.text(FieldName::CreationTime).to_owned()),
        created_by: fields.text(FieldName::CreatedBy).to_owned(),
        modified: (
            fields.text(FieldName::ModificationDate).to_owned(),
            fields.text(FieldName::ModificationTime).to_owned(),
        ),
        modified_by: fields.text(FieldName::ModifiedBy).to_owned(),
        last_eds: fields.optional_text(FieldName::LastEds).map(str::to_owned),
    }
}

/// Reports missing fields that every section of this kind must have.
fn check_present(fields: &mut Fields<'_, '_>, names: &[FieldName]) {
    for &name in names {
        if fields.optional_text(name).is_none() {
            fields.report(name, &rules::file::FIELD_MISSING, "this field", "none");
        }
    }
}

/// Checks the standard's spelling `DeviceComissioning`, with one m.
pub(super) fn check_spelling(section: Section<'_>, problems: &mut Problems) {
    if canonical(section.name()) != "devicecomissioning" {
        let expected = "DeviceComissioning, with one m";
        problems.report(section.place(), &rules::file::COMMISSIONING, expected, section.name());
    }
}

/// Reports `LastEDS` in an EDS: only a DCF names the EDS from which it was made.
pub(super) fn check_last_eds(source: &Source<'_>, description: &DeviceDescription, problems: &mut Problems) {
    let Some(section) = source.section("FileInfo") else { return };
    if let (Some(last), false) = (&description.file.last_eds, description.is_configuration()) {
        problems.report(section.place_of(FieldName::LastEds), &rules::file::LAST_EDS, "LastEDS in a DCF only", last);
    }
}

/// Checks the form of a date or time. An empty one is allowed.
fn check_form(
    fields: &mut Fields<'_, '_>,
    field: FieldName,
    is_right: fn(&str) -> bool,
    rule: &'static Rule,
    expected: &'static str,
) {
    let text = fields.optional_text(field).filter(|text| !text.is_empty());
    if let Some(text) = text.filter(|text| !is_right(text)) {
        fields.report(field, rule, expected, text);
    }
}

pub(super) fn device_info(section: Section<'_>, problems: &mut Problems) -> DeviceInfo {
    let mut fields = Fields { section, problems };
    fields.check_known(is_device_info);
    check_present(&mut fields, &EACH_DEVICE_INFO);
    let mut bit_rates: Vec<u16> = Vec::new();
    for (rate, field) in BIT_RATES.into_iter().zip(BIT_RATE_FIELDS) {
        if fields.flag(field) {
            bit_rates.push(rate);
        }
    }
    if bit_rates.is_empty() {
        let expected = "at least one bit rate";
        fields.report_section(&rules::file::BIT_RATE_MISSING, expected, "no BaudRate_x=1");
    }
    DeviceInfo {
        vendor_name: fields.text(FieldName::VendorName).to_owned(),
        vendor_number: fields.number(FieldName::VendorNumber, u32::MAX),
        product_name: fields.text(FieldName::ProductName).to_owned(),
        product_number: fields.number(FieldName::ProductNumber, u32::MAX),
        revision_number: fields.number(FieldName::RevisionNumber, u32::MAX),
        order_code: fields.text(FieldName::OrderCode).to_owned(),
        bit_rates,
        simple_boot_up_master: fields.flag(FieldName::SimpleBootUpMaster),
        simple_boot_up_slave: fields.flag(FieldName::SimpleBootUpSlave),
        granularity: fields.number(FieldName::Granularity, 64).unwrap_or(0) as u8,
        dynamic_channels: fields.number(FieldName::DynamicChannelsSupported, u32::MAX).unwrap_or(0) != 0,
        compact_pdo: fields.number(FieldName::CompactPdo, 0xFF).unwrap_or(0) as u8,
        group_messaging: fields.flag(FieldName::GroupMessaging),
        rpdos: fields.number(FieldName::NrOfRxPdo, 512).unwrap_or(0) as u16,
        tpdos: fields.number(FieldName::NrOfTxPdo, 512).unwrap_or(0) as u16,
        lss_supported: fields.flag(FieldName::LssSupported),
    }
}

/// Whether `DeviceInfo` has that field; bit rates are recognised also with leading zeros.
pub(super) fn is_device_info(field: Field<'_>) -> bool {
    match field.known() {
        Some(known) => DEVICE_INFO.contains(&known) || BIT_RATE_FIELDS.contains(&known),
        None => bit_rate_of(&canonical(field.name())).is_some(),
    }
}

fn bit_rate_of(field: &str) -> Option<u16> {
    let rate = field.strip_prefix("baudrate_")?.parse().ok()?;
    BIT_RATES.contains(&rate).then_some(rate)
}

pub(super) fn commissioning(section: Section<'_>, problems: &mut Problems) -> Commissioning {
    let mut fields = Fields { section, problems };
    fields.check_known(|field| field.known().is_some_and(|field| COMMISSIONING.contains(&field)));
    let number = fields.number(FieldName::NodeId, u32::MAX);
    let node_id = number.and_then(|number| NodeId::new(u8::try_from(number).ok()?));
    if let (Some(number), None) = (number, node_id) {
        let found = number.to_string();
        let rule = if number == UNCONFIGURED { &rules::file::OPEN } else { &rules::file::NODE_ID };
        fields.report(FieldName::NodeId, rule, "a node-ID from 1 to 127", &found);
    }
    let bit_rate = fields.number(FieldName::Baudrate, u32::MAX);
    let known = bit_rate.and_then(|rate| u16::try_from(rate).ok()).filter(|rate| BIT_RATES.contains(rate));
    if let (Some(rate), None) = (bit_rate, known) {
        let expected = "a bit rate of CiA 301 in kbit/s";
        let rule = if rate == 0 { &rules::file::OPEN } else { &rules::file::BIT_RATE };
        fields.report(FieldName::Baudrate, rule, expected, &rate.to_string());
    }
    Commissioning {
        node_id,
        node_name: fields.text(FieldName::NodeName).to_owned(),
        bit_rate: known,
        net_number: fields.number(FieldName::NetNumber, u32::MAX),
        network_name: fields.text(FieldName::NetworkName).to_owned(),
        is_manager: fields.flag(FieldName::CanopenManager),
        lss_serial_number: fields.number(FieldName::LssSerialNumber, u32::MAX),
    }
}

pub(super) fn dummy_usage(section: Section<'_>, problems: &mut Problems) -> BTreeMap<u16, bool> {
    let mut dummies = BTreeMap::new();
    for field in section.fields() {
        let name = canonical(field.name());
        let digits = name.strip_prefix("dummy").filter(|digits| digits.len() == 4);
        let digits = digits.filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        // The four digits of `Dummyxxxx` are the index of the data type.
        match digits.and_then(|digits| u16::from_str_radix(digits, 16).ok()) {
            Some(index) => {
                dummies.insert(index, flag_in(field.value(), field.place(), problems));
            }
            None => {
                let expected = "Dummy and the four digits of a data type";
                problems.report(field.place_of_name(), &rules::file::DUMMY, expected, field.name());
            }
        }
    }
    dummies
}

/// The texts of the fields `Line1`, `Line2`… in the order of the file. `Lines` should be their number.
pub(super) fn comments(section: Section<'_>, problems: &mut Problems) -> Vec<String> {
    let is_line = |field: Field<'_>| {
        let name = canonical(field.name());
        let number = name.strip_prefix("line").unwrap_or_default();
        !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit())
    };
    let lines = section.fields().filter(|field| is_line(*field)).map(|field| field.value().to_owned());
    let lines: Vec<String> = lines.collect();
    let mut fields = Fields { section, problems };
    fields.check_known(|field| field.known() == Some(FieldName::Lines) || is_line(field));
    let announced = fields.number(FieldName::Lines, u32::MAX).unwrap_or(0);
    if announced as usize != lines.len() {
        let found = format!("{} lines", lines.len());
        fields.report(FieldName::Lines, &rules::file::COMMENT_COUNT, "the number of lines that follow", &found);
    }
    lines
}

/// Reports required sections that are missing.
pub(super) fn check_sections(source: &Source<'_>, problems: &mut Problems) {
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
        if source.section(name).is_none() {
            let place = Place { section: name, ..Place::default() };
            problems.report(place, &rules::section::MISSING, "a section of this name", "none");
        }
    }
    for field in source.sections().flat_map(Section::fields) {
        if field.known().is_some() && field.name().contains(char::is_whitespace) {
            let expected = "the name of the field without blanks";
            problems.report(field.place_of_name(), &rules::field::BLANKS, expected, field.name());
        }
    }
}
