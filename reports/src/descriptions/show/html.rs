//! A self-contained page with a search as you type. It can also be printed.

use super::cells::{self, Cells};
use super::{AREAS, Shown, at, picture, version};
use crate::escape::printable;
use crate::page::{self, Page};
use canvass_analyzer::dictionary::Object;
use canvass_analyzer::dictionary::layout::{PdoField, PdoLayout};
use maud::{Markup, html};
use std::io::{self, Write};

const STYLE: &str = include_str!("../../../assets/description.css");
const SCRIPT: &str = include_str!("../../../assets/description.js");

pub(super) fn render(shown: &Shown, out: &mut dyn Write) -> io::Result<()> {
    let title = printable(shown.title());
    let page = Page {
        title: &format!("{title}: object dictionary"),
        styles: &[STYLE],
        scripts: &[SCRIPT],
        header: head(shown),
        sections: &[("pdos", "PDOs"), ("objects", "Objects")],
        footer: html! { "From " (printable(&shown.file)) ". Values are those after a start with nothing stored." },
    };
    page::write(&page, out, |out| {
        page::put(out, pdos(shown))?;
        page::put(out, html! { h2 #objects { "Objects" } (search()) })?;
        for (first, last, area) in AREAS {
            let objects: Vec<&Object> =
                shown.objects().filter(|object| (first..=last).contains(&object.index.0)).collect();
            if !objects.is_empty() {
                page::put(out, table(shown, area, &objects))?;
            }
        }
        Ok(())
    })
}

fn head(shown: &Shown) -> Markup {
    let (device, file) = (&shown.description.device, &shown.description.file);
    let hex = |number: Option<u32>| number.map(|number| format!("{number:08X}h")).unwrap_or_default();
    let rates: Vec<String> = device.bit_rates.iter().map(u16::to_string).collect();
    let rates = if rates.is_empty() { String::new() } else { format!("{} kbit/s", rates.join(", ")) };
    let facts = [
        ("Vendor", device.vendor_name.clone()),
        ("Vendor-ID", hex(device.vendor_number)),
        ("Product code", hex(device.product_number)),
        ("Revision", hex(device.revision_number)),
        ("Order code", device.order_code.clone()),
        ("Device profile", shown.description.device_profile().map(|profile| profile.to_string()).unwrap_or_default()),
        ("Bit rates", rates),
        ("File version", version(file)),
        ("Node-ID", shown.node.map(|node| node.to_string()).unwrap_or_default()),
    ];
    html! {
        p.kicker { "CANopen object dictionary" }
        h1 { (printable(shown.title())) }
        p.outcome { (shown.objects().count()) " objects" }
        dl.facts {
            @for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
                (page::fact(name, value))
            }
        }
    }
}

fn search() -> Markup {
    html! {
        div.filter {
            input #filter type="search" placeholder="Filter by index, name or type" aria-label="Filter";
            span #shown aria-live="polite" {}
        }
    }
}

fn table(shown: &Shown, area: &str, objects: &[&Object]) -> Markup {
    html! {
        section.area {
            h3 { (area) }
            div.scroll { table.objects {
                thead { tr {
                    @for head in ["Object", "Name", "Type", "Access", "PDO", "Default", "Limits"] { th scope="col" { (head) } }
                    @if shown.description.is_configuration() { th scope="col" { "Configured" } }
                } }
                @for object in objects { (rows(shown, object)) }
            } }
        }
    }
}

/// The rows of an object. Each object is a table body, so that the filter shows or hides it as a whole.
fn rows(shown: &Shown, object: &Object) -> Markup {
    let single = object.code.is_single();
    html! {
        tbody id={ "o" (anchor(object)) } {
            @if !single {
                tr.object {
                    th scope="row" { (object.index) }
                    td.text title=(cells::standard(shown, at(object, canvass_analyzer::SubIndex(0)))) { (printable(&object.name)) }
                    td { (object.code) } td {} td {} td {} td {}
                }
            }
            @for entry in object.entries() {
                @let cells = Cells::of(shown, object, entry);
                tr.object[single] {
                    @if single { th scope="row" { (object.index) } } @else { td.sub { ":" (format!("{:02X}", entry.sub.0)) } }
                    td.text title=(cells::standard(shown, at(object, entry.sub))) {
                        @if single { (printable(&object.name)) } @else { (cells.name) }
                    }
                    td { (cells.data_type) }
                    td { (cells.access) }
                    td { (cells.mapping) }
                    td.value { (cells.default) }
                    td.value { (cells.limits) }
                    @if shown.description.is_configuration() { td.value { (cells.configured) } }
                }
            }
        }
    }
}

fn anchor(object: &Object) -> String {
    format!("{:04X}", object.index.0)
}

fn pdos(shown: &Shown) -> Markup {
    let layouts = shown.pdos();
    html! {
        section {
            h2 #pdos { "PDOs" }
            @if layouts.is_empty() { p { "None is described." } }
            @for layout in &layouts { (pdo(shown, layout)) }
        }
    }
}

fn pdo(shown: &Shown, layout: &PdoLayout<'_>) -> Markup {
    let fields: &[PdoField<'_>] = layout.fields.as_deref().unwrap_or_default();
    html! {
        article.card.pdo {
            h3 { (layout.pdo) }
            p.hint { (cells::about(shown, layout)) br; (cells::transmission_type(layout)) }
            @if !fields.is_empty() {
                (drawing(fields))
                div.scroll { table { tbody {
                    @for (number, field) in fields.iter().enumerate() {
                        tr {
                            td { (picture::letter(number)) }
                            td { (cells::bits(field)) }
                            td.text {
                                @if field.entry.is_some() {
                                    a href={ "#o" (format!("{:04X}", field.mapped.object().index.0)) } { (cells::field(field)) }
                                } @else { (cells::field(field)) }
                            }
                        }
                    }
                } } }
            }
        }
    }
}

/// A drawing of the bytes as columns, with bit 0 of each byte first. The drawing is as wide as its place.
fn drawing(fields: &[PdoField<'_>]) -> Markup {
    /// The width of a bit in the drawing.
    const BIT: u32 = 10;
    let bytes = fields.last().map_or(0, PdoField::end).div_ceil(8);
    let width = bytes * 8 * BIT;
    let middle = |field: &PdoField<'_>| (field.offset + field.end()) * BIT / 2;
    html! {
        svg.layout viewBox={ "0 0 " (width) " 46" } role="img" aria-label="Layout of the PDO, bit 0 of each byte first"
            width=(width) height="46" {
            @for byte in 0..bytes {
                text.byte x=(byte * 8 * BIT + 2) y="10" { "byte " (byte) }
                rect.byte x=(byte * 8 * BIT) y="14" width=(8 * BIT) height="30" {}
            }
            @for (number, field) in fields.iter().enumerate() {
                rect.field x=(field.offset * BIT) y="16" width=(u32::from(field.mapped.bits()) * BIT) height="26" {
                    title { (cells::field(field)) }
                }
                text.letter x=(middle(field)) y="34" { (picture::letter(number)) }
            }
        }
    }
}
