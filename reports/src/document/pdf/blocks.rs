//! The blocks of a document, one below the other.

use super::flow::{BODY, Flow, Style};
use super::fonts::Typeface;
use super::table::table;
use crate::document::{Block, Code, Column, Document, Fact, Finding, Row, Section, Table, Tone};
use crate::page_text::capitalised;

const TITLE: Style = Style::new(Typeface::Bold, 17.0);
const HEADING: Style = Style::new(Typeface::Bold, 12.0);
const SMALL: Style = Style::new(Typeface::Regular, 8.0);
const MONO: Style = Style::new(Typeface::Mono, 7.0);
const STRONG: Style = Style::new(Typeface::Bold, 9.0);

pub(super) fn title(flow: &mut Flow<'_>, document: &Document) {
    flow.paragraph(SMALL.tone(Tone::Faint), document.kind);
    flow.paragraph(TITLE, &document.title);
    flow.space(3.0);
    flow.paragraph(Style::new(Typeface::Bold, 10.5).tone(document.tone), &capitalised(&document.outcome));
    flow.space(6.0);
}

/// The head of the appendix, with what the first page has in short.
pub(super) fn appendix(flow: &mut Flow<'_>, document: &Document) {
    flow.paragraph(TITLE, "Appendix");
    flow.space(6.0);
    facts(flow, &document.facts);
    blocks(flow, &document.summary);
}

pub(super) fn section(flow: &mut Flow<'_>, section: &Section) {
    if section.blocks.iter().all(|block| matches!(block, Block::Markup(_))) {
        return;
    }
    flow.space(9.0);
    // A heading is not left alone at the end of a page.
    flow.need(HEADING.line() + 3.0 * BODY.line());
    flow.paragraph(HEADING, &section.title);
    flow.space(3.0);
    blocks(flow, &section.blocks);
}

pub(super) fn blocks(flow: &mut Flow<'_>, blocks: &[Block]) {
    blocks.iter().for_each(|one| block(flow, one));
}

fn block(flow: &mut Flow<'_>, block: &Block) {
    match block {
        Block::Text(text) => text.split("\n\n").for_each(|text| flow.paragraph(BODY, &capitalised(text))),
        Block::Note(text) => flow.paragraph(BODY.tone(Tone::Doubt), &format!("Note: {text}")),
        Block::Items(items) => items.iter().for_each(|item| flow.paragraph(BODY, &format!("• {item}"))),
        Block::Words(words) => flow.paragraph(SMALL, &words.join(", ")),
        Block::Facts(named) => facts(flow, named),
        Block::Table(one) => table(flow, one),
        Block::Code(one) => code(flow, one),
        Block::Fold { title, blocks, .. } => {
            flow.need(3.0 * BODY.line());
            flow.paragraph(STRONG, &capitalised(title));
            flow.indented(10.0, |flow| self::blocks(flow, blocks));
        }
        Block::Finding(one) => finding(flow, one),
        Block::Markup(_) => return,
    }
    flow.space(3.0);
}

/// Names and values as a table without a head.
pub(super) fn facts(flow: &mut Flow<'_>, facts: &[Fact]) {
    if facts.is_empty() {
        return;
    }
    let rows = facts.iter().map(|(name, value)| Row::of([capitalised(name), value.clone()]));
    table(flow, &Table::new([Column::new(""), Column::new("")], rows));
    flow.space(3.0);
}

fn code(flow: &mut Flow<'_>, code: &Code) {
    if !code.title.is_empty() {
        flow.paragraph(SMALL.tone(Tone::Faint), &capitalised(code.title));
    }
    code.text.lines().for_each(|line| flow.paragraph(MONO, line));
}

fn finding(flow: &mut Flow<'_>, finding: &Finding) {
    flow.space(3.0);
    flow.need(3.0 * BODY.line());
    let Finding { badge, title, id, tone, body, .. } = finding;
    let head = [&**badge, &**title].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("  ");
    flow.paragraph(STRONG.tone(*tone), &head);
    flow.indented(10.0, |flow| {
        if !id.is_empty() {
            flow.paragraph(SMALL.tone(Tone::Faint), id);
        }
        blocks(flow, body);
    });
}
