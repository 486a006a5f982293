//! Values: parsed as typed, and printed.

use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{DataClass, DataType, DeviceDescription, Value, names};
use canvass_traces::hex;
use serde_json::json;

/// Parses a data type by its short or standard name.
pub fn parse_type(text: &str) -> Result<DataType> {
    let short = [
        ("bool", DataType::BOOLEAN),
        ("u8", DataType::UNSIGNED8),
        ("u16", DataType::UNSIGNED16),
        ("u32", DataType::UNSIGNED32),
        ("u64", DataType::UNSIGNED64),
        ("i8", DataType::INTEGER8),
        ("i16", DataType::INTEGER16),
        ("i32", DataType::INTEGER32),
        ("i64", DataType::INTEGER64),
        ("f32", DataType::REAL32),
        ("f64", DataType::REAL64),
        ("string", DataType::VISIBLE_STRING),
        ("bytes", DataType::DOMAIN),
    ];
    let wanted = text.to_lowercase();
    let by_short = short.iter().find(|(name, _)| *name == wanted).map(|&(_, data_type)| data_type);
    let by_name = || (1..=0x1B).map(DataType).find(|data_type| data_type.name() == Some(&wanted.to_uppercase()));
    by_short.or_else(by_name).ok_or_else(|| {
        anyhow!("expected u8 to u64, i8 to i64, f32, f64, bool, string, bytes or a name such as UNSIGNED32, found \"{text}\"")
    })
}

/// The data type from the description, else from the standard.
pub fn known_type(address: Multiplexer, description: Option<&DeviceDescription>) -> Option<DataType> {
    let described = description.and_then(|description| description.dictionary.entry(address).ok());
    let profile = description.and_then(DeviceDescription::device_profile);
    let standard = || names::object_name(address, profile)?.entry?.data_type;
    described.map(|entry| entry.data_type).or_else(standard)
}

/// Encodes a typed value.
pub fn encode(text: &str, address: Multiplexer, data_type: Option<DataType>) -> Result<Vec<u8>> {
    let data_type =
        data_type.with_context(|| format!("the data type of {address} is not known: use --type, or --device"))?;
    let not_a = || anyhow!("expected {} for {address}, found \"{text}\"", data_type.name().unwrap_or("another type"));
    let value = match data_type.class().ok_or_else(not_a)? {
        DataClass::Boolean => Value::Boolean(match &*text.to_lowercase() {
            "1" | "true" => true,
            "0" | "false" => false,
            _ => return Err(not_a()),
        }),
        DataClass::Unsigned => Value::Unsigned(unsigned(text, data_type).ok_or_else(not_a)?),
        DataClass::Integer => Value::Integer(integer(text).ok_or_else(not_a)?),
        DataClass::Real if data_type == DataType::REAL32 => Value::Real32(text.parse().map_err(|_| not_a())?),
        DataClass::Real => Value::Real64(text.parse().map_err(|_| not_a())?),
        DataClass::VisibleString => Value::VisibleString(text.as_bytes().to_vec()),
        DataClass::UnicodeString => Value::UnicodeString(text.encode_utf16().collect()),
        DataClass::OctetString => Value::OctetString(bytes(text)?),
        DataClass::Domain => Value::Domain(bytes(text)?),
        _ => bail!("{address} has a data type without a text form: give its bytes with --type bytes"),
    };
    Ok(value.encode(data_type)?)
}

/// Parses a number, or the letters of a signature such as `save`.
fn unsigned(text: &str, data_type: DataType) -> Option<u64> {
    let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(hex) => u64::from_str_radix(hex, 16).ok(),
        None => text.parse().ok(),
    };
    let letters = text.as_bytes().first_chunk::<4>().filter(|_| text.len() == 4 && data_type == DataType::UNSIGNED32);
    number.or_else(|| letters.map(|letters| u64::from(u32::from_le_bytes(*letters))))
}

fn integer(text: &str) -> Option<i64> {
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
    let number = match digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
        Some(hex) => i64::from_str_radix(hex, 16).ok()?,
        None => return text.parse().ok(),
    };
    number.checked_mul(sign)
}

fn bytes(text: &str) -> Result<Vec<u8>> {
    let digits: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    hex::parse(&digits).with_context(|| format!("expected pairs of hexadecimal digits, found \"{text}\""))
}

/// Numbers become JSON numbers, texts become strings; `null` if the data type is not known.
pub fn json(bytes: &[u8], data_type: Option<DataType>) -> serde_json::Value {
    match data_type.and_then(|data_type| Value::decode(data_type, bytes).ok()) {
        Some(Value::Boolean(value)) => json!(value),
        Some(Value::Integer(value)) => json!(value),
        Some(Value::Unsigned(value)) => json!(value),
        Some(Value::Real32(value)) => json!(value),
        Some(Value::Real64(value)) => json!(value),
        Some(Value::VisibleString(text)) => json!(String::from_utf8_lossy(&text)),
        Some(Value::UnicodeString(units)) => json!(String::from_utf16_lossy(&units)),
        _ => json!(null),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;

    const ANY: Multiplexer = Multiplexer::new(0x2000, 0);

    fn encoded(text: &str, data_type: &str) -> Option<Vec<u8>> {
        encode(text, ANY, Some(parse_type(data_type).unwrap())).ok()
    }

    #[test]
    fn values_are_little_endian_and_fit() {
        assert_eq!(encoded("1000", "u16"), Some(vec![0xE8, 0x03]));
        assert_eq!(encoded("0x12345678", "UNSIGNED32"), Some(vec![0x78, 0x56, 0x34, 0x12]));
        assert_eq!(encoded("save", "u32"), Some(b"save".to_vec()));
        assert_eq!(encoded("-2", "i8"), Some(vec![0xFE]));
        assert_eq!(encoded("-0x10", "i16"), Some(vec![0xF0, 0xFF]));
        assert_eq!(encoded("1.5", "f32"), Some(1.5_f32.to_le_bytes().to_vec()));
        assert_eq!(encoded("Hello", "string"), Some(b"Hello".to_vec()));
        assert_eq!(encoded("01 a2 FF", "bytes"), Some(vec![1, 0xA2, 0xFF]));
        assert_eq!(encoded("true", "bool"), Some(vec![1]));
        for (text, data_type) in [("256", "u8"), ("-1", "u8"), ("128", "i8"), ("1.5", "u8"), ("123", "bytes")] {
            assert_eq!(encoded(text, data_type), None, "{text} {data_type}");
        }
        assert!(encode("1", ANY, None).unwrap_err().to_string().contains("--type"));
    }

    #[test]
    fn types_are_known_from_the_description_or_the_standard() {
        let encoder = super::super::encoder();
        assert_eq!(known_type(Multiplexer::new(0x6004, 0), Some(&encoder)), Some(DataType::UNSIGNED32));
        assert_eq!(known_type(Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), None), Some(DataType::UNSIGNED16));
        assert_eq!(known_type(ANY, None), None);
    }
}
