//! Values in the form of CiA 306, which XDD shares.

use crate::dictionary::data_type::DataType;
use crate::dictionary::eds::fields::setting as read;
use crate::dictionary::object::Setting;
use crate::dictionary::place::Place;
use crate::dictionary::problem::Problems;
use crate::dictionary::value::Value;
use canvass_traces::hex;

/// The text that reads as the setting of an entry with the data type; `None` if no text does: for an empty string, a
/// string with control characters or blanks at its ends, a type without values.
pub(in crate::dictionary) fn text_of(setting: &Setting, data_type: DataType) -> Option<String> {
    candidates(setting, data_type).into_iter().find(|text| {
        let back = read(text, data_type, Place::default(), &mut Problems::default());
        !text.chars().any(char::is_control) && back.is_some_and(|back| is_same(&back, setting))
    })
}

fn candidates(setting: &Setting, data_type: DataType) -> Vec<String> {
    let value = match setting {
        Setting::NodeIdPlus(0) => return vec!["$NODEID".to_owned()],
        Setting::NodeIdPlus(offset) => return vec![format!("$NODEID+0x{offset:X}")],
        Setting::Fixed(value) => value,
    };
    let bits = |raw: u64| format!("0x{raw:X}");
    match value {
        Value::Boolean(value) => vec![u8::from(*value).to_string()],
        Value::Integer(value) => vec![value.to_string()],
        // COB-IDs, mappings and identities are usually read in hexadecimal.
        Value::Unsigned(value @ 10..) if data_type.bits() >= Some(32) => vec![bits(*value)],
        Value::Unsigned(value) => vec![value.to_string()],
        Value::Real32(value) => vec![format!("{value:?}"), bits(value.to_bits().into())],
        Value::Real64(value) => vec![format!("{value:?}"), bits(value.to_bits())],
        // The reader gives characters beyond Latin-1 as their UTF-8 bytes.
        Value::VisibleString(bytes) => {
            std::iter::once(latin_1(bytes)).chain(String::from_utf8(bytes.clone())).collect()
        }
        Value::UnicodeString(units) => vec![String::from_utf16_lossy(units)],
        Value::OctetString(bytes) => vec![hex::spaced(bytes).to_string()],
        Value::Domain(bytes) => vec![hex::spaced(bytes).to_string()],
        Value::TimeOfDay(_) | Value::TimeDifference(_) => {
            value.to_raw().map(|raw| raw.to_string()).into_iter().collect()
        }
    }
}

fn latin_1(bytes: &[u8]) -> String {
    bytes.iter().map(|&byte| char::from(byte)).collect()
}

/// Whether the settings are equal; NaN equals NaN.
fn is_same(one: &Setting, other: &Setting) -> bool {
    let raw = |setting: &Setting| setting.fixed().and_then(Value::to_raw);
    let kind = |setting: &Setting| setting.fixed().map(std::mem::discriminant);
    one == other || (kind(one) == kind(other) && raw(one).is_some() && raw(one) == raw(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn text(value: Value, data_type: DataType) -> Option<String> {
        text_of(&Setting::Fixed(value), data_type)
    }

    #[test]
    fn values_are_written_as_they_are_read() {
        let text = |value, data_type| text(value, data_type).unwrap_or_default();
        assert_eq!(text(Value::Unsigned(255), DataType::UNSIGNED8), "255");
        assert_eq!(text(Value::Unsigned(0x6004_0020), DataType::UNSIGNED32), "0x60040020");
        assert_eq!(text(Value::Integer(-5), DataType::INTEGER32), "-5");
        assert_eq!(text(Value::Real32(1.5), DataType::REAL32), "1.5");
        assert_eq!(text(Value::Real32(f32::NAN), DataType::REAL32), "NaN");
        assert_eq!(text(Value::Boolean(true), DataType::BOOLEAN), "1");
        assert_eq!(text(Value::OctetString(vec![1, 0xAB]), DataType::OCTET_STRING), "01 AB");
        assert_eq!(text(Value::VisibleString(b"K\xFCbler".to_vec()), DataType::VISIBLE_STRING), "K\u{FC}bler");
        assert_eq!(text(Value::VisibleString("5 €".into()), DataType::VISIBLE_STRING), "5 €");
        assert_eq!(text_of(&Setting::NodeIdPlus(0x180), DataType::UNSIGNED32).as_deref(), Some("$NODEID+0x180"));
        assert_eq!(text_of(&Setting::NodeIdPlus(0), DataType::UNSIGNED8).as_deref(), Some("$NODEID"));
    }

    #[test]
    fn what_would_be_read_otherwise_is_not_written() {
        for string in ["", " x", "x ", ";x", "a\nb", "a\x07"] {
            assert_eq!(text(Value::VisibleString(string.into()), DataType::VISIBLE_STRING), None, "{string:?}");
        }
        assert_eq!(text(Value::Unsigned(256), DataType::UNSIGNED8), None);
        assert_eq!(text(Value::Unsigned(1), DataType(0x17)), None);
        assert_eq!(text(Value::UnicodeString(vec![0xD800]), DataType::UNICODE_STRING), None);
    }

    proptest! {
        #[test]
        fn every_number_has_a_text(data_type in prop::sample::select(DataType::ALL.to_vec()), raw in any::<u64>()) {
            if let Some(value) = Value::from_raw(data_type, raw) {
                prop_assert!(text(value, data_type).is_some());
            }
        }
    }
}
