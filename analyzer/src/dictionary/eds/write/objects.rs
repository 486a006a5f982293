//! Objects: `[1018]` with `[1018sub0]`, `[1018sub1]`…

use super::{Sheet, text_of};
use crate::dictionary::data_type::DataType;
use crate::dictionary::loss::LossKind;
use crate::dictionary::object::{Entry, Object, ObjectCode};
use crate::identity::SubIndex;

/// Writes the sections of an object; `name` is the name of the first one.
pub(super) fn write(sheet: &mut Sheet, object: &Object, name: &str) {
    let value = match object.entries() {
        [entry] if entry.sub == SubIndex(0) && object.code.is_single() => Some(entry),
        _ => None,
    };
    let mut code = object.code;
    if value.is_none() && code.is_single() {
        code = ObjectCode::RECORD;
        let place = format!("[{name}] ObjectType");
        sheet.losses.add(object.line, place, &object.code.to_string(), LossKind::Changed(code.to_string()));
    }
    sheet.section(name);
    sheet.text("ParameterName", &object.name, object.line);
    sheet.code("ObjectType", Some(code.0.into()));
    let Some(entry) = value else {
        sheet.field("SubNumber", &object.entries().len().to_string());
        for entry in object.entries() {
            sheet.section(&format!("{name}sub{:X}", entry.sub.0));
            sheet.text("ParameterName", &entry.name, entry.line);
            let code = if entry.data_type == DataType::DOMAIN { ObjectCode::DOMAIN } else { ObjectCode::VAR };
            sheet.code("ObjectType", Some(code.0.into()));
            fields(sheet, entry);
        }
        return;
    };
    if entry.name != object.name {
        // A VAR's entry has the name of its object.
        sheet.losses.no_place(entry.line, format!("[{name}] the name of sub-index 0"), &entry.name);
    }
    fields(sheet, entry);
}

/// Writes all fields of an entry but its name and object code.
pub(super) fn fields(sheet: &mut Sheet, entry: &Entry) {
    if entry.data_type.0 != 0 {
        sheet.field("DataType", &format!("0x{:04X}", entry.data_type.0));
    }
    setting(sheet, "LowLimit", entry, entry.low_limit.as_ref());
    setting(sheet, "HighLimit", entry, entry.high_limit.as_ref());
    sheet.field("AccessType", entry.access.name());
    setting(sheet, "DefaultValue", entry, entry.default.as_ref());
    sheet.flag("PDOMapping", entry.pdo_mappable);
    if entry.flags.0 != 0 {
        sheet.code("ObjFlags", Some(entry.flags.0));
    }
    setting(sheet, "ParameterValue", entry, entry.configured.as_ref());
    if let Some(denotation) = &entry.denotation {
        sheet.text("Denotation", denotation, entry.line);
    }
}

fn setting(sheet: &mut Sheet, name: &str, entry: &Entry, setting: Option<&crate::dictionary::object::Setting>) {
    let Some(setting) = setting else { return };
    match text_of(setting, entry.data_type) {
        Some(text) => sheet.field(name, &text),
        None => {
            let place = format!("[{}] {name}", sheet.section);
            sheet.losses.no_place(entry.line, place, &setting.to_string());
        }
    }
}
