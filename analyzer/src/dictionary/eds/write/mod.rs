//! Writes an EDS, or a DCF if the description is of a configured device.

mod header;
mod modules;
mod objects;
mod value;

pub(in crate::dictionary) use value::text_of;

use super::lists::list_of;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::loss::{Loss, Losses};

/// The text of a file that reads as this description, and the parts of the description that the file can't hold.
pub fn write(description: &DeviceDescription) -> (String, Vec<Loss>) {
    let mut sheet = Sheet::default();
    header::write(&mut sheet, description);
    modules::write(&mut sheet, description);
    for list in ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"] {
        let of_list = description.dictionary.objects().iter().filter(|object| list_of(object.index.0) == list);
        let described: Vec<_> = of_list.collect();
        let indexes: Vec<u16> = described.iter().map(|object| object.index.0).collect();
        sheet.section(list);
        sheet.list("SupportedObjects", &indexes);
        for object in described {
            objects::write(&mut sheet, object, &format!("{:04X}", object.index.0));
        }
    }
    lost_lists(&mut sheet.losses, description);
    (sheet.text, sheet.losses.0)
}

/// Reports listed objects that are not described.
fn lost_lists(losses: &mut Losses, description: &DeviceDescription) {
    let lists = &description.lists;
    for &(index, line) in lists.mandatory.iter().chain(&lists.optional).chain(&lists.manufacturer) {
        if description.dictionary.object(index).is_none() {
            losses.no_place(line, "an object that is listed and not described", &index.to_string());
        }
    }
}

/// The part of the file written so far.
#[derive(Default)]
struct Sheet {
    text: String,
    losses: Losses,
    section: String,
}

impl Sheet {
    fn section(&mut self, name: &str) {
        if !self.text.is_empty() {
            self.text.push_str("\r\n");
        }
        name.clone_into(&mut self.section);
        self.push(&["[", name, "]"]);
    }

    /// Writes a field with a value that needs no check.
    fn field(&mut self, name: &str, value: &str) {
        self.push(&[name, "=", value]);
    }

    /// Writes a text of the description; `line` is its line in the original file.
    fn text(&mut self, name: &str, value: &str, line: u32) {
        let place = format!("[{}] {name}", self.section);
        let value = self.losses.line(line, &place, value);
        self.field(name, &value);
    }

    fn flag(&mut self, name: &str, value: bool) {
        self.field(name, if value { "1" } else { "0" });
    }

    fn number(&mut self, name: &str, value: impl Into<u32>) {
        self.field(name, &value.into().to_string());
    }

    /// Writes a number in hexadecimal, or nothing if it is unknown.
    fn code(&mut self, name: &str, value: Option<u32>) {
        if let Some(value) = value {
            self.field(name, &format!("0x{value:X}"));
        }
    }

    /// Writes a list `1=0x1000`, `2=0x1001`… with its count.
    fn list(&mut self, count: &str, indexes: &[u16]) {
        self.field(count, &indexes.len().to_string());
        for (number, index) in (1..).zip(indexes) {
            self.field(&u32::to_string(&number), &format!("0x{index:04X}"));
        }
    }

    fn push(&mut self, parts: &[&str]) {
        parts.iter().for_each(|part| self.text.push_str(part));
        self.text.push_str("\r\n");
    }
}
