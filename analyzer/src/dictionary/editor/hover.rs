//! What stands under the cursor.

use super::keys;
use super::layout::{Section, address_of_value, section_at, sections};
use crate::dictionary::check::Source;
use crate::dictionary::data_type::DataType;
use crate::dictionary::names::{ENCODER_PROFILE, object_name};
use crate::identity::Multiplexer;
use std::ops::Range;

/// What is shown for a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hover {
    /// Markdown.
    pub text: String,
    /// What it is about.
    pub range: Range<usize>,
}

/// What is known of what stands there: an object by the standards' names, a field by CiA 306, a data type by its name.
pub fn hover(text: &str, at: usize) -> Option<Hover> {
    let source = Source::new(text);
    let sections = sections(&source);
    let section = section_at(&sections, at)?;
    if at <= section.name.end {
        let (address, is_entry) = section.address(&source)?;
        let shown = object(address, is_entry, section.value(&source, "ParameterName"), profile(&source, &sections));
        return Some(Hover { text: shown, range: section.name.clone() });
    }
    let field = section.fields(&source).find(|field| (field.name.start..=field.value.end).contains(&at))?;
    let (name, value) = (source.get(&field.name), source.get(&field.value));
    if at <= field.name.end {
        let key = keys::of(&source, section).iter().find(|key| key.name.eq_ignore_ascii_case(name))?;
        return Some(Hover { text: format!("**{}**: {}", key.name, key.meaning), range: field.name });
    }
    let text = if name.eq_ignore_ascii_case("DataType") {
        let index = address_of_value(value, false)?.index.0;
        format!("{index:04X}h: **{}**", DataType(index).name()?)
    } else {
        let mapped = address_of_value(value, true).or_else(|| address_of_value(value, false))?;
        let is_entry = value.trim().len() > 6;
        let described = |section: &&Section| section.address(&source).is_some_and(|(found, _)| found == mapped);
        let own = sections.iter().find(described).and_then(|section| section.value(&source, "ParameterName"));
        let name = object(mapped, is_entry, own, profile(&source, &sections));
        match u8::from_str_radix(value.trim().get(8..).unwrap_or_default(), 16) {
            Ok(bits) if is_entry => format!("{name}\n\nmapped with {bits} bits"),
            _ => name,
        }
    };
    Some(Hover { text, range: field.value })
}

/// `**1018h:01** Vendor-ID`, with the standard's name, its type and its access where these are fixed.
fn object(at: Multiplexer, is_entry: bool, own: Option<&str>, profile: Option<u16>) -> String {
    let mut text = if is_entry { format!("**{at}**") } else { format!("**{}**", at.index) };
    if let Some(own) = own {
        text += &format!(" {}", own.escape_debug());
    }
    let Some(known) = object_name(at, profile) else {
        return match at.index.0 {
            0x2000..=0x5FFF => text + "\n\nof the manufacturer (CiA 301, 7.4.1)",
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

/// The device profile: the low word of 1000h as it is described. Names of encoders where it is theirs.
pub(super) fn profile(source: &Source<'_>, sections: &[Section]) -> Option<u16> {
    let device_type = Multiplexer::new(crate::object::DEVICE_TYPE, 0);
    let section = sections.iter().find(|section| section.address(source) == Some((device_type, false)))?;
    let value = section.value(source, "DefaultValue")?.trim();
    let number = match value.strip_prefix("0x").or_else(|| value.strip_prefix("0X")) {
        Some(digits) => u32::from_str_radix(digits, 16).ok()?,
        None => value.parse().ok()?,
    };
    Some(number as u16).filter(|&profile| profile == ENCODER_PROFILE)
}
