//! Writes the elements `CANopenObject` and `CANopenSubObject`.

use super::Sheet;
use crate::dictionary::eds::text_of;
use crate::dictionary::loss::LossKind;
use crate::dictionary::object::{Access, Entry, Object, ObjectCode, Setting};
use crate::identity::SubIndex;

type Attribute = (&'static str, Option<String>);

pub(super) fn write(sheet: &mut Sheet, object: &Object) {
    let index = object.index;
    let code = match object.code.name() {
        Some(_) => object.code,
        None => {
            let place = format!("{index} ObjectType");
            let kind = LossKind::Changed(ObjectCode::VAR.to_string());
            sheet.losses.add(object.line, place, &object.code.to_string(), kind);
            ObjectCode::VAR
        }
    };
    let mut attributes = vec![
        ("index", Some(format!("{:04X}", index.0))),
        ("name", sheet.text(object.line, &format!("{index} ParameterName"), &object.name)),
        ("objectType", Some(code.0.to_string())),
    ];
    match object.entries() {
        [entry] if entry.sub == SubIndex(0) && code.is_single() => {
            if entry.name != object.name {
                sheet.losses.no_place(entry.line, format!("{index} the name of sub-index 0"), &entry.name);
            }
            attributes.extend(entry_attributes(sheet, &index.to_string(), entry));
            sheet.markup.empty("CANopenObject", &attributes);
        }
        [] => sheet.markup.empty("CANopenObject", &attributes),
        entries => {
            attributes.push(("subNumber", Some(entries.len().to_string())));
            sheet.markup.open("CANopenObject", &attributes);
            for entry in entries {
                sub_object(sheet, object, entry);
            }
            sheet.markup.close();
        }
    }
}

fn sub_object(sheet: &mut Sheet, object: &Object, entry: &Entry) {
    let place = format!("{}:{:02X}", object.index, entry.sub.0);
    let mut attributes = vec![
        ("subIndex", Some(format!("{:02X}", entry.sub.0))),
        ("name", sheet.text(entry.line, &format!("{place} ParameterName"), &entry.name)),
        ("objectType", Some(ObjectCode::VAR.0.to_string())),
    ];
    attributes.extend(entry_attributes(sheet, &place, entry));
    sheet.markup.empty("CANopenSubObject", &attributes);
}

/// All attributes of an entry except its name.
fn entry_attributes(sheet: &mut Sheet, place: &str, entry: &Entry) -> [Attribute; 9] {
    let mut value = |name: &str, setting: &Option<Setting>| {
        let setting = setting.as_ref()?;
        let text = text_of(setting, entry.data_type);
        if text.is_none() {
            sheet.losses.no_place(entry.line, format!("{place} {name}"), &setting.to_string());
        }
        text
    };
    let [low, high, default, configured] = [
        value("LowLimit", &entry.low_limit),
        value("HighLimit", &entry.high_limit),
        value("DefaultValue", &entry.default),
        value("ParameterValue", &entry.configured),
    ];
    let (access, mapping) = access(sheet, place, entry);
    let denotation = entry.denotation.as_deref().unwrap_or_default();
    [
        ("dataType", (entry.data_type.0 != 0).then(|| format!("{:04X}", entry.data_type.0))),
        ("lowLimit", low),
        ("highLimit", high),
        ("accessType", Some(access.to_owned())),
        ("defaultValue", default),
        ("PDOmapping", Some(mapping.to_owned())),
        ("objFlags", (entry.flags.0 != 0).then(|| format!("{:04X}", entry.flags.0))),
        ("actualValue", configured),
        ("denotation", sheet.text(entry.line, &format!("{place} Denotation"), denotation)),
    ]
}

/// The access type and `PDOmapping`. CiA 311 has four access types; `PDOmapping` tells the direction in PDOs.
fn access(sheet: &mut Sheet, place: &str, entry: &Entry) -> (&'static str, &'static str) {
    let one_way = matches!(entry.access, Access::Rwr | Access::Rww);
    let access = if one_way { Access::Rw } else { entry.access };
    if one_way && !entry.pdo_mappable {
        let kind = LossKind::Changed(access.to_string());
        sheet.losses.add(entry.line, format!("{place} AccessType"), entry.access.name(), kind);
    }
    let mapping = match (entry.pdo_mappable, entry.access.allows_tpdo(), entry.access.allows_rpdo()) {
        (false, ..) => "no",
        (true, true, true) => "optional",
        (true, true, false) => "TPDO",
        (true, false, _) => "RPDO",
    };
    (access.name(), mapping)
}
