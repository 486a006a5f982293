//! The differences between a device and its description as a report.

use super::{Verification, json, remark, subject};
use crate::document::{Block, Cell, Depth, Document, Report, Row, Section, Table, Tone};
use crate::escape::JsonText;
use canvass_analyzer::dictionary::survey::compare::{Mismatch, MismatchKind};
use std::collections::BTreeSet;
use std::io::{self, Write};

impl Report for Verification {
    fn document(&self, depth: Depth) -> Document {
        let device = format!("node {} on {}", self.node, self.bus);
        let (title, outcome) = match depth {
            Depth::Screen => (String::new(), format!("{}, {device}: {}", self.file, self.summary())),
            Depth::Paper | Depth::Print | Depth::Page => (format!("{} and {device}", self.file), self.summary()),
        };
        Document {
            command: "eds verify",
            kind: "CANopen device descriptions",
            title,
            outcome,
            sections: if depth == Depth::Screen { on_a_screen(self) } else { in_full(self) },
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(JsonText(out), "{:#}", json::document(self))
    }
}

fn section(title: &str, blocks: Vec<Block>) -> Section {
    Section { id: "", title: title.to_owned(), blocks }
}

fn incomplete(verification: &Verification) -> Option<Block> {
    Some(verification.incomplete()).filter(|told| !told.is_empty()).map(Block::Text)
}

/// One table, followed by the meaning of each kind of difference.
fn on_a_screen(verification: &Verification) -> Vec<Section> {
    let counted = verification.differences().map(|mismatch| row(mismatch, Tone::Bad));
    let others = verification.explicable().map(|mismatch| row(mismatch, Tone::Doubt));
    let mut table = Table::of(["object", "what", "described", "found"], counted.chain(others));
    table.is_framed = true;
    let kinds: BTreeSet<MismatchKind> = verification.mismatches.iter().map(|mismatch| mismatch.kind).collect();
    let meanings = kinds.iter().map(|kind| format!("{}: {}", kind.id(), kind.meaning())).collect();
    let is_any = !verification.mismatches.is_empty();
    let found = is_any.then(|| section("", vec![Block::Table(table), Block::Items(meanings)]));
    found.into_iter().chain(incomplete(verification).map(|block| section("", vec![block]))).collect()
}

/// A table for each weight, with the meaning of each difference.
fn in_full(verification: &Verification) -> Vec<Section> {
    let differences: Vec<&Mismatch> = verification.differences().collect();
    let others: Vec<&Mismatch> = verification.explicable().collect();
    let groups = [("Differences", differences), ("May be configuration or state", others)];
    let told = |(title, mismatches): (&str, Vec<&Mismatch>)| {
        let rows = mismatches.iter().map(|mismatch| {
            let mut row = row(mismatch, Tone::Plain);
            row.cells.push(mismatch.kind.meaning().into());
            row
        });
        let table = Table::of(["object", "what", "described", "found", "meaning"], rows);
        section(title, vec![Block::Table(table)])
    };
    let groups = groups.into_iter().filter(|(_, mismatches)| !mismatches.is_empty()).map(told);
    groups.chain(incomplete(verification).map(|block| section("Not looked at", vec![block]))).collect()
}

fn row(mismatch: &Mismatch, tone: Tone) -> Row {
    let what = match remark(mismatch.weight) {
        "" => mismatch.kind.id().to_owned(),
        remark => format!("{} ({remark})", mismatch.kind.id()),
    };
    let what = Cell { tone, ..what.into() };
    Row::of([subject(mismatch).into(), what, mismatch.described.to_string().into(), mismatch.found.to_string().into()])
}
