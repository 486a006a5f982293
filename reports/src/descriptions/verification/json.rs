//! One JSON object (`docs/json.md`).

use super::{Verification, subject};
use crate::descriptions::difference::json::content;
use canvass_analyzer::dictionary::Setting;
use canvass_analyzer::dictionary::difference::{Fact, Subject};
use canvass_analyzer::dictionary::survey::Answer;
use canvass_analyzer::dictionary::survey::compare::{Mismatch, Side};
use canvass_traces::hex;
use serde_json::{Value, json};

/// The name and version of the contract.
const SCHEMA: &str = "canvass/eds-verify/1";

pub(super) fn document(verification: &Verification) -> Value {
    let differences = verification.mismatches.iter().map(|mismatch| difference(verification, mismatch));
    json!({
        "schema": SCHEMA,
        "file": verification.file,
        "bus": verification.bus,
        "node": verification.node.raw(),
        "as_delivered": verification.as_delivered,
        "read": verification.read,
        "existing": verification.existing,
        "given_up_at": verification.given_up.map(|index| index.0),
        "summary": {
            "differences": verification.differences().count(),
            "may_be_configuration_or_state": verification.explicable().count(),
        },
        "differences": differences.collect::<Vec<_>>(),
    })
}

fn difference(verification: &Verification, mismatch: &Mismatch) -> Value {
    let (index, sub, pdo, field) = match mismatch.subject {
        Subject::Object(index) => (Some(index.0), None, None, None),
        Subject::Entry(at) => (Some(at.index.0), Some(at.sub.0), None, None),
        Subject::Pdo(pdo) => (Some(pdo.mapping_index()), None, Some(pdo.to_string()), None),
        Subject::Field(field) => (None, None, None, Some(field)),
        Subject::Module(_) => (None, None, None, None),
    };
    let words = format!(
        "{}: {}: {} described, {} found",
        subject(mismatch),
        mismatch.kind.id(),
        mismatch.described,
        mismatch.found
    );
    json!({
        "kind": mismatch.kind.id(),
        "weight": mismatch.weight.name(),
        "counts": verification.counts(mismatch),
        "index": index,
        "sub": sub,
        "pdo": pdo,
        "field": field,
        "name": mismatch.name,
        "described": value(&mismatch.described),
        "found": value(&mismatch.found),
        "text": words,
        "meaning": mismatch.kind.meaning(),
    })
}

/// One side of a mismatch: its value, or a text if it has none.
fn value(shown: &Side) -> Value {
    let setting = |value: &Option<canvass_analyzer::dictionary::Value>| {
        value.clone().map(|value| content(&Fact::Setting(Setting::Fixed(value))))
    };
    match shown {
        Side::Nothing => Value::Null,
        Side::Fact(fact) => content(fact),
        Side::Limits(low, high) => json!({ "low": setting(low), "high": setting(high) }),
        Side::Length(bytes) => json!({ "bytes": bytes }),
        Side::Answer(Answer::Value(bytes)) => json!({ "data": hex::compact(bytes).to_string() }),
        Side::Answer(Answer::Aborted(code)) => json!({ "abort": code.0 }),
        Side::Exists | Side::NotMappable | Side::Answer(_) => json!(shown.to_string()),
    }
}
