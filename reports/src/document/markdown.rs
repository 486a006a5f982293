//! A document as Markdown for a ticket, a merge request or a wiki.

use super::{Align, Block, Code, Document, Fact, Finding, Section, Table};
use crate::escape::{Visible, markdown, printable};
use crate::page_text::capitalised;
use std::io::{self, Write};

/// Writes the document.
///
/// # Errors
/// The errors of `out`.
pub fn render(document: &Document, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    writeln!(out, "# {}\n\n{}.", markdown(&document.title), markdown(&capitalised(&document.outcome)))?;
    named_values(&document.facts, out)?;
    blocks(&document.summary, 2, out)?;
    for section in document.sections.iter().chain(&document.about) {
        self::section(section, out)?;
    }
    out.flush()
}

fn section(section: &Section, out: &mut dyn Write) -> io::Result<()> {
    // A section with only pictures and controls is empty in Markdown.
    if section.blocks.iter().all(|block| matches!(block, Block::Markup(_))) {
        return Ok(());
    }
    writeln!(out, "\n## {}", markdown(&section.title))?;
    blocks(&section.blocks, 3, out)
}

fn blocks(blocks: &[Block], level: usize, out: &mut dyn Write) -> io::Result<()> {
    blocks.iter().try_for_each(|block| self::block(block, level, out))
}

/// Writes an empty line and the block. Headings in the block are of `level`.
fn block(block: &Block, level: usize, out: &mut dyn Write) -> io::Result<()> {
    match block {
        Block::Text(text) => {
            text.split("\n\n").try_for_each(|text| writeln!(out, "\n{}", markdown(&capitalised(text))))
        }
        Block::Note(text) => writeln!(out, "\n- Note: {}", markdown(text)),
        Block::Items(list) => items(list.iter().map(|item| markdown(item)), out),
        Block::Words(words) => writeln!(out, "\n{}", markdown(&words.join(", "))),
        Block::Facts(facts) if level > 3 => {
            items(facts.iter().map(|(name, value)| format!("{}: {}", capitalised(name), markdown(value))), out)
        }
        Block::Facts(facts) => named_values(facts, out),
        Block::Table(table) => self::table(table, out),
        Block::Code(code) => self::code(code, out),
        Block::Fold { title, blocks, .. } => {
            writeln!(out, "\n{}:", markdown(&capitalised(title)))?;
            self::blocks(blocks, level, out)
        }
        Block::Finding(finding) => self::finding(finding, level, out),
        Block::Markup(_) => Ok(()),
    }
}

fn items(items: impl Iterator<Item = String>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out)?;
    items.into_iter().try_for_each(|item| writeln!(out, "- {item}"))
}

fn named_values(facts: &[Fact], out: &mut dyn Write) -> io::Result<()> {
    if facts.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n| | |\n|---|---|")?;
    facts.iter().try_for_each(|(name, value)| writeln!(out, "| {} | {} |", markdown(name), markdown(value)))
}

fn table(table: &Table, out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<String> = table.columns.iter().map(|column| markdown(&column.name)).collect();
    let rule = table.columns.iter().map(|column| match column.align {
        Align::Left => "---|",
        Align::Center => ":-:|",
        Align::Right => "---:|",
    });
    writeln!(out, "\n| {} |\n|{}", names.join(" | "), rule.collect::<String>())?;
    for row in &table.rows {
        let cells: Vec<String> = row.cells.iter().map(|cell| markdown(&cell.text)).collect();
        writeln!(out, "| {} |", cells.join(" | "))?;
    }
    Ok(())
}

fn finding(finding: &Finding, level: usize, out: &mut dyn Write) -> io::Result<()> {
    let id = if finding.id.is_empty() { String::new() } else { format!(" ({})", markdown(&finding.id)) };
    let (badge, title) = (markdown(&finding.badge), markdown(&finding.title));
    writeln!(out, "\n{} {badge}: {title}{id}", "#".repeat(level))?;
    blocks(&finding.body, level + 1, out)
}

/// A code block with a fence longer than any in its text, so that no text can end the block.
fn code(code: &Code, out: &mut dyn Write) -> io::Result<()> {
    let longest = code.text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest.max(2) + 1);
    if !code.title.is_empty() {
        writeln!(out, "\n{}:", capitalised(code.title))?;
    }
    writeln!(out, "\n{fence}{}", code.language)?;
    code.text.lines().try_for_each(|line| writeln!(out, "{}", printable(line).trim_end()))?;
    writeln!(out, "{fence}")
}
