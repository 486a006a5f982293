//! Objects: `[1018]` with `[1018sub0]`, `[1018sub1]`…

use crate::object;
use std::collections::{BTreeMap, btree_map};

use super::compact;
use super::fields::Fields;
use crate::dictionary::data_type::DataType;
use crate::dictionary::limits;
use crate::dictionary::object::{Access, Entry, Object, ObjectCode, ObjectDictionary, ObjectFlags, Setting};
use crate::dictionary::place::Place;
use crate::dictionary::problem::Problems;
use crate::dictionary::rules;
use crate::dictionary::source::{FieldName, Section, SectionName, Source, canonical};
use crate::identity::SubIndex;

/// Limit of the entries in a description: `CompactSubObj` lets a small file request very many.
const MOST_ENTRIES: usize = 200_000;

const NAMES: limits::Names =
    limits::Names { low: "LowLimit", high: "HighLimit", default: "DefaultValue", configured: "ParameterValue" };

/// Whether an entry may have that field.
pub(super) const fn is_entry_field(field: FieldName) -> bool {
    is_kept(field) || matches!(field, FieldName::UploadFile | FieldName::DownloadFile | FieldName::ParamRefd)
}

/// Whether an object may have that field.
const fn is_object_field(field: FieldName) -> bool {
    is_entry_field(field) || matches!(field, FieldName::SubNumber | FieldName::CompactSubObj)
}

/// Whether a [`DeviceDescription`] keeps that field of an entry.
pub(super) const fn is_kept(field: FieldName) -> bool {
    matches!(
        field,
        FieldName::ParameterName
            | FieldName::ObjectType
            | FieldName::DataType
            | FieldName::AccessType
            | FieldName::PdoMapping
            | FieldName::DefaultValue
            | FieldName::LowLimit
            | FieldName::HighLimit
            | FieldName::ObjFlags
            | FieldName::ParameterValue
            | FieldName::Denotation
    )
}

/// The sections of one object.
#[derive(Default)]
pub(super) struct Parts<'d> {
    pub head: Option<Section<'d>>,
    pub subs: BTreeMap<u8, Section<'d>>,
}

/// All objects of the source.
pub(super) fn read(source: &Source<'_>, problems: &mut Problems) -> ObjectDictionary {
    let mut parts: BTreeMap<u16, Parts<'_>> = BTreeMap::new();
    for section in source.sections() {
        match section.about() {
            SectionName::Object(index) => {
                check_spelling(section, problems);
                add_head(parts.entry(index).or_default(), section, problems);
            }
            SectionName::Sub(index, sub) => {
                check_spelling(section, problems);
                add_sub(parts.entry(index).or_default(), sub, section, problems);
            }
            SectionName::Beside(_) if canonical(section.name()).starts_with("0x") => {
                report_spelling(section, problems);
            }
            _ => {}
        }
    }
    let mut configured = Vec::new();
    let mut left = MOST_ENTRIES;
    let mut objects = Vec::new();
    for (index, parts) in parts {
        let mut object = object(index, &parts, source, problems);
        if source.is_eds() {
            configured.extend(take_configured(&mut object, &parts));
        }
        let Some(rest) = left.checked_sub(object.entries().len()) else {
            let expected = "at most 200000 entries; the rest is left out";
            problems.report(Place::line(object.line), &rules::text::TOO_MUCH, expected, &object.index.to_string());
            break;
        };
        left = rest;
        objects.push(object);
    }
    if let Some((place, value)) = configured.first() {
        let expected = "DefaultValue in an EDS, or a section DeviceComissioning, which makes it a DCF";
        let found = match configured.len() {
            1 => value.to_string(),
            several => format!("{several} values, the first is {value}"),
        };
        problems.report(*place, &rules::field::CONFIGURED, expected, &found);
    }
    objects.into_iter().collect()
}

/// Removes the configured values of an object, which an EDS does not have; returns them with their places.
fn take_configured<'d>(object: &mut Object, parts: &Parts<'d>) -> Vec<(Place<'d>, Setting)> {
    let subs: Vec<SubIndex> = object.entries().iter().map(|entry| entry.sub).collect();
    let take = |sub: SubIndex| {
        let value = object.entry_mut(sub)?.configured.take()?;
        let section = parts.subs.get(&sub.0).copied().or(parts.head)?;
        Some((section.place_of(FieldName::ParameterValue), value))
    };
    subs.into_iter().filter_map(take).collect()
}

/// Reports a section name such as `[0x1018]` or `[1018sub01]`, which other tools may not find.
fn check_spelling(section: Section<'_>, problems: &mut Problems) {
    if !section.is_standard() {
        report_spelling(section, problems);
    }
}

fn report_spelling(section: Section<'_>, problems: &mut Problems) {
    let expected = "hexadecimal digits without prefix or leading zeros, as in [1018sub1]";
    problems.report(section.place(), &rules::section::SPELLING, expected, section.name());
}

/// Adds an object's own section: `[1018]` and `[0x1018]` are the same object.
pub(super) fn add_head<'d>(parts: &mut Parts<'d>, section: Section<'d>, problems: &mut Problems) {
    if parts.head.is_some() {
        report_second(section, problems);
    } else {
        parts.head = Some(section);
    }
}

/// Adds an entry's section: `[1018sub1]` and `[1018sub01]` are the same entry.
pub(super) fn add_sub<'d>(parts: &mut Parts<'d>, sub: u8, section: Section<'d>, problems: &mut Problems) {
    match parts.subs.entry(sub) {
        btree_map::Entry::Occupied(_) => report_second(section, problems),
        btree_map::Entry::Vacant(vacant) => {
            vacant.insert(section);
        }
    }
}

fn report_second(section: Section<'_>, problems: &mut Problems) {
    let expected = "a section once; the first counts";
    problems.report(section.place(), &rules::section::TWICE, expected, section.name());
}

/// The object that these sections describe.
pub(super) fn object(index: u16, parts: &Parts<'_>, source: &Source<'_>, problems: &mut Problems) -> Object {
    let Some(head) = parts.head else { return headless(index, parts, problems) };
    let mut fields = Fields { section: head, problems };
    fields.check_known(|field| field.known().is_some_and(is_object_field));
    let mut code = object_code(&mut fields);
    let compact = fields.number(FieldName::CompactSubObj, 0xFE).unwrap_or(0) as u8;
    if !parts.subs.is_empty() && code.is_single() {
        let expected = "ObjectType 8 or 9 (ARRAY, RECORD) with sub-indexes";
        fields.report(FieldName::ObjectType, &rules::entry::SUBS_OF_VAR, expected, &code.to_string());
        code = ObjectCode::RECORD;
    }
    let mut object = Object::new(index, name(&mut fields), code);
    (object.line, object.section) = (head.line(), Some(head.id));
    object.expect_entries(parts.subs.len().max(1));
    if compact > 0 {
        let template = entry(&mut fields, 0, DataType(0));
        compact::expand(&mut object, &template, compact, source, problems);
    } else if parts.subs.is_empty() {
        if !code.is_single() {
            let expected = "sub-indexes of an ARRAY or RECORD";
            fields.report(FieldName::SubNumber, &rules::section::SUBS_MISSING, expected, "none");
        }
        if code.is_single() || head.field(FieldName::DataType).is_some() {
            let default_type = if code == ObjectCode::DOMAIN { DataType::DOMAIN } else { DataType(0) };
            object.insert(entry(&mut fields, 0, default_type));
        }
    }
    add_subs(&mut object, parts, problems);
    if compact == 0 {
        check_counts(&object, &mut Fields { section: head, problems }, parts);
    }
    object
}

/// Reports sub-indexes that are described without their object, and returns an object without a name for them.
fn headless(index: u16, parts: &Parts<'_>, problems: &mut Problems) -> Object {
    let mut object = Object::new(index, String::new(), ObjectCode::RECORD);
    if let Some((_, section)) = parts.subs.first_key_value() {
        (object.line, object.section) = (section.line(), Some(section.id));
        let expected = "a section of the object itself";
        problems.report(section.place(), &rules::section::HEAD_MISSING, expected, section.name());
    }
    add_subs(&mut object, parts, problems);
    object
}

fn add_subs(object: &mut Object, parts: &Parts<'_>, problems: &mut Problems) {
    for (&sub, &section) in &parts.subs {
        let mut fields = Fields { section, problems };
        fields.check_known(|field| field.known().is_some_and(is_entry_field));
        let code = object_code(&mut fields);
        // Many files leave out the name of sub-index 0.
        if sub != 0 || !fields.text(FieldName::ParameterName).is_empty() {
            name(&mut fields);
        }
        let entry = entry(&mut fields, sub, DataType(0));
        let is_domain = code == ObjectCode::DOMAIN && entry.data_type == DataType::DOMAIN;
        if code != ObjectCode::VAR && code.name().is_some() && !is_domain {
            let expected = "ObjectType 7 (VAR) of a sub-index";
            fields.report(FieldName::ObjectType, &rules::entry::SUB_OBJECT_TYPE, expected, &code.to_string());
        }
        object.insert(entry);
    }
}

pub(super) fn object_code(fields: &mut Fields<'_, '_>) -> ObjectCode {
    // CiA 306: the default of `ObjectType` is VAR.
    if fields.optional_text(FieldName::ObjectType).is_none() {
        fields.report(FieldName::ObjectType, &rules::field::OBJECT_TYPE_MISSING, "ObjectType=0x7 for a VAR", "none");
    }
    let code = ObjectCode(fields.number(FieldName::ObjectType, 0xFF).unwrap_or(7) as u8);
    if code.name().is_none() {
        let expected = "ObjectType 0, 2, 5, 6, 7, 8 or 9";
        fields.report(FieldName::ObjectType, &rules::entry::OBJECT_TYPE, expected, &code.0.to_string());
    }
    code
}

pub(super) fn name<'s>(fields: &mut Fields<'s, '_>) -> &'s str {
    let name = fields.text(FieldName::ParameterName);
    if name.is_empty() {
        fields.report(FieldName::ParameterName, &rules::field::NAME_MISSING, "a name", "none");
    } else if name.len() > 1 && name.starts_with('"') && name.ends_with('"') {
        fields.report(FieldName::ParameterName, &rules::field::NAME_QUOTED, "a name without quotes", name);
    } else if name.len() > 241 && name.chars().nth(241).is_some() {
        fields.report(FieldName::ParameterName, &rules::field::NAME_LONG, "at most 241 characters", name);
    }
    name
}

/// The entry that a section describes.
pub(super) fn entry(fields: &mut Fields<'_, '_>, sub: u8, default_type: DataType) -> Entry {
    let data_type = data_type(fields, default_type);
    let mut entry = Entry::new(sub, fields.text(FieldName::ParameterName), data_type, access(fields, data_type));
    (entry.line, entry.section) = (fields.section.line(), Some(fields.section.id));
    entry.pdo_mappable = fields.flag(FieldName::PdoMapping);
    entry.default = fields.setting(FieldName::DefaultValue, data_type);
    entry.low_limit = fields.setting(FieldName::LowLimit, data_type);
    entry.high_limit = fields.setting(FieldName::HighLimit, data_type);
    entry.configured = fields.setting(FieldName::ParameterValue, data_type);
    entry.denotation = fields.optional_text(FieldName::Denotation).filter(|text| !text.is_empty()).map(str::to_owned);
    entry.flags = ObjectFlags(fields.number(FieldName::ObjFlags, u32::MAX).unwrap_or(0));
    if entry.flags.0 > 3 {
        fields.report(FieldName::ObjFlags, &rules::entry::FLAGS, "0, 1, 2 or 3", &entry.flags.0.to_string());
    }
    if limits::is_all_ones(fields.optional_text(FieldName::HighLimit)) {
        limits::unwrap_high(&mut entry, place(fields.section, NAMES.high), fields.problems);
    }
    limits::check(&entry, &NAMES, |field| place(fields.section, field), fields.problems);
    entry
}

/// The place of a field of a section.
fn place<'s>(section: Section<'s>, name: &'static str) -> Place<'s> {
    FieldName::parse(name).map_or(section.place(), |field| section.place_of(field))
}

fn data_type(fields: &mut Fields<'_, '_>, default: DataType) -> DataType {
    let data_type = match fields.number(FieldName::DataType, 0xFFFF) {
        Some(index) => DataType(index as u16),
        None => default,
    };
    if data_type.0 == 0 {
        fields.report(FieldName::DataType, &rules::field::DATA_TYPE_MISSING, "a data type", "none");
    } else if data_type.name().is_none() && !matches!(data_type.0, 0x40..=0x25F) {
        let expected = "a data type of CiA 301, or 40h to 25Fh";
        fields.report(FieldName::DataType, &rules::entry::DATA_TYPE, expected, &data_type.to_string());
    }
    data_type
}

fn access(fields: &mut Fields<'_, '_>, data_type: DataType) -> Access {
    let text = fields.optional_text(FieldName::AccessType).unwrap_or_default();
    let text = text.split(';').next().unwrap_or_default().trim();
    if let Some(access) = Access::from_name(text) {
        return access;
    }
    let expected = "const, ro, wo, rw, rwr or rww";
    if text.is_empty() {
        // CiA 306: a domain may leave out the access type; its access is then rw.
        if data_type == DataType::DOMAIN {
            return Access::Rw;
        }
        fields.report(FieldName::AccessType, &rules::field::ACCESS_MISSING, expected, "none");
        return Access::Ro;
    }
    let (rule, access) = match access_of_habit(text) {
        Some(access) => (&rules::entry::ACCESS_FORM, access),
        None => (&rules::entry::ACCESS, Access::Ro),
    };
    fields.report(FieldName::AccessType, rule, expected, text);
    access
}

/// The access type that authors mean by a spelling which CiA 306 does not have.
pub(in crate::dictionary) fn access_of_habit(text: &str) -> Option<Access> {
    Some(match text.to_ascii_lowercase().as_str() {
        "r" | "read" | "readonly" => Access::Ro,
        "w" | "write" | "writeonly" => Access::Wo,
        "wr" | "r/w" | "readwrite" => Access::Rw,
        "constant" | "c" => Access::Const,
        _ => return None,
    })
}

/// Checks `SubNumber`, and the default of sub-index 0.
fn check_counts(object: &Object, fields: &mut Fields<'_, '_>, parts: &Parts<'_>) {
    let subs = parts.subs.len();
    let announced = fields.number(FieldName::SubNumber, 0xFF);
    if announced.unwrap_or(0) as usize != subs {
        let found = format!("{subs} sub-indexes");
        let expected = "SubNumber to be the number of sub-indexes";
        fields.report(FieldName::SubNumber, &rules::list::SUB_NUMBER, expected, &found);
    }
    if object.code.is_single() || subs == 0 {
        return;
    }
    let (Some(count), Some(section)) = (object.entry(SubIndex(0)), parts.subs.get(&0)) else {
        fields.report_section(&rules::section::SUB_0_MISSING, "sub-index 0", "none");
        return;
    };
    // Sub-index FFh describes the object's structure and is not counted.
    let highest = object.entries().iter().map(|entry| entry.sub.0).filter(|&sub| sub < 0xFF).max().unwrap_or(0);
    let default = count.default.as_ref().and_then(Setting::fixed).and_then(|value| value.as_number());
    // A writable sub-index 0 counts the entries in use, which may be fewer than the existing ones.
    if !count.access.is_writable() && default.is_some_and(|default| default != i128::from(highest)) {
        let place = section.place_of(FieldName::DefaultValue);
        let expected = "the highest sub-index in sub-index 0";
        let found = format!("{highest:02X}h is the highest");
        // Sub-index 0 of 1003h counts the current errors.
        if object.index.0 != object::PREDEFINED_ERROR_FIELD {
            fields.problems.report(place, &rules::list::HIGHEST, expected, &found);
        }
    }
}
