//! Reads single fields: texts, numbers, flags, and values of a data type.

use super::number;
use crate::dictionary::data_type::{DataClass, DataType};
use crate::dictionary::object::Setting;
use crate::dictionary::place::Place;
use crate::dictionary::problem::Problems;
use crate::dictionary::rules::{self, Rule, number as number_rules};
use crate::dictionary::source::{Field, FieldName, Section};
use crate::dictionary::value::{DaysAndMilliseconds, Value};

/// The fields of one section, and the list of problems.
pub(super) struct Fields<'s, 'p> {
    pub section: Section<'s>,
    pub problems: &'p mut Problems,
}

impl<'s> Fields<'s, '_> {
    /// Reports a problem of a field.
    pub fn report(&mut self, field: FieldName, rule: &'static Rule, expected: &'static str, found: &str) {
        self.problems.report(self.section.place_of(field), rule, expected, found);
    }

    /// Reports a problem of the section as a whole.
    pub(crate) fn report_section(&mut self, rule: &'static Rule, expected: &'static str, found: &str) {
        self.problems.report(self.section.place(), rule, expected, found);
    }

    /// The text of an optional field.
    pub(crate) fn optional_text(&self, field: FieldName) -> Option<&'s str> {
        self.section.field(field).map(|field| field.value())
    }

    /// The text of a field, empty if it is missing.
    pub fn text(&self, field: FieldName) -> &'s str {
        self.optional_text(field).unwrap_or_default()
    }

    /// A number from 0 to `most`, in any of the allowed forms; `None` if the field is missing, empty or wrong.
    pub fn number(&mut self, field: FieldName, most: u32) -> Option<u32> {
        let found = self.section.field(field)?;
        number_in(found.value(), most, self.place(found, field.text()), self.problems)
    }

    /// A flag, 0 or 1; `false` if the field is missing or wrong.
    pub fn flag(&mut self, field: FieldName) -> bool {
        let found = self.section.field(field);
        found.is_some_and(|found| flag_in(found.value(), self.place(found, field.text()), self.problems))
    }

    /// A value of the data type, or a formula; `None` if the field is missing, empty or wrong.
    pub fn setting(&mut self, field: FieldName, data_type: DataType) -> Option<Setting> {
        let found = self.section.field(field)?;
        setting(found.value(), data_type, self.place(found, field.text()), self.problems)
    }

    /// The place of a field that the section has.
    fn place(&self, found: Field<'s>, field: &'s str) -> Place<'s> {
        Place { field, ..found.place() }
    }

    /// Reports fields that the section should not have.
    pub(crate) fn check_known(&mut self, known: impl Fn(Field<'_>) -> bool) {
        for field in self.section.fields() {
            if !known(field) {
                let expected = "a field that CiA 306 defines here";
                self.problems.report(field.place_of_name(), &rules::field::UNKNOWN, expected, field.name());
            }
        }
    }
}

/// A number from 0 to `most`, in any of the allowed forms; `None` if the text is empty or wrong.
fn number_in(text: &str, most: u32, place: Place<'_>, problems: &mut Problems) -> Option<u32> {
    if is_nothing(text) {
        return None;
    }
    let Some(number) = number::parse(text).filter(|number| !number.plus_node_id) else {
        problems.report(place, &number_rules::UNREADABLE, "a number", text);
        return None;
    };
    if let Some(oddity) = number.oddity {
        problems.report(place, oddity.rule, oddity.expected, text);
    }
    let value = u32::try_from(number.value).ok().filter(|&value| value <= most);
    if value.is_none() {
        problems.report(place, &rules::field::RANGE, "a number in the range of the field", text);
    }
    value
}

/// A flag, 0 or 1; `false` if the text is wrong.
pub(super) fn flag_in(text: &str, place: Place<'_>, problems: &mut Problems) -> bool {
    let word = ["false", "no", "true", "yes"].iter().position(|word| text.eq_ignore_ascii_case(word));
    if let Some(position) = word {
        problems.report(place, &rules::field::FLAG, "0 or 1", text);
        return position > 1;
    }
    let value = number_in(text, u32::MAX, place, problems).unwrap_or(0);
    if value > 1 {
        problems.report(place, &rules::field::FLAG, "0 or 1", text);
    }
    value != 0
}

/// Whether the text is empty or only a comment.
fn is_nothing(text: &str) -> bool {
    matches!(text.as_bytes(), [] | [b';', ..])
}

/// The text as a value of the data type, or a formula; `None` if it is empty or wrong.
pub(in crate::dictionary) fn setting(
    text: &str,
    data_type: DataType,
    place: Place<'_>,
    problems: &mut Problems,
) -> Option<Setting> {
    let text = text.trim();
    if is_nothing(text) {
        return None;
    }
    let value = match data_type.class()? {
        DataClass::Boolean | DataClass::Integer | DataClass::Unsigned => {
            return integral(text, data_type, place, problems);
        }
        DataClass::Real => real(text, data_type),
        DataClass::VisibleString => Some(Value::VisibleString(characters(text))),
        DataClass::UnicodeString => Some(Value::UnicodeString(text.encode_utf16().collect())),
        DataClass::OctetString => octets(text).map(Value::OctetString),
        DataClass::Domain => Some(Value::Domain(octets(text).unwrap_or_else(|| characters(text)))),
        DataClass::TimeOfDay | DataClass::TimeDifference => days(text, data_type).or_else(|| {
            let raw = number::parse(text).filter(|number| !number.plus_node_id);
            raw.and_then(|number| u64::try_from(number.value).ok()).and_then(|raw| Value::from_raw(data_type, raw))
        }),
        DataClass::Record => return None,
    };
    if value.is_none() {
        problems.report(place, &number_rules::UNREADABLE, "a value of the data type", text);
    }
    value.map(Setting::Fixed)
}

/// Parses `365 43200000`: days and milliseconds separately, as lely-core writes a time.
fn days(text: &str, data_type: DataType) -> Option<Value> {
    let mut words = text.split_ascii_whitespace();
    let (days, milliseconds) = (words.next()?.parse::<u16>().ok()?, words.next()?.parse::<u32>().ok()?);
    let is_whole = words.next().is_none() && milliseconds < 1 << 28;
    let raw = DaysAndMilliseconds { days, milliseconds }.to_raw();
    if is_whole { Value::from_raw(data_type, raw) } else { None }
}

fn integral(text: &str, data_type: DataType, place: Place<'_>, problems: &mut Problems) -> Option<Setting> {
    let word = ["false", "true"].iter().position(|word| text.eq_ignore_ascii_case(word));
    if let (DataType::BOOLEAN, Some(position)) = (data_type, word) {
        problems.report(place, &number_rules::FORM, "0 or 1", text);
        return Some(Setting::Fixed(Value::Boolean(position == 1)));
    }
    let Some(number) = number::parse(text) else {
        problems.report(place, &number_rules::UNREADABLE, "a number", text);
        return None;
    };
    if let Some(oddity) = number.oddity {
        problems.report(place, oddity.rule, oddity.expected, text);
    }
    let setting = if number.plus_node_id {
        // The formula must also fit for the highest node-ID.
        let bits = data_type.bits()?;
        let most = u32::MAX >> 32u32.saturating_sub(bits);
        let offset = u32::try_from(number.value).ok();
        offset.filter(|offset| offset.checked_add(127).is_some_and(|sum| sum <= most)).map(Setting::NodeIdPlus)
    } else {
        in_range(number.value, text, data_type, place, problems).map(Setting::Fixed)
    };
    if setting.is_none() {
        // A limit outside the range of the data type excludes no value, or all of them.
        let is_limit = ["lowlimit", "highlimit"].iter().any(|limit| place.field.eq_ignore_ascii_case(limit));
        let rule = if is_limit { &rules::entry::LIMIT_RANGE } else { &number_rules::RANGE };
        problems.report(place, rule, "a number that fits the data type", text);
    }
    setting
}

/// The number in the data type. A negative number of an unsigned type, or a number of a signed type that only fits
/// unsigned, gives the value with the same bits: negative numbers are usually written in hexadecimal.
fn in_range(number: i128, text: &str, data_type: DataType, place: Place<'_>, problems: &mut Problems) -> Option<Value> {
    let all: i128 = 1 << data_type.bits()?;
    if number >= all || number < -all / 2 {
        return None;
    }
    let signed = data_type.class() == Some(DataClass::Integer);
    let hexadecimal = text.starts_with("0x") || text.starts_with("0X");
    let wrapped = if signed { number >= all / 2 && !hexadecimal } else { number < 0 };
    if wrapped {
        let expected = "a number that fits the data type without wrapping";
        problems.report(place, &number_rules::WRAPPED, expected, text);
    }
    Value::from_raw(data_type, number as u64)
}

/// Parses a decimal number, or the bits in hexadecimal.
fn real(text: &str, data_type: DataType) -> Option<Value> {
    let text = text.split(';').next()?.trim();
    if text.starts_with("0x") || text.starts_with("0X") {
        let raw = u64::try_from(number::parse(text)?.value).ok()?;
        return Value::from_raw(data_type, raw);
    }
    let number: f64 = text.replace(',', ".").parse().ok()?;
    Some(if data_type == DataType::REAL32 { Value::Real32(number as f32) } else { Value::Real64(number) })
}

/// The bytes of a string: its characters in Latin-1 if Latin-1 has all of them, since the file had these bytes.
fn characters(text: &str) -> Vec<u8> {
    let latin_1: Option<Vec<u8>> = text.chars().map(|character| u8::try_from(character).ok()).collect();
    latin_1.unwrap_or_else(|| text.as_bytes().to_vec())
}

/// Parses pairs of hexadecimal digits, with or without blanks and `0x` before them.
fn octets(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    for word in text.split_whitespace() {
        let digits = word.trim_start_matches("0x");
        match digits.len() {
            1 => bytes.push(u8::from_str_radix(digits, 16).ok()?),
            _ => bytes.extend(canvass_traces::hex::parse(digits)?),
        }
    }
    Some(bytes)
}
