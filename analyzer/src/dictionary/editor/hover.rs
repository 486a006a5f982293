//! Hover texts.

use super::keys;
use super::navigate::{address_of_value, sections};
use crate::dictionary::data_type::DataType;
use crate::dictionary::names::{is_profile, object_name};
use crate::dictionary::source::{Field, FieldName, Source};
use crate::identity::Multiplexer;
use std::ops::Range;

/// A hover text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hover {
    /// The text in Markdown.
    pub text: String,
    /// The part of the file that the text explains.
    pub range: Range<usize>,
}

/// Explains an object by the standards' names, a field by CiA 306, a data type by its name.
pub fn hover(source: &Source<'_>, at: usize) -> Option<Hover> {
    let section = source.section_at(at)?;
    if section.name_span().range().end >= at {
        let (address, is_entry) = section.address()?;
        let own = section.field(FieldName::ParameterName).map(Field::value);
        return Some(Hover {
            text: object(address, is_entry, own, profile(source)),
            range: section.name_span().range(),
        });
    }
    let field = section.field_at(at)?;
    if at <= field.name_span().range().end {
        let key = keys::of(section).iter().find(|key| key.name.eq_ignore_ascii_case(field.name()))?;
        return Some(Hover { text: format!("**{}**: {}", key.name, key.meaning), range: field.name_span().range() });
    }
    let value = field.value();
    let text = if field.known() == Some(FieldName::DataType) {
        let index = address_of_value(value, false)?.index.0;
        format!("{index:04X}h: **{}**", DataType(index).name()?)
    } else {
        let mapped = address_of_value(value, true).or_else(|| address_of_value(value, false))?;
        let is_entry = value.len() > 6;
        let described = sections(source).find(|section| section.address().is_some_and(|(found, _)| found == mapped));
        let own = described.and_then(|section| section.field(FieldName::ParameterName)).map(Field::value);
        let name = object(mapped, is_entry, own, profile(source));
        match u8::from_str_radix(value.get(8..).unwrap_or_default(), 16) {
            Ok(bits) if is_entry => format!("{name}\n\nmapped with {bits} bits"),
            _ => name,
        }
    };
    Some(Hover { text, range: field.value_span().range() })
}

/// The hover text of an object: `**1018h:01** Vendor-ID`, with the standard's name, and its type and access if the
/// standard fixes them.
fn object(at: Multiplexer, is_entry: bool, own: Option<&str>, profile: Option<u16>) -> String {
    let mut text = if is_entry { format!("**{at}**") } else { format!("**{}**", at.index) };
    if let Some(own) = own {
        text += &format!(" {}", own.escape_debug());
    }
    let Some(known) = object_name(at, profile) else {
        return match at.index.0 {
            0x2000..=0x5FFF => text + "\n\nmanufacturer-specific (CiA 301, 7.4.1)",
            _ => text,
        };
    };
    text += &format!("\n\n{}: {known}", known.object.clause().brief());
    if let Some(entry) = known.entry {
        if let Some(name) = entry.data_type.and_then(DataType::name) {
            text += &format!(", {name}");
        }
        if let Some(access) = entry.access {
            text += &format!(", {access}");
        }
    }
    text
}

/// The device profile in the file: the low word of 1000h. It determines the names of the objects from 6000h on.
pub(super) fn profile(source: &Source<'_>) -> Option<u16> {
    let device_type = Multiplexer::new(crate::object::DEVICE_TYPE, 0);
    let section = sections(source).find(|section| section.address() == Some((device_type, false)))?;
    let value = section.field(FieldName::DefaultValue)?.value();
    let number = match value.strip_prefix("0x").or_else(|| value.strip_prefix("0X")) {
        Some(digits) => u32::from_str_radix(digits, 16).ok()?,
        None => value.parse().ok()?,
    };
    Some(number as u16).filter(|&profile| is_profile(profile))
}
