//! The first page of the report: what a release engineer reads and signs.

use super::Run;
use super::defects::defects;
use super::skipped::Skipped;
use crate::document::{Block, Column, Fact, Row, Section, Table, fact};
use crate::page_text::counted;
use crate::provenance::VERSION;
use canvass_suite::comparison::Comparison;
use canvass_suite::verdict::{Authority, Kind};
use std::collections::{BTreeMap, BTreeSet};

/// The note with the name of the tester, and the one with the name of the sample.
const TESTER: &str = "tester";
const SAMPLE: &str = "sample";
/// Maximum length of a reason on the first page.
const SHORT: usize = 160;
/// Maximum number of reasons why cases did not apply.
const REASONS: usize = 8;

/// The sections of the first page.
pub(super) fn sections(run: &Run) -> Vec<Section> {
    let mut sections = vec![section("conclusion", "Conclusion", conclusion(run))];
    let mut add = |id, title, table: Option<Table>| {
        let table = table.map(|table| Table { class: "front", ..table });
        sections.extend(table.map(|table| section(id, title, vec![Block::Table(table)])));
    };
    add("defects", "Defects", defects_of(run));
    add("waived", "Waivers and deviations in force", excused(run));
    add("untested", "Not tested", untested(run));
    sections.push(section("signatures", "Signatures", vec![Block::Table(signatures())]));
    sections
}

fn section(id: &'static str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id, title: title.to_owned(), blocks }
}

fn conclusion(run: &Run) -> Vec<Block> {
    let notes = &run.provenance.notes;
    let note = |name: &str| notes.iter().find(|(key, _)| key == name).map_or("", |(_, value)| value);
    let [name, _, software] = &run.info.device.names;
    let serial = run.info.device.identity[3].map(|serial| format!("{serial:08X}h")).unwrap_or_default();
    let date = run.provenance.date.as_ref().map(|date| date.rfc3339.clone()).unwrap_or_default();
    let facts: Vec<Fact> = [
        fact("device", name.as_deref().unwrap_or_default()),
        fact("identity", &identity(run)),
        fact("firmware", software.as_deref().unwrap_or_default()),
        fact("serial number", &serial),
        fact("sample", note(SAMPLE)),
        fact("tested by", note(TESTER)),
        fact("date", &date),
        fact("tested with", &format!("canvass {VERSION}")),
        fact("against", &editions(run)),
    ]
    .into_iter()
    .filter(|(_, value)| !value.is_empty())
    .collect();
    vec![Block::Text(sentence(run)), Block::Facts(facts), Block::Table(counts(run))]
}

/// Vendor-ID, product code and revision number.
fn identity(run: &Run) -> String {
    let parts = ["vendor-ID", "product code", "revision number"].into_iter().zip(run.info.device.identity);
    let told = parts.filter_map(|(name, part)| Some(format!("{name} {:08X}h", part?)));
    told.collect::<Vec<_>>().join(", ")
}

/// The conclusion in one sentence.
fn sentence(run: &Run) -> String {
    let count = |kind: Kind| run.summary.count(kind);
    let defects = defects(run).iter().filter(|defect| defect.is_failure()).count();
    let executed: usize = [Kind::Pass, Kind::Tolerated, Kind::Deviation, Kind::Fail].into_iter().map(count).sum();
    let open = count(Kind::Inconclusive) + count(Kind::Error);
    let open = if open > 0 { format!("; {} could not be judged", counted(open, "case")) } else { String::new() };
    let left = match run.comparison.as_ref().is_none_or(Comparison::is_as_found) {
        true => "",
        false => "; the device was not left as it was found",
    };
    let ended = if run.summary.cancelled { "; the run ended before all cases had run" } else { "" };
    let tried = if executed == 1 {
        "in the one case that was tried".to_owned()
    } else {
        format!("in all {executed} cases that were tried")
    };
    let result = match (defects, count(Kind::Fail), count(Kind::Deviation)) {
        (0, 0, 0) => format!("the device conforms {tried}"),
        (0, 0, deviations) => format!(
            "the device conforms in {} of {executed} cases that were tried, and deviates in {deviations} as its manual or \
             a waiver says",
            executed - deviations
        ),
        (defects, failed, _) => format!(
            "the device does not conform: {} in {failed} of {executed} cases that were tried",
            counted(defects, "defect")
        ),
    };
    format!("{result}{open}{left}{ended}")
}

/// The standards of the executed cases. CiA 301 has its edition, because the clauses are cited from it.
fn editions(run: &Run) -> String {
    let executed = run.cases.iter().filter(|report| report.verdict.kind().is_executed());
    let standards: BTreeSet<&str> = executed.map(|report| report.case.clause.standard).collect();
    let edition =
        |standard: &str| if standard == "CiA 301" { "CiA 301 V4.2.0".to_owned() } else { standard.to_owned() };
    standards.into_iter().map(edition).collect::<Vec<_>>().join(", ")
}

fn counts(run: &Run) -> Table {
    let kinds: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| run.summary.count(*kind) > 0).collect();
    let cells = kinds.iter().map(|kind| run.summary.count(*kind).to_string());
    let columns = kinds.iter().map(|kind| Column::right(kind.to_string()));
    Table::new(columns, [Row::of(cells)])
}

/// One line for each defect.
fn defects_of(run: &Run) -> Option<Table> {
    let rows = defects(run).into_iter().filter(|defect| defect.is_failure()).enumerate().map(|(number, defect)| {
        let reason = defect.first.verdict.reason().map(|reason| reason.to_string()).unwrap_or_default();
        let cases = match defect.others.len() {
            0 => defect.first.case.id.to_owned(),
            more => format!("{} and {more} more", defect.first.case.id),
        };
        let clause = defect.first.case.clause.to_string();
        Row::of([(number + 1).to_string(), shortened(&reason), clause, cases])
    });
    let rows: Vec<Row> = rows.collect();
    let columns = [Column::right(""), Column::new("defect"), Column::new("clause"), Column::new("cases")];
    (!rows.is_empty()).then(|| Table::new(columns, rows))
}

/// A long value in a reason does not fill the page: the case has it in full.
fn shortened(text: &str) -> String {
    match text.char_indices().nth(SHORT) {
        None => text.to_owned(),
        Some((at, _)) => format!("{} …", text[..at].trim_end()),
    }
}

/// What a waiver or the manual excuses: the behaviours, and the cases that show them.
#[derive(Default)]
struct Excused<'a> {
    what: BTreeSet<String>,
    cases: BTreeSet<&'a str>,
}

/// What is excused: by a waiver, with its reason, owner and end, or by the manual of the device.
fn excused(run: &Run) -> Option<Table> {
    let mut by: BTreeMap<(Option<usize>, &str), Excused<'_>> = BTreeMap::new();
    for report in &run.cases {
        for ruled in report.verdict.breaches() {
            let Some(excuse) = &ruled.excuse else { continue };
            let line = match excuse.by {
                Authority::Waiver { line } => Some(line),
                Authority::Manual => None,
            };
            let excused = by.entry((line, &*excuse.documented)).or_default();
            excused.what.insert(format!("{}: {}", ruled.breach.subject, ruled.breach.actual));
            excused.cases.insert(report.case.id);
        }
    }
    let rows = by.into_iter().map(|((line, documented), Excused { what, cases })| {
        let authority = if line.is_some() { "waiver" } else { "manual" };
        let what: Vec<String> = what.into_iter().collect();
        let what = match &what[..] {
            [first, rest @ ..] if rest.len() > 1 => format!("{first}, and {} more", rest.len()),
            all => all.join("; "),
        };
        Row::of([authority.to_owned(), what, documented.to_owned(), cases.len().to_string()])
    });
    let rows: Vec<Row> = rows.collect();
    let columns = [Column::new("by"), Column::new("accepted"), Column::new("reason"), Column::right("cases")];
    (!rows.is_empty()).then(|| Table::new(columns, rows))
}

/// Why cases did not apply, the most frequent reasons first.
fn untested(run: &Run) -> Option<Table> {
    let groups = Skipped::of(run).groups(run.allow);
    let (first, others) = groups.split_at(groups.len().min(REASONS));
    let rows = first.iter().map(|(reason, cases)| Row::of([shortened(reason), cases.len().to_string()]));
    let left: usize = others.iter().map(|(_, cases)| cases.len()).sum();
    let others = (left > 0).then(|| Row::of([format!("{} other reasons", others.len()), left.to_string()]));
    let rows: Vec<Row> = rows.chain(others).collect();
    (!rows.is_empty()).then(|| Table::new([Column::new("why"), Column::right("cases")], rows))
}

fn signatures() -> Table {
    let columns = [Column::new(""), Column::new("name"), Column::new("date"), Column::new("signature")];
    let row = |role: &str| Row::of([role, "", "", ""]);
    Table { class: "signatures", ..Table::new(columns, [row("tested by"), row("released by")]) }
}

/// The head of every printed page: device, firmware, date and result.
pub(super) fn head(run: &Run) -> String {
    let [name, _, software] = &run.info.device.names;
    let date = run.provenance.date.as_ref().and_then(|date| date.rfc3339.get(..10));
    let failed = run.summary.count(Kind::Fail);
    let result = if failed > 0 { format!("{failed} failed") } else { "none failed".to_owned() };
    let parts = [name.as_deref(), software.as_deref(), date, Some(&*result)];
    parts.into_iter().flatten().map(str::trim).filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" · ")
}
