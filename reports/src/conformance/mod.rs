//! Reports of a conformance run. All are made from the same events.
//!
//! - [`Terminal`](terminal::Terminal) shows the progress and prints the result;
//! - [`json`], [`junit`], [`html`] and [`markdown`] write a document when the run is over: see [`Document`].

pub mod dictionary;
mod host;
pub mod html;
pub mod json;
pub mod junit;
pub mod markdown;
mod screen;
mod skipped;
pub mod terminal;
mod told;

#[cfg(test)]
mod hostile;

use crate::provenance::Provenance;
use canvass_suite::bench::Exhibit;
use canvass_suite::comparison::Comparison;
use canvass_suite::foreign::ForeignMessages;
use canvass_suite::runner::{CaseReport, RunEvent, RunInfo, Summary};
use canvass_suite::verdict::Kind;
use canvass_traces::{Record, Timestamp, hex};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Takes the events of a run.
pub trait Reporter {
    /// Something has happened.
    ///
    /// # Errors
    /// What writing the report gave.
    fn event(&mut self, event: &RunEvent<'_>) -> io::Result<()>;

    /// Where the result comes from, as far as it is known by now; the latest is reported.
    fn comes_from(&mut self, provenance: &Provenance);
}

/// A whole run, as the documents need it.
#[derive(Clone, Debug)]
pub struct Run {
    /// What was tested.
    pub info: RunInfo,
    /// Where the result comes from.
    pub provenance: Provenance,
    /// The cases, in the order in which they ran.
    pub cases: Vec<CaseReport>,
    /// The object dictionary before and after; none where no case has run.
    pub comparison: Option<Comparison>,
    /// What others sent to the device or for it.
    pub other_clients: Vec<ForeignMessages>,
    /// What was noticed about the run as a whole.
    pub notices: Vec<String>,
    /// The outcome.
    pub summary: Summary,
}

impl Run {
    /// The cases by family, each in the order in which they ran.
    fn families(&self) -> BTreeMap<&'static str, Vec<&CaseReport>> {
        let mut families: BTreeMap<&'static str, Vec<&CaseReport>> = BTreeMap::new();
        for report in &self.cases {
            families.entry(report.case.family()).or_default().push(report);
        }
        families
    }
}

/// Writes a document about a whole run.
pub type Render = fn(&Run, &mut dyn Write) -> io::Result<()>;

/// A reporter that writes its document when the run is over.
#[derive(Debug)]
pub struct Document<W> {
    out: W,
    render: Render,
    info: Option<RunInfo>,
    provenance: Provenance,
    cases: Vec<CaseReport>,
    comparison: Option<Comparison>,
    other_clients: Vec<ForeignMessages>,
    notices: Vec<String>,
}

impl<W: Write> Document<W> {
    /// A document that `render` writes to `out`.
    pub fn new(out: W, render: Render) -> Self {
        let provenance = Provenance::default();
        let (cases, notices, other_clients) = (Vec::new(), Vec::new(), Vec::new());
        Self { out, render, info: None, provenance, cases, comparison: None, other_clients, notices }
    }
}

impl<W: Write> Reporter for Document<W> {
    fn event(&mut self, event: &RunEvent<'_>) -> io::Result<()> {
        match event {
            RunEvent::RunStarted(info) => self.info = Some((*info).clone()),
            RunEvent::CaseStarted { .. } => {}
            RunEvent::CaseFinished(report) => self.cases.push((*report).clone()),
            RunEvent::DictionaryCompared(comparison) => self.comparison = Some((*comparison).clone()),
            RunEvent::OtherClients(messages) => self.other_clients = messages.to_vec(),
            RunEvent::Noticed(text) => self.notices.push((*text).to_owned()),
            RunEvent::RunFinished(summary) => {
                if let Some(info) = self.info.take() {
                    let run = Run {
                        info,
                        provenance: std::mem::take(&mut self.provenance),
                        cases: std::mem::take(&mut self.cases),
                        comparison: self.comparison.take(),
                        other_clients: std::mem::take(&mut self.other_clients),
                        notices: std::mem::take(&mut self.notices),
                        summary: **summary,
                    };
                    (self.render)(&run, &mut self.out)?;
                    self.out.flush()?;
                }
            }
        }
        Ok(())
    }

    fn comes_from(&mut self, provenance: &Provenance) {
        self.provenance = provenance.clone();
    }
}

/// A sign for each verdict, so that colour is never all that tells them apart.
pub(crate) const fn symbol(kind: Kind) -> &'static str {
    match kind {
        Kind::Pass => "✓",
        Kind::Tolerated => "≈",
        Kind::Deviation => "≠",
        Kind::Fail => "✗",
        Kind::Inconclusive => "?",
        Kind::NotApplicable => "–",
        Kind::Error => "!",
    }
}

/// A case within its family: `download/read-only`.
fn name_in_family(id: &str) -> &str {
    id.splitn(3, '/').nth(2).unwrap_or(id)
}

/// The first and the last frame of a case, as they are counted in the recording of the run; `None` where there is none.
fn recorded(report: &CaseReport) -> Option<[u64; 2]> {
    let number = |exhibit: &Exhibit| Some(exhibit.record.place.number).filter(|&number| number > 0);
    Some([report.evidence.frames().next().and_then(number)?, report.evidence.frames().last().and_then(number)?])
}

/// What CiA's conformance test tool would say, where a case corresponds to one of its: it accepts what is tolerated.
fn cct_forecast(report: &CaseReport) -> Option<&'static str> {
    match (report.case.cct, report.verdict.kind()) {
        (Some(_), Kind::Pass | Kind::Tolerated) => Some("pass"),
        (Some(_), Kind::Fail | Kind::Deviation) => Some("fail"),
        _ => None,
    }
}

/// Which objects served a case: `1017h:00 (written and read back)`.
fn uses(report: &CaseReport) -> Option<String> {
    let uses: Vec<String> =
        report.uses.iter().map(|using| format!("{} ({})", using.multiplexer, using.purpose)).collect();
    (!uses.is_empty()).then(|| uses.join(", "))
}

/// How many repetitions ended in which way, where they differed: `3 pass, 1 fail`.
fn repetitions(report: &CaseReport) -> Option<String> {
    let counted = |kind: Kind| {
        let count = report.outcomes.iter().filter(|&&outcome| outcome == kind).count();
        (count > 0).then(|| format!("{count} {kind}"))
    };
    let counts: Vec<String> = Kind::ALL.into_iter().filter_map(counted).collect();
    report.is_flaky().then(|| format!("flaky: {}", counts.join(", ")))
}

/// Until when its failure does not count, and who looks into it.
fn quarantined(report: &CaseReport) -> Option<String> {
    report.quarantine.as_ref().map(|quarantine| crate::escape::printable(&quarantine.to_string()).into_owned())
}

/// The frames that show a case's verdict best, at most so many, and how many came before them: those up to the worst breach,
/// else the last ones.
fn decisive(report: &CaseReport, most: usize) -> (Vec<&Exhibit>, u64) {
    let frames: Vec<&Exhibit> = report.evidence.frames().collect();
    let seen = report.verdict.worst().and_then(|ruled| ruled.breach.seen);
    let end = seen.map_or(frames.len(), |seen| frames.partition_point(|exhibit| exhibit.record.timestamp <= seen));
    let begin = end.saturating_sub(most);
    let omitted = if begin >= report.evidence.gap() { report.evidence.omitted() } else { 0 };
    (frames.get(begin..end).unwrap_or_default().to_vec(), begin as u64 + omitted)
}

/// One line about the outcome.
fn outcome(summary: &Summary) -> String {
    let counted = |kind: Kind, verb: &str| {
        let count = summary.count(kind);
        (count > 0).then(|| format!("{count} {verb}"))
    };
    let bad = [
        counted(Kind::Fail, "failed"),
        counted(Kind::Error, "could not be run"),
        counted(Kind::Inconclusive, "could not be judged"),
    ];
    let bad: Vec<String> = bad.into_iter().flatten().collect();
    let good = if bad.is_empty() { "none failed".to_owned() } else { bad.join(", ") };
    let cancelled = if summary.cancelled { " (cancelled before the end)" } else { "" };
    let flaky = match summary.flaky {
        0 => String::new(),
        1 => "; 1 is flaky".to_owned(),
        count => format!("; {count} are flaky"),
    };
    let stores = match summary.stores {
        0 => String::new(),
        1 => "; the device's non-volatile memory was written once".to_owned(),
        count => format!("; the device's non-volatile memory was written {count} times"),
    };
    let quarantined = match summary.quarantined {
        0 => String::new(),
        count => format!(" ({count} of them in quarantine)"),
    };
    let plural = if summary.total() == 1 { "" } else { "s" };
    format!("Of {} case{plural} {good}{quarantined}{cancelled}{flaky}{stores}", summary.total())
}

/// Milliseconds with three digits since `start`: what a person compares.
fn milliseconds_since(start: Timestamp, record: &Record) -> String {
    let nanos = record.timestamp.since(start).nanos();
    format!("{}.{:03}", nanos / 1_000_000, nanos / 1_000 % 1_000)
}

/// The payload in hexadecimal, bytes apart.
fn hex(record: &Record) -> String {
    if record.frame.is_remote() { "remote request".to_owned() } else { hex::spaced(record.data()).to_string() }
}
