//! A document as PDF on A4 with its fonts, the same bytes for the same document; PDF/A-2b if the result has a date.
//!
//! A document is laid out first ([`flow`], [`blocks`], [`table`]), so that the head of each page can say how many there
//! are, and then drawn ([`draw`]).

mod blocks;
mod draw;
mod flow;
mod fonts;
mod table;

#[cfg(test)]
mod tests;

use super::Document;
use flow::Flow;
use fonts::Fonts;
use std::io::{self, Write};

/// Writes the first pages, and the rest of the document if there is to be an appendix.
///
/// # Errors
/// The errors of `out`, and those of a document that can't be written as PDF/A.
pub(super) fn render(document: &Document, appendix: bool, out: &mut dyn Write) -> io::Result<()> {
    let fonts = Fonts::new().ok_or_else(|| io::Error::other("the fonts of the program can't be read"))?;
    let mut flow = Flow::new(&fonts);
    blocks::title(&mut flow, document);
    if document.front.is_empty() {
        blocks::facts(&mut flow, &document.facts);
        blocks::blocks(&mut flow, &document.summary);
    }
    document.front.iter().for_each(|section| blocks::section(&mut flow, section));
    if appendix || document.front.is_empty() {
        if !document.front.is_empty() {
            flow.new_page();
            blocks::appendix(&mut flow, document);
        }
        let all = document.sections.iter().chain(&document.about);
        all.for_each(|section| blocks::section(&mut flow, section));
    }
    let bytes = draw::draw(&flow.into_pages(), &fonts, document)?;
    out.write_all(&bytes)
}
