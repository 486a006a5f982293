//! One JSON object (`docs/json.md`).

use super::{Shown, at};
use crate::descriptions::difference::json::content;
use canvass_analyzer::dictionary::difference::Fact;
use canvass_analyzer::dictionary::layout::PdoLayout;
use canvass_analyzer::dictionary::names::ObjectName;
use canvass_analyzer::dictionary::{Entry, Object, Setting};
use serde_json::{Value, json};

/// The name and version of the contract.
const SCHEMA: &str = "canvass/eds-show/1";

pub(super) fn document(shown: &Shown) -> Value {
    let device = &shown.description.device;
    json!({
        "schema": SCHEMA,
        "file": shown.file,
        "node": shown.node.map(|node| node.raw()),
        "device": {
            "vendor_name": device.vendor_name,
            "vendor_number": device.vendor_number,
            "product_name": device.product_name,
            "product_number": device.product_number,
            "revision_number": device.revision_number,
            "order_code": device.order_code,
            "bit_rates": device.bit_rates,
            "profile": shown.description.device_profile(),
            "lss": device.lss_supported,
        },
        "objects": shown.objects().map(|object| one_object(shown, object)).collect::<Vec<_>>(),
        "pdos": shown.pdos().iter().map(|layout| pdo(shown, layout)).collect::<Vec<_>>(),
    })
}

fn one_object(shown: &Shown, object: &Object) -> Value {
    let entries = object.entries().iter().map(|entry| one_entry(shown, object, entry));
    json!({
        "index": object.index.0,
        "name": object.name,
        "code": object.code.to_string(),
        "line": (object.line > 0).then_some(object.line),
        "entries": entries.collect::<Vec<_>>(),
    })
}

fn one_entry(shown: &Shown, object: &Object, entry: &Entry) -> Value {
    let value = |setting: &Option<Setting>| setting.as_ref().map(|setting| value(shown, entry, setting));
    let standard = shown.standard(at(object, entry.sub));
    json!({
        "sub": entry.sub.0,
        "name": entry.name,
        "data_type": entry.data_type.to_string(),
        "bits": entry.data_type.bits(),
        "access": entry.access.name(),
        "rpdo": entry.pdo_mappable && entry.access.allows_rpdo(),
        "tpdo": entry.pdo_mappable && entry.access.allows_tpdo(),
        "default": value(&entry.default),
        "low_limit": value(&entry.low_limit),
        "high_limit": value(&entry.high_limit),
        "configured": value(&entry.configured),
        "denotation": entry.denotation,
        "flags": entry.flags.0,
        "standard": standard.as_ref().map(in_standard),
        "line": (entry.line > 0).then_some(entry.line),
    })
}

/// The name and the clause of an object in a standard.
fn in_standard(name: &ObjectName) -> Value {
    let clause = name.object.clause();
    json!({
        "standard": clause.standard,
        "clause": clause.section,
        "clause_confidence": clause.confidence.name(),
        "name": name.to_string(),
    })
}

fn value(shown: &Shown, entry: &Entry, setting: &Setting) -> Value {
    let setting = match shown.node {
        Some(node) => Setting::Fixed(setting.resolve(entry.data_type, node)),
        None => setting.clone(),
    };
    content(&Fact::Setting(setting))
}

fn pdo(shown: &Shown, layout: &PdoLayout<'_>) -> Value {
    let cob_id = layout.cob_id.map(|setting| match (setting, shown.node) {
        (Setting::NodeIdPlus(offset), Some(node)) => json!(offset.wrapping_add(u32::from(node.raw()))),
        _ => content(&Fact::CobId(setting.clone())),
    });
    let fields = layout.fields.as_ref().map(|fields| {
        let field = fields.iter().map(|field| {
            json!({
                "index": field.mapped.object().index.0,
                "sub": field.mapped.object().sub.0,
                "name": field.entry.map(|entry| &entry.name),
                "data_type": field.entry.map(|entry| entry.data_type.to_string()),
                "offset": field.offset,
                "bits": field.mapped.bits(),
            })
        });
        field.collect::<Vec<_>>()
    });
    json!({
        "pdo": layout.pdo.to_string(),
        "cob_id": cob_id,
        "transmission_type": layout.transmission_type,
        "bits": layout.bits(),
        "fields": fields,
    })
}
