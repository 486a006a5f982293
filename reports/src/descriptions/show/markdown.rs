//! The description as an appendix of a manual.

use super::cells::{self, Cells};
use super::{AREAS, Shown, picture};
use crate::escape::{markdown, printable};
use canvass_analyzer::dictionary::Object;
use canvass_analyzer::dictionary::layout::PdoLayout;
use std::fmt::Write;

pub(super) fn document(shown: &Shown) -> String {
    let mut text = format!("# {}: object dictionary\n", markdown(shown.title()));
    for (first, last, area) in AREAS {
        let is_here = |object: &&Object| (first..=last).contains(&object.index.0);
        let mut objects = shown.objects().filter(is_here).peekable();
        if objects.peek().is_none() {
            continue;
        }
        // Writing to a string can't fail.
        let _ = writeln!(text, "\n## {area}\n");
        text.push_str("| object | name | type | access | PDO | default | limits |\n|---|---|---|---|---|---|---|\n");
        objects.for_each(|object| rows(shown, object, &mut text));
    }
    let layouts = shown.pdos();
    if !layouts.is_empty() {
        text.push_str("\n## PDOs\n\nAs delivered. In the pictures a character is a bit, bit 0 of each byte first.\n");
        layouts.iter().for_each(|layout| pdo(shown, layout, &mut text));
    }
    text
}

fn rows(shown: &Shown, object: &Object, text: &mut String) {
    let name = printable(&object.name);
    if !object.code.is_single() {
        let _ = writeln!(text, "| **{}** | **{}** | {} | | | | |", object.index, markdown(&name), object.code);
    }
    for entry in object.entries() {
        let cells = Cells::of(shown, object, entry);
        let (place, name) = match object.code.is_single() {
            true => (format!("**{}**", object.index), format!("**{}**", markdown(&name))),
            false => (format!("{}:{:02X}", object.index, entry.sub.0), markdown(&cells.name)),
        };
        let (default, limits) = (markdown(&cells.default), markdown(&cells.limits));
        let Cells { data_type, access, mapping, .. } = cells;
        let _ = writeln!(text, "| {place} | {name} | {data_type} | {access} | {mapping} | {default} | {limits} |");
    }
}

fn pdo(shown: &Shown, layout: &PdoLayout<'_>, text: &mut String) {
    let about = [cells::about(shown, layout), cells::transmission_type(layout)];
    let about: Vec<String> = about.iter().filter(|text| !text.is_empty()).map(|text| markdown(text)).collect();
    let _ = write!(text, "\n### {}\n\n{}.\n", layout.pdo, about.join("; "));
    let Some(fields) = layout.fields.as_ref().filter(|fields| !fields.is_empty()) else { return };
    let [bytes, bits] = picture::lines(fields);
    let _ = write!(text, "\n```text\n{bytes}\n{bits}\n```\n\n| | bits | object |\n|---|---|---|\n");
    for (number, field) in fields.iter().enumerate() {
        let object = markdown(&cells::field(field));
        let _ = writeln!(text, "| {} | {} | {object} |", picture::letter(number), cells::bits(field));
    }
}
