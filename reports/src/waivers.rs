//! Waivers beside the result of a run.

use crate::document::{Block, Cell, Depth, Document, Report, Row, Section, Table, Tone};
use crate::escape::JsonText;
use crate::page_text::counted;
use crate::results::TestResult;
use canvass_bus::observation::{BadPattern, BadSubject};
use canvass_suite::verdict::Kind;
use canvass_suite::waiver::{Checked, Found, Use};
use serde_json::{Value, json};
use std::io::{self, Write};

/// The name and version of the contract.
const SCHEMA: &str = "canvass/waivers-check/1";

/// The waivers of a file beside a result.
#[derive(Clone, Debug)]
pub struct CheckedWaivers<'a> {
    /// The name of the waiver file, as the user gave it.
    pub file: String,
    /// The name of the result, as the user gave it.
    pub result: String,
    /// The waivers, in the order of the file.
    pub checked: Vec<Checked<'a>>,
}

/// Why a breach of a result can't be read.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum BadBreach {
    /// The subject is none.
    #[error("{0}: {1}")]
    Subject(String, BadSubject),
    /// The behaviour is none.
    #[error("{0}: {1}")]
    Behaviour(String, BadPattern),
}

/// The breaches of a result, as waivers see them.
///
/// # Errors
/// [`BadBreach`] of a result that another program wrote.
pub fn breaches(result: &TestResult) -> Result<Vec<Found>, BadBreach> {
    let of_case = result.cases.iter().flat_map(|case| case.breaches.iter().map(move |breach| (case, breach)));
    let of_case = of_case.filter(|(_, breach)| matches!(breach.verdict.0, Kind::Fail | Kind::Deviation));
    of_case
        .map(|(case, breach)| {
            let id = || case.id.to_string();
            Ok(Found {
                case: id(),
                subject: breach.subject.parse().map_err(|error| BadBreach::Subject(id(), error))?,
                situation: breach.situation.as_ref().map(ToString::to_string),
                does: breach.observation.parse().map_err(|error| BadBreach::Behaviour(id(), error))?,
            })
        })
        .collect()
}

impl CheckedWaivers<'_> {
    /// Whether every waiver is used, and no wider than it need be.
    pub fn is_good(&self) -> bool {
        self.checked.iter().all(Checked::is_good)
    }
}

fn told(usage: &Use) -> (String, Tone) {
    let excuses =
        |count: usize| if count == 1 { "excuses 1 breach".to_owned() } else { format!("excuses {count} breaches") };
    match usage {
        Use::Used(count) => (excuses(*count), Tone::Good),
        Use::TooWide(count, how) => (format!("{}, but {how}", excuses(*count)), Tone::Doubt),
        Use::Unused(near) if near.is_empty() => ("excuses nothing".to_owned(), Tone::Bad),
        Use::Unused(near) => (format!("excuses nothing; near: {}", near.join("; ")), Tone::Bad),
        Use::Expired => ("has expired".to_owned(), Tone::Bad),
    }
}

impl Report for CheckedWaivers<'_> {
    fn document(&self, depth: Depth) -> Document {
        let wrong = self.checked.iter().filter(|checked| !checked.is_good()).count();
        let outcome = format!(
            "{} and {}: {}, {}",
            self.file,
            self.result,
            counted(self.checked.len(), "waiver"),
            if wrong == 0 { "all used".to_owned() } else { format!("{wrong} to look at") }
        );
        let row = |checked: &Checked<'_>| {
            let (usage, tone) = told(&checked.usage);
            let [place, subject, does] = checked.text();
            let line = checked.waiver.line.to_string();
            Row::of([line.into(), place.into(), subject.into(), does.into(), Cell { tone, ..usage.into() }])
        };
        let mut table = Table::of(["line", "where", "object", "does", "use"], self.checked.iter().map(row));
        table.is_framed = depth == Depth::Screen;
        let section = Section { id: "", title: String::new(), blocks: vec![Block::Table(table)] };
        Document {
            command: "waivers check",
            kind: "waivers",
            title: if depth == Depth::Screen { String::new() } else { self.file.clone() },
            outcome,
            sections: if self.checked.is_empty() { Vec::new() } else { vec![section] },
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        let waiver = |checked: &Checked<'_>| {
            let [place, object, does] = checked.text();
            let (usage, breaches, text): (_, _, Value) = match &checked.usage {
                Use::Used(count) => ("used", *count, Value::Null),
                Use::TooWide(count, how) => ("too wide", *count, json!(how)),
                Use::Unused(near) => ("unused", 0, json!(near)),
                Use::Expired => ("expired", 0, Value::Null),
            };
            json!({
                "line": checked.waiver.line, "where": place, "object": object, "does": does, "use": usage,
                "breaches": breaches, "hint": text,
            })
        };
        let waivers: Vec<Value> = self.checked.iter().map(waiver).collect();
        let document = json!({ "schema": SCHEMA, "file": self.file, "result": self.result, "waivers": waivers });
        writeln!(JsonText(out), "{document:#}")
    }
}
