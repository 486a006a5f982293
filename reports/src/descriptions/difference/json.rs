//! One JSON object (`docs/json.md`).

use super::{Compared, fact, subject};
use canvass_analyzer::PdoNumber;
use canvass_analyzer::dictionary::difference::{Class, Difference, Fact, Subject};
use canvass_analyzer::dictionary::{Setting, Value as Content};
use serde_json::{Value, json};

/// The name and version of the contract.
const SCHEMA: &str = "canvass/eds-diff/1";

pub(super) fn document(compared: &Compared) -> Value {
    json!({
        "schema": SCHEMA,
        "old": compared.old,
        "new": compared.new,
        "summary": {
            "breaking": compared.count(Class::Breaking),
            "notable": compared.count(Class::Notable),
            "harmless": compared.count(Class::Harmless),
        },
        "differences": compared.differences.iter().map(difference).collect::<Vec<_>>(),
    })
}

fn difference(difference: &Difference) -> Value {
    let (index, sub, pdo, field, module) = match difference.subject {
        Subject::Object(index) => (Some(index.0), None, None, None, None),
        Subject::Entry(at) => (Some(at.index.0), Some(at.sub.0), None, None, None),
        Subject::Pdo(pdo) => (None, None, Some(pdo), None, None),
        Subject::Field(field) => (None, None, None, Some(field), None),
        Subject::Module(number) => (None, None, None, None, Some(number)),
    };
    let words = format!(
        "{}: {}: {} -> {}",
        subject(difference),
        difference.kind.title(),
        fact(difference.before.as_ref()),
        fact(difference.after.as_ref())
    );
    json!({
        "kind": difference.kind.id,
        "class": difference.kind.class.name(),
        "index": index,
        "sub": sub,
        "name": difference.name,
        "pdo": pdo.map(name_of_pdo),
        "field": field,
        "module": module,
        "before": difference.before.as_ref().map(content),
        "after": difference.after.as_ref().map(content),
        "text": words,
        "why": difference.kind.why(),
    })
}

fn name_of_pdo(pdo: PdoNumber) -> String {
    pdo.to_string()
}

/// The content of a description's fact as JSON.
pub(in crate::descriptions) fn content(fact: &Fact) -> Value {
    match fact {
        Fact::Text(text) => json!(text),
        Fact::Number(number) | Fact::Code(number) => json!(number),
        Fact::Flag(flag) => json!(flag),
        Fact::BitRate(rate) => json!(rate),
        Fact::ObjectCode(code) => json!(code.to_string()),
        Fact::DataType(data_type) => json!(data_type.to_string()),
        Fact::Access(access) => json!(access.name()),
        Fact::Setting(setting) | Fact::CobId(setting) => value(setting),
        Fact::Mapping(entries) => entries
            .iter()
            .map(|entry| json!({ "index": entry.object().index.0, "sub": entry.object().sub.0, "bits": entry.bits() }))
            .collect(),
    }
}

/// A number, or a text such as a formula in the notation of CiA 306.
fn value(setting: &Setting) -> Value {
    match setting {
        Setting::NodeIdPlus(offset) => json!(format!("$NODEID+{offset:#X}")),
        Setting::Fixed(Content::Boolean(value)) => json!(u8::from(*value)),
        Setting::Fixed(Content::Integer(value)) => json!(value),
        Setting::Fixed(Content::Unsigned(value)) => json!(value),
        Setting::Fixed(Content::Real32(value)) => json!(value),
        Setting::Fixed(Content::Real64(value)) => json!(value),
        Setting::Fixed(Content::VisibleString(bytes)) => json!(String::from_utf8_lossy(bytes)),
        Setting::Fixed(Content::UnicodeString(units)) => json!(String::from_utf16_lossy(units)),
        Setting::Fixed(other) => json!(other.to_string()),
    }
}
