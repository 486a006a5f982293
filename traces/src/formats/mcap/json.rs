//! Messages in JSON: the data as an array of numbers, in base64 (as Foxglove writes bytes) or in hex.

use super::fields::{Role, Shape, Values};
use crate::damage::Flaw;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value};
use std::borrow::Cow;

/// The plan for reading the messages of a JSON channel.
#[derive(Clone, Debug)]
pub(crate) struct JsonPlan {
    shape: Shape,
    /// Whether the schema marks texts as base64.
    base64: bool,
    /// Whether the channel has no schema, so that the reader must examine each message by itself.
    schemaless: bool,
}

impl JsonPlan {
    /// The plan for a JSON schema, or for messages without a schema; `None` if the messages are no CAN frames.
    pub(crate) fn new(name: &str, schema: &[u8]) -> Option<Self> {
        let named_fd = Shape::is_named_fd(name);
        let schema: Option<Value> = serde_json::from_slice(schema).ok();
        let Some(properties) = schema.as_ref().and_then(|schema| schema.get("properties")) else {
            let shape = Shape { named_fd, ..Shape::default() };
            return Some(Self { shape, base64: false, schemaless: true });
        };
        let properties = frame(properties.as_object()?, &|value| value.get("properties")?.as_object())?;
        let shape = Shape { named_fd, capacity: None, has_length: has_length(properties) };
        let data = property(properties, Role::Data)?;
        let base64 = data.get("contentEncoding").and_then(Value::as_str) == Some("base64");
        shape.is_can(name).then_some(Self { shape, base64, schemaless: false })
    }

    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Whether the schema proves that the messages are CAN frames.
    pub(crate) fn is_certain(&self) -> bool {
        !self.schemaless
    }

    /// The values of a message; `None` if the message holds no CAN frame, which is a damage only if there is a schema.
    pub(crate) fn read(&self, message: &[u8]) -> Result<Option<Values<'static>>, Flaw> {
        let parsed: Value =
            serde_json::from_slice(message).map_err(|error| Flaw::malformed("JSON", error.to_string()))?;
        let whole = parsed.as_object();
        let Some(object) = whole.and_then(|whole| frame(whole, &Value::as_object)) else {
            let missing = || Flaw::malformed("fields for an identifier and data", parsed.to_string());
            return if self.schemaless { Ok(None) } else { Err(missing()) };
        };
        if self.schemaless && !has_length(object) {
            return Ok(None);
        }
        let mut values = Values::default();
        for (name, value) in object {
            match Role::by_name(name) {
                Some(Role::Data) | None => {}
                Some(role) => {
                    let number = number(value)
                        .ok_or_else(|| Flaw::malformed(format!("a number for {name}"), value.to_string()))?;
                    values.set(role, number);
                }
            }
        }
        [Some(object), whole].into_iter().flatten().for_each(|object| stamp(object, &mut values));
        let length = values.length.or(values.dlc);
        let data = property(object, Role::Data).and_then(|data| self.data(data, length));
        values.data = Cow::Owned(
            data.ok_or_else(|| Flaw::malformed("data as an array, in base64 or in hex", parsed.to_string()))?,
        );
        Ok(Some(values))
    }

    fn data(&self, data: &Value, length: Option<u64>) -> Option<Vec<u8>> {
        match data {
            Value::Array(bytes) => bytes.iter().map(|byte| u8::try_from(number(byte)?).ok()).collect(),
            Value::String(text) => {
                let (hex, base64) = (hex(text), STANDARD.decode(text.trim()).ok());
                let fits =
                    |bytes: &Option<Vec<u8>>| bytes.as_ref().is_some_and(|bytes| Some(bytes.len() as u64) == length);
                // A text of digits may be base64 or hex; the length decides.
                if self.base64 || fits(&base64) && !fits(&hex) { base64 } else { hex.or(base64) }
            }
            Value::Null => Some(Vec::new()),
            _ => None,
        }
    }
}

type Object = Map<String, Value>;

/// The object with the fields of a frame: this object or one inside it. `inner` returns the object in a value.
fn frame<'a>(object: &'a Object, inner: &dyn Fn(&'a Value) -> Option<&'a Object>) -> Option<&'a Object> {
    let is_frame = |object: &Object| property(object, Role::Id).is_some() && property(object, Role::Data).is_some();
    if is_frame(object) {
        return Some(object);
    }
    object.values().filter_map(inner).find(|object| is_frame(object))
}

fn property(object: &Object, role: Role) -> Option<&Value> {
    object.iter().find(|(name, _)| Role::by_name(name) == Some(role)).map(|(_, value)| value)
}

fn has_length(object: &Object) -> bool {
    property(object, Role::Dlc).is_some() || property(object, Role::Length).is_some()
}

/// Parses a number, a truth value, or a text such as `0x181`.
fn number(value: &Value) -> Option<i64> {
    match value {
        Value::Bool(set) => Some(i64::from(*set)),
        Value::Number(number) => {
            number.as_i64().or_else(|| number.as_f64().filter(|n| n.fract() == 0.0).map(|n| n as i64))
        }
        Value::String(text) => match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
            Some(digits) => i64::from_str_radix(digits, 16).ok(),
            None => text.parse().ok(),
        },
        _ => None,
    }
}

/// Parses bytes in hex, perhaps with blanks, colons or dashes between them and `0x` before them.
fn hex(text: &str) -> Option<Vec<u8>> {
    let text = text.trim();
    let digits = text.strip_prefix("0x").unwrap_or(text).bytes().filter(|byte| !b" :-".contains(byte));
    crate::hex::parse(digits.collect::<Vec<u8>>())
}

/// Reads the time stamp, from a header or beside the frame's fields.
fn stamp(object: &Object, values: &mut Values<'_>) {
    let header = object.get("header").and_then(Value::as_object);
    for (name, value) in header.into_iter().flatten().chain(object) {
        let Some(parts) = value.as_object().filter(|_| Role::is_time(name)) else { continue };
        for (name, value) in parts {
            if let (Some(role), Some(number)) = (Role::of_time(name), number(value)) {
                values.set(role, number);
            }
        }
        return;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Timestamp;

    fn shown(plan: &JsonPlan, message: &str) -> String {
        match plan.read(message.as_bytes()) {
            Ok(Some(values)) => match values.record(plan.shape(), Timestamp(1)) {
                Ok(record) => format!("{} {}", record.timestamp.nanos(), record.frame),
                Err(flaw) => flaw.damage(crate::Place::default()).to_string(),
            },
            Ok(None) => "-".to_owned(),
            Err(flaw) => flaw.damage(crate::Place::default()).to_string(),
        }
    }

    #[test]
    fn arrays_base64_and_hex() {
        let plan = JsonPlan::new("Frame", b"").unwrap();
        assert_eq!(shown(&plan, r#"{"id":1599,"dlc":2,"data":[64,0,9]}"#), "1 63F#4000");
        assert_eq!(shown(&plan, r#"{"can_id":"0x63F","len":4,"data":"QABgAA=="}"#), "1 63F#40006000");
        assert_eq!(shown(&plan, r#"{"id":1,"dlc":4,"data":"deadbeef"}"#), "1 001#DEADBEEF");
        assert_eq!(shown(&plan, r#"{"id":1,"dlc":6,"data":"deadbeef"}"#), "1 001#75E69D6DE79F", "base64 by its length");
        assert_eq!(shown(&plan, r#"{"id":1,"dlc":2,"data":"0x 0A:0b"}"#), "1 001#0A0B");
        assert_eq!(shown(&plan, r#"{"x":1}"#), "-");
        assert!(shown(&plan, r#"{"id":"x","dlc":1,"data":[1]}"#).contains("a number for id"));
        assert!(shown(&plan, r#"{"id":1,"dlc":1,"data":[256]}"#).contains("expected data"));
        assert!(shown(&plan, "{").starts_with("malformed: expected JSON"));
    }

    #[test]
    fn schemas_tell_what_is_a_frame() {
        let schema = br#"{"type":"object","properties":{"timestamp":{"type":"object"},"frame":{"type":"object",
            "properties":{"id":{"type":"integer"},"len":{},"data":{"type":"string","contentEncoding":"base64"}}}}}"#;
        let plan = JsonPlan::new("vendor.Can", schema).unwrap();
        let message = r#"{"timestamp":{"sec":2,"nsec":3},"frame":{"id":256,"len":3,"data":"AAAA"}}"#;
        assert_eq!(shown(&plan, message), "2000000003 100#000000");
        assert!(JsonPlan::new("foxglove.Log", br#"{"properties":{"message":{}}}"#).is_none());
    }
}
