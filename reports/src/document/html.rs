//! A document as one self-contained HTML page.
//!
//! Every text from outside goes through [`printable`] and through maud, which escapes markup.

use super::{Align, Block, Cell, Code, Document, Fact, Finding, Row, Section, Table};
use crate::escape::printable;
use crate::page::{self, Page, fact};
use crate::page_text::capitalised;
use maud::{Markup, PreEscaped, Render, html};
use std::io::{self, Write};

/// Writes the page, section by section.
///
/// # Errors
/// The errors of `out`.
pub(super) fn render(document: &Document, out: &mut dyn Write) -> io::Result<()> {
    let all = || document.front.iter().chain(&document.sections).chain(&document.about);
    let titles: Vec<(&str, &str)> = all().map(|section| (section.id, &*section.title)).collect();
    let page = Page {
        title: &format!("{}: {}", printable(&document.title), document.command),
        styles: document.page.styles,
        scripts: document.page.scripts,
        header: head(document),
        sections: &titles,
        footer: html! { (document.page.footer) @if document.page.data.is_some() { (page::plot_licence()) } },
    };
    page::write(&page, out, |out| {
        all().try_for_each(|section| page::put(out, self::section(section)))?;
        document.page.data.as_ref().map_or(Ok(()), |data| page::put_data(out, "data", data))
    })
}

fn head(document: &Document) -> Markup {
    html! {
        p.kicker { (document.kind) }
        h1 { (printable(&document.title)) }
        p.outcome.(document.tone.class()) { (printable(&document.outcome)) }
        @if !document.facts.is_empty() {
            dl.facts { @for (name, value) in &document.facts { (fact(&capitalised(&printable(name)), value)) } }
        }
        (blocks(&document.summary))
    }
}

/// A section, for pages that contain more than a document.
pub(crate) fn section(section: &Section) -> Markup {
    html! {
        section aria-labelledby=(section.id) {
            h2 id=(section.id) { (section.title) }
            (blocks(&section.blocks))
        }
    }
}

fn blocks(blocks: &[Block]) -> Markup {
    html! { @for block in blocks { (self::block(block)) } }
}

fn block(block: &Block) -> Markup {
    match block {
        Block::Text(text) => html! { @for text in text.split("\n\n") { p { (capitalised(&printable(text))) } } },
        Block::Note(text) => html! { p.note { (printable(text)) } },
        Block::Items(items) => html! { ul { @for item in items { li { (printable(item)) } } } },
        Block::Words(words) => html! { p { (printable(&words.join(", "))) } },
        Block::Facts(facts) => named_values(facts),
        Block::Table(table) => self::table(table),
        Block::Code(code) => self::code(code),
        Block::Fold { title, is_open, blocks } => {
            html! { details open[*is_open] { summary { (capitalised(&printable(title))) } (self::blocks(blocks)) } }
        }
        Block::Finding(finding) => self::finding(finding),
        Block::Markup(markup) => markup.clone(),
    }
}

fn named_values(facts: &[Fact]) -> Markup {
    html! {
        dl.reason { @for (name, value) in facts { dt { (printable(name)) } dd { (printable(value)) } } }
    }
}

fn table(table: &Table) -> Markup {
    let has_head = table.columns.iter().any(|column| !column.name.is_empty());
    html! {
        div.card.scroll.sheet { table.(table.class) {
            @if has_head {
                thead { tr { @for column in &table.columns {
                    th.number[column.align == Align::Right] scope="col" { (printable(&column.name)) }
                } } }
            }
            tbody { @for row in &table.rows { (self::row(table, row)) } }
        } }
    }
}

fn row(table: &Table, row: &Row) -> Markup {
    let data = row.data.iter().map(|(name, value)| format!(" data-{name}=\"{}\"", escaped(&printable(value))));
    let id = if row.anchor.is_empty() { String::new() } else { format!(" id=\"{}\"", escaped(&row.anchor)) };
    html! {
        (PreEscaped(format!("<tr class=\"{}\"{id}{}>", row.tone.class(), data.collect::<String>())))
        @for (cell, column) in row.cells.iter().zip(&table.columns) { (self::cell(cell, column.align == Align::Right)) }
        (PreEscaped("</tr>"))
    }
}

fn escaped(text: &str) -> String {
    text.render().into_string()
}

/// A cell. A sign has its meaning as a title, for those who can't see it.
fn cell(cell: &Cell, is_number: bool) -> Markup {
    let (text, title) = (printable(&cell.text), printable(&cell.title));
    let named = (!title.is_empty()).then_some(&title);
    html! {
        td.(cell.class).(cell.tone.class()).number[is_number] title=[named] {
            @if !cell.link.is_empty() { a href=(cell.link) { (text) } }
            @else if let Some(title) = named { span aria-hidden="true" { (text) } span.unseen { (title) } }
            @else { (text) }
        }
    }
}

fn code(code: &Code) -> Markup {
    let lines: Vec<_> = code.text.lines().map(printable).collect();
    html! {
        @if code.title.is_empty() { pre { (lines.join("\n")) } }
        @else { details { summary { (capitalised(code.title)) } pre { (lines.join("\n")) } } }
    }
}

fn finding(finding: &Finding) -> Markup {
    let kind = (!finding.data_kind.is_empty()).then_some(finding.data_kind);
    let anchor = (!finding.anchor.is_empty()).then_some(&finding.anchor);
    html! {
        details.finding.card.(finding.tone.class()) id=[anchor] data-kind=[kind] open[finding.is_open] {
            summary {
                span.badge { (printable(&finding.badge)) }
                span.title { (printable(&finding.title)) }
                span.id { (printable(&finding.id)) }
            }
            div.body { (blocks(&finding.body)) }
        }
    }
}
