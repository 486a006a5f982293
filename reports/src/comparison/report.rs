//! The differences as a report. In JUnit files each regression fails under the name of its case, so that a server shows
//! since when the case fails.

use super::{Comparison, Direction, json};
use crate::document::junit::{Case, Outcome, Problem, Suite};
use crate::document::{Block, Depth, Document, PageParts, Report, Row, Section, Table, Tone};
use crate::results::compare::Change;
use std::io::{self, Write};

impl Report for Comparison {
    fn document(&self, depth: Depth) -> Document {
        let present = Direction::ALL.into_iter().filter(|direction| self.of(*direction).next().is_some());
        Document {
            command: "compare",
            kind: "CANopen conformance",
            title: match &self.releases {
                [old, new] if !old.is_empty() && !new.is_empty() => format!("What changed from {old} to {new}"),
                _ => "What the release changed".to_owned(),
            },
            outcome: self.outcome(),
            tone: if self.has_regressions() { Tone::Bad } else { Tone::Good },
            sections: present.map(|direction| section(self, direction)).collect(),
            about: Some(self.provenance.section(depth, depth > Depth::Screen)),
            suites: vec![suite(self)],
            page: PageParts { footer: "What changed for the worse comes first.", ..PageParts::default() },
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        json::render(self, out)
    }
}

fn section(comparison: &Comparison, direction: Direction) -> Section {
    let table = Table::of(["", "subject", "before", "now", "why"], comparison.of(direction).map(row));
    Section { id: direction.name(), title: direction.title().to_owned(), blocks: vec![Block::Table(table)] }
}

fn row(change: &Change) -> Row {
    let (old, new) = change.values();
    let why = change.why();
    let line = format!("{:6} {:10} {}: {old} -> {new}", change.direction.name(), change.kind, change.subject);
    let lines = [line].into_iter().chain(why.iter().map(|why| format!("{:18}{why}", ""))).collect();
    Row { lines, ..Row::of([&*change.kind, &change.subject, old, new, &why.unwrap_or_default()]) }
}

fn suite(comparison: &Comparison) -> Suite {
    let mut suite = Suite::new("compare");
    suite.add_properties(comparison.provenance.properties());
    suite.add_cases(comparison.changes.iter().map(case));
    if comparison.changes.is_empty() {
        suite.add_cases([Case::passed("compare", "no difference")]);
    }
    suite
}

fn case(change: &Change) -> Case {
    let (old, new) = change.values();
    let told = format!("{old} -> {new}");
    let case = Case::passed(format!("compare.{}", change.kind), &*change.subject);
    match change.direction {
        Direction::Worse => case.ended(Outcome::Failed(Problem {
            kind: if change.returned.is_some() { "returned" } else { "worse" },
            message: told,
            details: change.why().into_iter().collect(),
        })),
        Direction::Waived | Direction::Better | Direction::Other => {
            case.remarked(format!("{}: {told}", change.subject))
        }
    }
}
