//! Parts of an EDS or DCF that a description does not keep.

use super::header;
use super::modules::INFO_FIELDS;
use super::objects::is_kept;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::loss::{Loss, Losses};
use crate::dictionary::object::{Entry, Object};
use crate::dictionary::source::{Field, FieldName, ModulePart, Section, SectionName, Source, canonical};
use crate::identity::{Index, SubIndex};

/// Whether a description keeps this field of an object with sub-indexes.
const fn is_head(field: FieldName) -> bool {
    matches!(field, FieldName::ParameterName | FieldName::ObjectType | FieldName::SubNumber | FieldName::CompactSubObj)
}

/// Whether that field of an entry holds a value of its data type.
const fn is_value(field: FieldName) -> bool {
    matches!(field, FieldName::DefaultValue | FieldName::LowLimit | FieldName::HighLimit | FieldName::ParameterValue)
}

/// The fields of `DeviceComissioning` that a description keeps.
const COMMISSIONING: [FieldName; 7] = [
    FieldName::NodeId,
    FieldName::NodeName,
    FieldName::Baudrate,
    FieldName::NetNumber,
    FieldName::NetworkName,
    FieldName::CanopenManager,
    FieldName::LssSerialNumber,
];
/// Fields of `DeviceInfo` that canvass knows but a description does not keep.
const UNKEPT_DEVICE_INFO: [FieldName; 3] =
    [FieldName::CanopenSafetySupported, FieldName::ExtendedBootUpMaster, FieldName::ExtendedBootUpSlave];

/// All parts of the file that the parsed description does not keep, by line.
pub(in crate::dictionary) fn unkept(description: &DeviceDescription, source: &Source<'_>) -> Vec<Loss> {
    let mut losses = Losses::default();
    losses.unread(&description.problems);
    let mut comments = source.comments();
    if let Some(first) = comments.next() {
        let line = source.position(first.range().start).0;
        losses.unkept(line, "a comment", source.get(first), 1 + comments.count());
    }
    for section in source.sections() {
        self::section(section, source, description, &mut losses);
    }
    losses.0.sort_by_key(|loss| loss.line);
    losses.0
}

fn section(section: Section<'_>, source: &Source<'_>, description: &DeviceDescription, losses: &mut Losses) {
    let each = |losses: &mut Losses, kept: &dyn Fn(FieldName) -> bool| {
        fields(section, losses, |field| field.known().is_some_and(kept));
    };
    match section.about() {
        SectionName::FileInfo => each(losses, &|field| header::FILE_INFO.contains(&field)),
        SectionName::DeviceInfo => {
            let is_unkept = |known: FieldName| UNKEPT_DEVICE_INFO.contains(&known);
            fields(section, losses, |field| header::is_device_info(field) && !field.known().is_some_and(is_unkept));
        }
        SectionName::DeviceCommissioning => each(losses, &|field| COMMISSIONING.contains(&field)),
        SectionName::Comments => fields(section, losses, |field| canonical(field.name()).starts_with("line")),
        SectionName::Object(index) => {
            let object = description.dictionary.object(Index(index));
            head(section, object, losses);
        }
        SectionName::Sub(index, sub) => {
            let object = description.dictionary.object(Index(index));
            entry(section, object.and_then(|object| object.entry(SubIndex(sub))), losses);
        }
        SectionName::Beside(index) => {
            // The reader uses sections such as `[1003Name]` only if their object has the short form (`CompactSubObj`).
            let head = source.section(&format!("{index:04X}"));
            let is_used = head.is_some_and(|head| head.field(FieldName::CompactSubObj).is_some())
                && !canonical(section.name()).ends_with("objectlinks");
            if !is_used {
                whole(section, losses);
            }
        }
        SectionName::Module(_, ModulePart::Info) => each(losses, &|field| INFO_FIELDS.contains(&field)),
        SectionName::Module(_, ModulePart::SubExtension(_)) => {
            each(losses, &|field| is_kept(field) || matches!(field, FieldName::Count | FieldName::ObjExtend));
        }
        SectionName::Module(_, ModulePart::Fixed(_) | ModulePart::FixedSub(..)) => {
            each(losses, &|field| is_kept(field) || is_head(field));
        }
        SectionName::DynamicChannels
        | SectionName::Tools
        | SectionName::Unknown
        | SectionName::Module(_, ModulePart::Comments) => whole(section, losses),
        // The sections of lists are written anew from the described objects; the content of the other sections is kept.
        SectionName::DummyUsage
        | SectionName::MandatoryObjects
        | SectionName::OptionalObjects
        | SectionName::ManufacturerObjects
        | SectionName::SupportedModules
        | SectionName::ConnectedModules
        | SectionName::Module(..) => {}
    }
}

/// Reports the fields of an object's section that a description does not keep. If the object has no sub-indexes, the
/// section also describes the object's entry.
fn head(section: Section<'_>, object: Option<&Object>, losses: &mut Losses) {
    match object {
        Some(object) if object.code.is_single() => entry(section, object.entries().first(), losses),
        Some(object) if section.field(FieldName::CompactSubObj).is_some() || object.entries().len() == 1 => {
            entry(section, object.entries().last(), losses);
        }
        _ => fields(section, losses, |field| field.known().is_some_and(is_head)),
    }
}

fn entry(section: Section<'_>, entry: Option<&Entry>, losses: &mut Losses) {
    let is_without_value = entry.is_some_and(|entry| entry.data_type.class().is_none());
    let is_kept = |field| (is_kept(field) || is_head(field)) && !(is_value(field) && is_without_value);
    fields(section, losses, |field| field.known().is_some_and(is_kept));
}

/// Reports the fields that are neither blank nor kept.
fn fields(section: Section<'_>, losses: &mut Losses, kept: impl Fn(Field<'_>) -> bool) {
    for field in section.fields() {
        if !field.value().is_empty() && !kept(field) {
            losses.unkept(field.line(), format!("[{}] {}", section.name(), field.name()), field.value(), 1);
        }
    }
}

fn whole(section: Section<'_>, losses: &mut Losses) {
    if section.fields().next().is_some() {
        losses.unkept(section.line(), format!("[{}]", section.name()), "", 1);
    }
}
