//! A document on a terminal: the findings come first and the outcome last, because the end stays visible.

use super::{Align, Block, Cell, Code, Document, Fact, Finding, Row, Style, Table, Tone};
use crate::color;
use crate::escape::{Visible, printable};
use crate::page_text::packed;
use crate::table;
use comfy_table::CellAlignment;
use std::io::{self, Write};

/// The width in columns for a file, which has no width of its own.
const PAGE: u16 = 120;
/// For facts of the document: the width of the fact's name in columns, and the text after the name.
const WIDE: (usize, &str) = (12, " ");
/// For facts within a finding: the width of the fact's name in columns, and the text after the name.
const NARROW: (usize, &str) = (8, "  ");

/// Writes the document.
///
/// # Errors
/// The errors of `out`.
pub fn render(document: &Document, style: Style, out: &mut dyn Write) -> io::Result<()> {
    let mut printer = Printer { out: &mut Visible::new(out, style.color), style, is_apart: true };
    for section in document.sections.iter().filter(|section| !section.blocks.is_empty()) {
        printer.apart()?;
        printer.blocks(&section.blocks, 0)?;
    }
    printer.apart()?;
    if let Some(about) = &document.about {
        printer.blocks(&about.blocks, 0)?;
        printer.line(0, "")?;
    }
    printer.line(0, &document.outcome)?;
    printer.facts(&document.facts, 0)?;
    printer.blocks(&document.summary, 0)?;
    printer.out.flush()
}

/// Number of lines of the blocks, as far as it does not depend on the width.
pub fn height(blocks: &[Block]) -> usize {
    let mut lines = Vec::new();
    let mut printer = Printer { out: &mut lines, style: Style::default(), is_apart: false };
    // Writing to memory can't fail.
    let _ = printer.blocks(blocks, 0);
    lines.iter().filter(|byte| **byte == b'\n').count()
}

struct Printer<'a> {
    out: &'a mut dyn Write,
    style: Style,
    /// Whether the output is empty or ends with an empty line.
    is_apart: bool,
}

impl Printer<'_> {
    fn line(&mut self, indent: usize, text: &str) -> io::Result<()> {
        self.is_apart = text.is_empty();
        writeln!(self.out, "{}", format!("{:indent$}{}", "", printable(text)).trim_end())
    }

    fn painted(&mut self, indent: usize, tone: Tone, text: &str) -> io::Result<()> {
        self.is_apart = false;
        let text = painted(tone, printable(text).trim_end(), self.style.color);
        writeln!(self.out, "{:indent$}{text}", "")
    }

    /// Writes an empty line, unless the output is empty or ends with an empty line.
    fn apart(&mut self) -> io::Result<()> {
        if self.is_apart { Ok(()) } else { self.line(0, "") }
    }

    fn blocks(&mut self, blocks: &[Block], indent: usize) -> io::Result<()> {
        blocks.iter().try_for_each(|block| self.block(block, indent))
    }

    fn block(&mut self, block: &Block, indent: usize) -> io::Result<()> {
        match block {
            Block::Text(text) => self.line(indent, text),
            Block::Note(text) => self.line(indent, &format!("note  {text}")),
            Block::Items(items) => items.iter().try_for_each(|item| self.line(indent, item)),
            Block::Words(words) => self.words(words, indent),
            Block::Facts(facts) => self.facts(facts, indent),
            Block::Table(table) if table.is_framed => self.framed(table),
            // Evidence is indented below its finding.
            Block::Table(table) => self.columns(table, if indent > 0 { indent + 2 } else { 0 }),
            Block::Code(code) => self.code(code, indent),
            Block::Fold { title, blocks, .. } => {
                self.line(indent, title)?;
                self.blocks(blocks, indent + 2)
            }
            Block::Finding(finding) => self.finding(finding, indent),
            Block::Markup(_) => Ok(()),
        }
    }

    fn words(&mut self, words: &[String], indent: usize) -> io::Result<()> {
        let width = usize::from(self.style.width.unwrap_or(PAGE)).saturating_sub(indent);
        packed(words, ",", width).iter().try_for_each(|line| self.line(indent, line))
    }

    fn facts(&mut self, facts: &[Fact], indent: usize) -> io::Result<()> {
        let (width, gap) = if indent == 0 { WIDE } else { NARROW };
        facts.iter().try_for_each(|(name, value)| self.line(indent, &format!("{name:width$}{gap}{value}")))
    }

    fn code(&mut self, code: &Code, indent: usize) -> io::Result<()> {
        if !code.title.is_empty() {
            self.line(indent, code.title)?;
        }
        code.text.lines().try_for_each(|line| self.line(indent + 2, line))
    }

    /// A finding, such as `error  node 5: no heartbeat  [heartbeat/missing]`, and its blocks.
    fn finding(&mut self, finding: &Finding, indent: usize) -> io::Result<()> {
        let badge = painted(finding.tone, &printable(&finding.badge), self.style.color);
        let id = if finding.id.is_empty() { String::new() } else { format!("  [{}]", printable(&finding.id)) };
        self.apart()?;
        self.is_apart = false;
        writeln!(self.out, "{:indent$}{badge}  {}{id}", "", printable(&finding.title))?;
        self.blocks(&finding.body, indent + 2)
    }

    /// A table without its frame. Columns are as wide as their cells, and empty columns are left out.
    fn columns(&mut self, table: &Table, indent: usize) -> io::Result<()> {
        let width = |at: usize| {
            let cells = table.rows.iter().filter(|row| row.lines.is_empty()).filter_map(|row| row.cells.get(at));
            cells.map(|cell| printable(&cell.text).chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..table.columns.len()).map(width).collect();
        for row in &table.rows {
            if row.lines.is_empty() {
                self.painted(indent, row.tone, &aligned(table, row, &widths))?;
            }
            row.lines.iter().try_for_each(|line| self.painted(indent, row.tone, line))?;
        }
        Ok(())
    }

    fn framed(&mut self, table: &Table) -> io::Result<()> {
        let mut drawn = table::table(self.style.width.unwrap_or(PAGE), self.style.color);
        drawn.set_header(table.columns.iter().map(|column| printable(&column.name)));
        for row in &table.rows {
            drawn.add_row(row.cells.iter().map(cell));
        }
        for (at, _) in table.columns.iter().enumerate().filter(|(_, column)| column.align == Align::Right) {
            if let Some(column) = drawn.column_mut(at) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        self.is_apart = false;
        writeln!(self.out, "{drawn}")
    }
}

fn aligned(table: &Table, row: &Row, widths: &[usize]) -> String {
    let cells = row.cells.iter().zip(widths).zip(&table.columns).filter(|((_, width), _)| **width > 0);
    let padded = cells.map(|((cell, &width), column)| match (printable(&cell.text), column.align) {
        (text, Align::Right) => format!("{text:>width$}"),
        (text, _) => format!("{text:width$}"),
    });
    padded.collect::<Vec<_>>().join("  ")
}

/// A cell with a tone is in bold, too.
fn cell(cell: &Cell) -> comfy_table::Cell {
    let drawn = comfy_table::Cell::new(printable(&cell.text));
    match cell.tone.color() {
        Some(color) => color::bold(color.cell(drawn)),
        None => drawn,
    }
}

fn painted(tone: Tone, text: &str, wanted: bool) -> String {
    tone.color().map_or_else(|| text.to_owned(), |color| color.paint(text, wanted))
}
