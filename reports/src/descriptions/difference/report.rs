//! The differences between two descriptions as a report: each kind of change with its places and consequences.

use super::{Compared, fact, json, subject};
use crate::document::{Block, Depth, Document, Finding, Report, Row, Section, Table, Tone};
use crate::escape::JsonText;
use canvass_analyzer::dictionary::difference::{ChangeKind, Class, Difference};
use std::io::{self, Write};

impl Report for Compared {
    fn document(&self, depth: Depth) -> Document {
        let counts = if self.differences.is_empty() { "no difference".to_owned() } else { self.counts() };
        Document {
            command: "eds diff",
            kind: "CANopen device descriptions",
            title: format!("{} → {}", self.old, self.new),
            outcome: format!("{} -> {}: {counts}", self.old, self.new),
            sections: Class::ALL.into_iter().filter_map(|class| section(self, class, depth)).collect(),
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(JsonText(out), "{:#}", json::document(self))
    }
}

fn section(compared: &Compared, class: Class, depth: Depth) -> Option<Section> {
    let kinds: Vec<_> = compared.by_kind().into_iter().filter(|(kind, _)| kind.class == class).collect();
    if kinds.is_empty() {
        return None;
    }
    let blocks = match depth {
        Depth::Screen => kinds.iter().map(|(kind, differences)| finding(kind, differences)).collect(),
        Depth::Paper | Depth::Print | Depth::Page => {
            let rows = kinds.iter().flat_map(|(kind, differences)| differences.iter().map(|one| row(kind, one)));
            let table = Table::of(["what", "where", "old", "new"], rows);
            let why = kinds.iter().map(|(kind, _)| format!("{} ({}): {}", kind.title(), kind.id, kind.why()));
            vec![Block::Table(table), Block::Items(why.collect())]
        }
    };
    Some(Section { id: "", title: class.to_string(), blocks })
}

fn row(kind: &ChangeKind, difference: &Difference) -> Row {
    let [before, after] = [&difference.before, &difference.after].map(|told| fact(told.as_ref()));
    Row::of([kind.title().to_owned(), subject(difference), before, after])
}

fn finding(kind: &ChangeKind, differences: &[&Difference]) -> Block {
    let line = |difference: &&Difference| {
        let (before, after) = (fact(difference.before.as_ref()), fact(difference.after.as_ref()));
        format!("{}: {before} -> {after}", subject(difference))
    };
    let tone = match kind.class {
        Class::Breaking => Tone::Bad,
        Class::Notable => Tone::Doubt,
        Class::Harmless => Tone::Good,
    };
    Block::Finding(Finding {
        tone,
        badge: kind.class.to_string(),
        title: kind.title().to_owned(),
        id: kind.id.to_owned(),
        body: vec![Block::Items(differences.iter().map(line).collect()), Block::Text(format!("= {}", kind.why()))],
        ..Finding::default()
    })
}
