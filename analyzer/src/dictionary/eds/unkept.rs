//! What stands in an EDS or DCF that a description does not hold.

use super::lexer::{self, Document, Section, canonical};
use super::objects::KEPT_ENTRY_FIELDS;
use super::section_name::{ModulePart, SectionName};
use super::{header, text};
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::loss::{Loss, Losses};
use crate::dictionary::object::{Entry, Object};
use crate::dictionary::problem::Problems;
use crate::identity::{Index, SubIndex};

/// The fields of an object with sub-indexes that are kept.
const HEAD: [&str; 4] = ["parametername", "objecttype", "subnumber", "compactsubobj"];
/// Those of an entry that hold a value of its data type.
const VALUES: [&str; 4] = ["defaultvalue", "lowlimit", "highlimit", "parametervalue"];
const COMMISSIONING: [&str; 7] =
    ["nodeid", "nodename", "baudrate", "netnumber", "networkname", "canopenmanager", "lss_serialnumber"];
const MODULE: [&str; 4] = ["productname", "productversion", "productrevision", "ordercode"];
/// Fields of `DeviceInfo` that are known and not kept.
const UNKEPT_DEVICE_INFO: [&str; 3] = ["canopensafetysupported", "extendedbootupmaster", "extendedbootupslave"];

/// Everything that is in the file and not in the description that was read from it, by line.
pub(in crate::dictionary) fn unkept(description: &DeviceDescription, bytes: &[u8]) -> Vec<Loss> {
    let mut problems = Problems::default();
    let text = text::decode(bytes, &mut problems);
    let document = lexer::read(&text, &mut problems);
    let mut losses = Losses::default();
    losses.unread(&description.problems);
    comments(&text, &mut losses);
    for section in &document.sections {
        self::section(section, &document, description, &mut losses);
    }
    losses.0.sort_by_key(|loss| loss.line);
    losses.0
}

/// Comment lines, all together.
fn comments(text: &str, losses: &mut Losses) {
    let is_comment = |line: &str| [";", "#", "//"].iter().any(|mark| line.trim_start().starts_with(mark));
    let mut comments = (1..).zip(text.lines()).filter(|(_, line)| is_comment(line));
    if let Some((line, first)) = comments.next() {
        losses.unkept(line, "a comment", first.trim(), 1 + comments.count());
    }
}

fn section(section: &Section<'_>, document: &Document<'_>, description: &DeviceDescription, losses: &mut Losses) {
    let each = |losses: &mut Losses, kept: &dyn Fn(&str) -> bool| fields(section, losses, kept);
    match SectionName::parse(section.name) {
        SectionName::FileInfo => each(losses, &|name| header::FILE_INFO.contains(&name)),
        SectionName::DeviceInfo => {
            each(losses, &|name| header::is_device_info(name) && !UNKEPT_DEVICE_INFO.contains(&name));
        }
        SectionName::DeviceCommissioning => each(losses, &|name| COMMISSIONING.contains(&name)),
        SectionName::Comments => each(losses, &|name| name.starts_with("line")),
        SectionName::Object(index) => {
            let object = description.dictionary.object(Index(index));
            head(section, object, losses);
        }
        SectionName::Sub(index, sub) => {
            let object = description.dictionary.object(Index(index));
            entry(section, object.and_then(|object| object.entry(SubIndex(sub))), losses);
        }
        SectionName::Beside(index) => {
            // Only what stands beside an object of compact form is used.
            let head = document.section(&format!("{index:04X}"));
            let is_used = head.is_some_and(|head| head.field("CompactSubObj").is_some())
                && !canonical(section.name).ends_with("objectlinks");
            if !is_used {
                whole(section, losses);
            }
        }
        SectionName::Module(_, ModulePart::Info) => each(losses, &|name| MODULE.contains(&name)),
        SectionName::Module(_, ModulePart::SubExtension(_)) => {
            each(losses, &|name| KEPT_ENTRY_FIELDS.contains(&name) || matches!(name, "count" | "objextend"));
        }
        SectionName::Module(_, ModulePart::Fixed(_) | ModulePart::FixedSub(..)) => {
            each(losses, &|name| KEPT_ENTRY_FIELDS.contains(&name) || HEAD.contains(&name));
        }
        SectionName::DynamicChannels
        | SectionName::Tools
        | SectionName::Unknown
        | SectionName::Module(_, ModulePart::Comments) => whole(section, losses),
        // Lists, which are made of what is described, and what is kept as it is.
        SectionName::DummyUsage
        | SectionName::MandatoryObjects
        | SectionName::OptionalObjects
        | SectionName::ManufacturerObjects
        | SectionName::SupportedModules
        | SectionName::ConnectedModules
        | SectionName::Module(..) => {}
    }
}

/// An object, which is an entry if it has no sub-indexes.
fn head(section: &Section<'_>, object: Option<&Object>, losses: &mut Losses) {
    match object {
        Some(object) if object.code.is_single() => entry(section, object.entries().first(), losses),
        Some(object) if section.field("CompactSubObj").is_some() || object.entries().len() == 1 => {
            entry(section, object.entries().last(), losses);
        }
        _ => fields(section, losses, |name| HEAD.contains(&name)),
    }
}

fn entry(section: &Section<'_>, entry: Option<&Entry>, losses: &mut Losses) {
    fields(section, losses, |name| {
        let is_without_value = entry.is_some_and(|entry| entry.data_type.class().is_none());
        (KEPT_ENTRY_FIELDS.contains(&name) || HEAD.contains(&name)) && !(VALUES.contains(&name) && is_without_value)
    });
}

/// The fields that are not blank and not kept.
fn fields(section: &Section<'_>, losses: &mut Losses, kept: impl Fn(&str) -> bool) {
    for field in &section.fields {
        if !field.value.is_empty() && !kept(&canonical(field.name)) {
            losses.unkept(field.line, format!("[{}] {}", section.name, field.name), field.value, 1);
        }
    }
}

fn whole(section: &Section<'_>, losses: &mut Losses) {
    if !section.fields.is_empty() {
        losses.unkept(section.line, format!("[{}]", section.name), "", 1);
    }
}
