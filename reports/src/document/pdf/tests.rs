//! Documents as PDF.

use super::super::{Block, Cell, Column, Document, Row, Section, Table};
use super::fonts::{Fonts, Typeface};
use super::*;
use proptest::prelude::*;

fn written(document: &Document, appendix: bool) -> Vec<u8> {
    let mut out = Vec::new();
    render(document, appendix, &mut out).unwrap();
    out
}

fn document(text: &str, rows: usize) -> Document {
    let row = |number: usize| Row::of([Cell::from(number.to_string()), text.into()]);
    let table = Table::new([Column::right("number"), Column::new("text")], (0..rows).map(row));
    let section = |title: &str, blocks| Section { id: "", title: title.to_owned(), blocks };
    Document {
        command: "test",
        kind: "CANopen conformance",
        title: text.to_owned(),
        outcome: text.to_owned(),
        front: vec![section("Conclusion", vec![Block::Text(text.to_owned())])],
        sections: vec![section("Cases", vec![Block::Table(table), Block::Items(vec![text.to_owned()])])],
        ..Document::default()
    }
}

/// The number of pages, from the page tree.
fn pages(pdf: &[u8]) -> usize {
    let text = String::from_utf8_lossy(pdf);
    let count = text.split("/Count ").nth(1).unwrap();
    count.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap()
}

#[test]
fn the_appendix_can_be_left_out() {
    let document = document("Sendix", 400);
    assert_eq!(pages(&written(&document, false)), 1);
    assert!(pages(&written(&document, true)) > 5);
}

/// Nothing but the document determines the bytes; a date is that of the result.
#[test]
fn the_same_document_gives_the_same_bytes() {
    let one = document("Sendix", 3);
    assert_eq!(written(&one, true), written(&one, true));
    let dated = Document { date: "2026-11-28T10:00:00+01:00".to_owned(), ..document("Sendix", 3) };
    let text = String::from_utf8_lossy(&written(&dated, true)).into_owned();
    assert!(text.contains("2026-11-28T09:00:00"), "the date is in UTC");
    assert!(text.contains("pdfaid:part") && text.starts_with("%PDF-1.7"));
}

#[test]
fn long_words_are_cut_and_words_are_kept_together() {
    let fonts = Fonts::new().unwrap();
    let lines = fonts.lines("one two three", Typeface::Regular, 9.0, fonts.width("one two", Typeface::Regular, 9.0));
    assert_eq!(lines, ["one two", "three"]);
    let cut = fonts.lines(&"x".repeat(100), Typeface::Mono, 9.0, 50.0);
    assert!(cut.len() > 5 && cut.concat() == "x".repeat(100));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Any text is written, of whatever script, and no line is wider than its column.
    #[test]
    fn any_text_is_written(text in "\\PC{0,200}|[\\x00-\\x1f a-z]{0,80}") {
        prop_assert!(written(&document(&text, 2), true).starts_with(b"%PDF"));
        let fonts = Fonts::new().unwrap();
        for line in fonts.lines(&text, Typeface::Bold, 9.0, 60.0) {
            prop_assert!(fonts.width(&line, Typeface::Bold, 9.0) <= 60.5 || line.chars().count() <= 1, "{line}");
        }
    }
}
