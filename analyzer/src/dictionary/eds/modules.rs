//! Modular devices: `SupportedModules`, `MxModuleInfo`, `MxFixedObjects`, `MxSubExtends`, `ConnectedModules`.

use std::collections::BTreeMap;

use super::fields::Fields;
use super::lists::numbered;
use super::objects::{self, Parts};
use crate::dictionary::data_type::DataType;
use crate::dictionary::description::{Module, SubExtension};
use crate::dictionary::object::{Object, ObjectCode};
use crate::dictionary::place::Place;
use crate::dictionary::problem::Problems;
use crate::dictionary::rules;
use crate::dictionary::source::{FieldName, ModulePart, Section, SectionName, Source};

/// The fields of `MxModuleInfo`.
pub(super) const INFO_FIELDS: [FieldName; 4] =
    [FieldName::ProductName, FieldName::ProductVersion, FieldName::ProductRevision, FieldName::OrderCode];

/// Whether a sub-index that a module adds may have that field.
const fn is_extension_field(field: FieldName) -> bool {
    objects::is_entry_field(field) || matches!(field, FieldName::Count | FieldName::ObjExtend)
}

/// The sections of one module.
#[derive(Default)]
struct ModuleParts<'d> {
    info: Option<Section<'d>>,
    fixed: BTreeMap<u16, Parts<'d>>,
    extensions: BTreeMap<u16, Section<'d>>,
}

/// All modules of the source.
pub(super) fn read(source: &Source<'_>, problems: &mut Problems) -> Vec<Module> {
    let mut modules: BTreeMap<u16, ModuleParts<'_>> = BTreeMap::new();
    for section in source.sections() {
        let SectionName::Module(number, part) = section.about() else { continue };
        let module = modules.entry(number).or_default();
        match part {
            ModulePart::Info => module.info = Some(section),
            ModulePart::Fixed(index) => {
                objects::add_head(module.fixed.entry(index).or_default(), section, problems);
            }
            ModulePart::FixedSub(index, sub) => {
                objects::add_sub(module.fixed.entry(index).or_default(), sub, section, problems);
            }
            ModulePart::SubExtension(index) => {
                module.extensions.insert(index, section);
            }
            ModulePart::FixedObjects | ModulePart::SubExtends => check_list(section, problems),
            ModulePart::Comments => {}
        }
    }
    check_numbers(source, &modules, problems);
    modules.into_iter().map(|(number, parts)| module(number, &parts, source, problems)).collect()
}

/// The modules that a DCF plugs in.
pub(super) fn connected(source: &Source<'_>, problems: &mut Problems) -> Vec<u16> {
    let section = source.section("ConnectedModules");
    section.map_or_else(Vec::new, |section| {
        numbered(section, FieldName::NrOfEntries, problems).into_iter().map(|(number, _)| number).collect()
    })
}

fn check_list(section: Section<'_>, problems: &mut Problems) {
    numbered(section, FieldName::NrOfEntries, problems);
}

/// Checks that modules are numbered from 1 to `NrOfEntries`, and that each has a `MxModuleInfo`.
fn check_numbers(source: &Source<'_>, modules: &BTreeMap<u16, ModuleParts<'_>>, problems: &mut Problems) {
    let supported = source.section("SupportedModules");
    if let Some(section) = supported {
        let mut fields = Fields { section, problems };
        fields.check_known(|field| field.known() == Some(FieldName::NrOfEntries));
        let announced = fields.number(FieldName::NrOfEntries, 0xFFFF).unwrap_or(0) as usize;
        if announced != modules.len() {
            let found = format!("{} modules", modules.len());
            fields.report(FieldName::NrOfEntries, &rules::module::COUNT, "the number of modules", &found);
        }
    } else if !modules.is_empty() {
        let place = Place { section: "SupportedModules", ..Place::default() };
        let expected = "a section of this name beside the modules";
        problems.report(place, &rules::module::SECTION, expected, "none");
    }
    for (position, (&number, parts)) in modules.iter().enumerate() {
        let section = format!("M{number}ModuleInfo");
        let place = Place { section: &section, ..Place::line(parts.info.map_or(0, Section::line)) };
        if parts.info.is_none() {
            let expected = "a section of this name for each module";
            problems.report(place, &rules::module::SECTION, expected, "none");
        }
        if usize::from(number) != position + 1 {
            let expected = "modules numbered without a gap, from 1";
            problems.report(place, &rules::module::NUMBER, expected, &number.to_string());
        }
    }
}

fn module(number: u16, parts: &ModuleParts<'_>, source: &Source<'_>, problems: &mut Problems) -> Module {
    let mut module = Module { number, ..Module::default() };
    if let Some(section) = parts.info {
        let mut fields = Fields { section, problems };
        fields.check_known(|field| field.known().is_some_and(|field| INFO_FIELDS.contains(&field)));
        module.product_name = fields.text(FieldName::ProductName).to_owned();
        module.product_version = fields.number(FieldName::ProductVersion, u32::MAX);
        module.product_revision = fields.number(FieldName::ProductRevision, u32::MAX);
        module.order_code = fields.text(FieldName::OrderCode).to_owned();
    }
    for (&index, parts) in &parts.fixed {
        module.fixed_objects.push(objects::object(index, parts, source, problems));
    }
    for (&index, &section) in &parts.extensions {
        module.extensions.push(extension(index, section, problems));
    }
    module
}

fn extension(index: u16, section: Section<'_>, problems: &mut Problems) -> SubExtension {
    let mut fields = Fields { section, problems };
    fields.check_known(|field| field.known().is_some_and(is_extension_field));
    let mut template = Object::new(index, objects::name(&mut fields), ObjectCode::ARRAY);
    (template.line, template.section) = (section.line(), Some(section.id));
    objects::object_code(&mut fields);
    template.insert(objects::entry(&mut fields, 1, DataType(0)));
    // `Count` may be two numbers separated by `;`: the second is the number of bits that share one sub-index.
    let count = fields.optional_text(FieldName::Count).unwrap_or_default();
    let first = count.split([';', ',']).next().and_then(super::number::parse);
    let count = first.and_then(|number| u32::try_from(number.value).ok());
    if count.is_none() {
        fields.report(FieldName::Count, &rules::module::EXTENSION, "the number of sub-indexes that it adds", "none");
    }
    let object_extend = fields.number(FieldName::ObjExtend, 0xFF).unwrap_or(0);
    SubExtension { template, count: count.unwrap_or(0), object_extend }
}
