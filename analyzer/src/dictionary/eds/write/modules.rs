//! Modules: `SupportedModules`, `MxModuleInfo`, `MxFixedObjects`, `MxSubExtends`, `ConnectedModules`.

use super::{Sheet, objects};
use crate::dictionary::description::{DeviceDescription, Module, SubExtension};
use crate::dictionary::object::ObjectCode;

pub(super) fn write(sheet: &mut Sheet, description: &DeviceDescription) {
    if !description.modules.is_empty() {
        sheet.section("SupportedModules");
        sheet.field("NrOfEntries", &description.modules.len().to_string());
        description.modules.iter().for_each(|module| self::module(sheet, module));
    }
    if !description.connected_modules.is_empty() {
        sheet.section("ConnectedModules");
        sheet.field("NrOfEntries", &description.connected_modules.len().to_string());
        for (slot, number) in (1..).zip(&description.connected_modules) {
            sheet.number(&u32::to_string(&slot), *number);
        }
    }
}

fn module(sheet: &mut Sheet, module: &Module) {
    let number = module.number;
    sheet.section(&format!("M{number}ModuleInfo"));
    sheet.text("ProductName", &module.product_name, 0);
    sheet.code("ProductVersion", module.product_version);
    sheet.code("ProductRevision", module.product_revision);
    sheet.text("OrderCode", &module.order_code, 0);
    let fixed: Vec<u16> = module.fixed_objects.iter().map(|object| object.index.0).collect();
    sheet.section(&format!("M{number}FixedObjects"));
    sheet.list("NrOfEntries", &fixed);
    for object in &module.fixed_objects {
        objects::write(sheet, object, &format!("M{number}Fixed{:04X}", object.index.0));
    }
    let extended: Vec<u16> = module.extensions.iter().map(|extension| extension.template.index.0).collect();
    sheet.section(&format!("M{number}SubExtends"));
    sheet.list("NrOfEntries", &extended);
    for extension in &module.extensions {
        self::extension(sheet, number, extension);
    }
}

fn extension(sheet: &mut Sheet, module: u16, extension: &SubExtension) {
    let template = &extension.template;
    sheet.section(&format!("M{module}SubExt{:04X}", template.index.0));
    sheet.text("ParameterName", &template.name, template.line);
    sheet.code("ObjectType", Some(ObjectCode::VAR.0.into()));
    if let Some(entry) = template.entries().first() {
        objects::fields(sheet, entry);
    }
    sheet.number("Count", extension.count);
    sheet.number("ObjExtend", extension.object_extend);
}
