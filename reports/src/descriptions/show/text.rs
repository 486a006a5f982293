//! The description as text for people.

use super::cells::{self, Cells};
use super::{Shown, Style, at, picture, version};
use crate::color::Color;
use crate::escape::printable;
use canvass_analyzer::SubIndex;
use canvass_analyzer::dictionary::layout::PdoLayout;
use canvass_analyzer::dictionary::{Entry, Object};
use comfy_table::{Cell, Table};
use std::fmt::Write;

pub(super) fn render(shown: &Shown, style: Style) -> String {
    let mut text = String::new();
    match shown.only {
        Some(_) => shown.objects().for_each(|object| detail(shown, object, &mut text)),
        None => {
            head(shown, &mut text);
            // Writing to a string can't fail.
            let _ = writeln!(text, "{}", table(shown, style));
        }
    }
    pdos(&shown.pdos(), shown, style, &mut text);
    text
}

fn head(shown: &Shown, text: &mut String) {
    let (device, file) = (&shown.description.device, &shown.description.file);
    let vendor = if device.vendor_name.is_empty() { String::new() } else { format!(", {}", device.vendor_name) };
    let title = format!("{}{vendor}", shown.title());
    let count = shown.description.dictionary.objects().len();
    let version = if file.version.is_empty() { String::new() } else { format!(", version {}", version(file)) };
    let about = format!("{}{version}: {count} objects", shown.file);
    let _ = writeln!(text, "{}\n{}\n", printable(&title), printable(&about));
}

fn table(shown: &Shown, style: Style) -> Table {
    let mut table = crate::table::table(style.width, style.colors);
    let configured = shown.description.is_configuration();
    let mut header = vec!["object", "name", "type", "access", "PDO", "default", "limits"];
    header.extend(configured.then_some("configured"));
    table.set_header(header);
    for object in shown.objects() {
        let single = object.entries().first().filter(|_| object.code.is_single());
        let name = printable(&object.name).into_owned();
        match single {
            Some(entry) => {
                let cells = Cells { name, ..Cells::of(shown, object, entry) };
                table.add_row(row(object.index.to_string(), cells, true, configured));
            }
            None => {
                let name = Cell::new(short(name));
                let cells = [Color::Cyan.cell(Cell::new(object.index)), name, Cell::new(object.code)];
                table.add_row(cells);
                for entry in object.entries() {
                    let place = format!("   :{:02X}", entry.sub.0);
                    table.add_row(row(place, Cells::of(shown, object, entry), false, configured));
                }
            }
        }
    }
    table
}

fn row(place: String, cells: Cells, is_object: bool, configured: bool) -> Vec<Cell> {
    let place = Cell::new(place);
    let place = if is_object { Color::Cyan.cell(place) } else { place };
    let texts =
        [cells.name, cells.data_type, cells.access.to_owned(), cells.mapping.to_owned(), cells.default, cells.limits];
    let texts = texts.into_iter().chain(configured.then_some(cells.configured));
    std::iter::once(place).chain(texts.map(|text| Cell::new(short(text)))).collect()
}

/// Maximum number of characters in a cell of the table. The details of one object have the whole text.
const LONGEST: usize = 300;

/// A text as it stands in a cell: folding hundreds of kilobytes into a narrow column would take minutes.
fn short(text: String) -> String {
    match text.char_indices().nth(LONGEST) {
        None => text,
        Some((end, _)) => {
            format!("{}… ({} characters)", text.get(..end).unwrap_or_default(), text.chars().count())
        }
    }
}

fn detail(shown: &Shown, object: &Object, text: &mut String) {
    let name = printable(&object.name);
    let _ = writeln!(text, "{} {name}: {}", object.index, object.code);
    let whole = shown.standard(at(object, SubIndex(0))).map(|name| name.object);
    if let Some(standard) = whole {
        let _ = writeln!(text, "  {}: {}, {}", standard.clause().brief(), standard.name, standard.code);
    }
    if object.line > 0 {
        let _ = writeln!(text, "  {}, line {}", printable(&shown.file), object.line);
    }
    for entry in object.entries() {
        let _ = writeln!(text, "\n  {} {}", at(object, entry.sub), printable(&entry.name));
        for (head, value) in facts(shown, object, entry).into_iter().filter(|(_, value)| !value.is_empty()) {
            let _ = writeln!(text, "    {head:<11}{value}");
        }
    }
}

/// The facts of an entry. A fact that is not known has an empty text.
fn facts(shown: &Shown, object: &Object, entry: &Entry) -> [(&'static str, String); 9] {
    let cells = Cells::of(shown, object, entry);
    let bytes = entry.data_type.bits().map_or_else(String::new, |bits| match bits {
        1 => ", 1 bit".to_owned(),
        bits => format!(", {bits} bits"),
    });
    let mapping = if cells.mapping.is_empty() { "can't be mapped" } else { cells.mapping };
    let denotation = entry.denotation.as_deref().map(printable).unwrap_or_default().into_owned();
    let flags = match (entry.flags.refuses_write_on_download(), entry.flags.refuses_read_on_scan()) {
        (false, false) => "",
        (true, false) => "not to be written in a download",
        (false, true) => "not to be read in a scan",
        (true, true) => "not to be written in a download, not to be read in a scan",
    };
    [
        ("type", format!("{}{bytes}", cells.data_type)),
        ("access", cells.access.to_owned()),
        ("PDO", mapping.to_owned()),
        ("default", cells.default),
        ("limits", cells.limits),
        ("configured", cells.configured),
        ("means", denotation),
        ("flags", flags.to_owned()),
        ("standard", cells::standard(shown, at(object, entry.sub))),
    ]
}

fn pdos(layouts: &[PdoLayout<'_>], shown: &Shown, style: Style, text: &mut String) {
    // The picture is no wider than a page, even on a wider terminal.
    let width = usize::from(style.width).min(80);
    for layout in layouts {
        let _ = writeln!(text, "\n{}: {}", layout.pdo, cells::about(shown, layout));
        let transmission = cells::transmission_type(layout);
        if !transmission.is_empty() {
            let _ = writeln!(text, "  {transmission}");
        }
        let Some(fields) = layout.fields.as_ref().filter(|fields| !fields.is_empty()) else { continue };
        for line in picture::lines(fields) {
            let _ = writeln!(text, "  {line}");
        }
        for (number, field) in fields.iter().enumerate() {
            let line = format!("  {}    {:<14} {}", picture::letter(number), cells::bits(field), cells::field(field));
            let _ = writeln!(text, "{}", cut(&line, width));
        }
    }
}

fn cut(line: &str, width: usize) -> String {
    if line.chars().count() <= width {
        return line.to_owned();
    }
    line.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}
