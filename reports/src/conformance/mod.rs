//! The report of a conformance run, made from its events: see [`RunReport`].

mod case;
mod defects;
mod delays;
pub mod dictionary;
mod front;
mod host;
mod json;
mod judged;
mod report;
mod skipped;
mod suites;
mod timeline;
mod told;

#[cfg(test)]
mod hostile;

use crate::document::{Form, Report as _, Tone};
use crate::escape::{Printable, Visible, printable};
use crate::provenance::Provenance;
use canvass_suite::bench::Exhibit;
use canvass_suite::comparison::Comparison;
use canvass_suite::foreign::ForeignMessages;
use canvass_suite::runner::{CaseReport, RunEvent, RunInfo, Summary};
use canvass_suite::verdict::Kind;
use canvass_traces::{Record, hex};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// A receiver of the events of a run.
pub trait Reporter {
    /// Takes the next event.
    ///
    /// # Errors
    /// The errors of writing the report.
    fn event(&mut self, event: &RunEvent<'_>) -> io::Result<()>;

    /// Sets the provenance of the result, as far as it is known by now. A later call replaces the provenance.
    fn comes_from(&mut self, provenance: &Provenance);
}

/// A whole run with the data of all reports.
#[derive(Clone, Debug)]
pub struct Run {
    /// The tested device and the options.
    pub info: RunInfo,
    /// The provenance of the result.
    pub provenance: Provenance,
    /// The cases, in the order in which they ran.
    pub cases: Vec<CaseReport>,
    /// The object dictionary before and after the run. `None` if no case has run.
    pub comparison: Option<Comparison>,
    /// Messages that others sent to the device or in its name.
    pub other_clients: Vec<ForeignMessages>,
    /// Observations about the run as a whole.
    pub notices: Vec<String>,
    /// The outcome.
    pub summary: Summary,
    /// The text that a user types before the name of a permission. May be empty.
    pub allow: &'static str,
}

impl Run {
    /// The cases by family. Each family is in the order in which the cases ran.
    fn families(&self) -> BTreeMap<&'static str, Vec<&CaseReport>> {
        let mut families: BTreeMap<&'static str, Vec<&CaseReport>> = BTreeMap::new();
        for report in &self.cases {
            families.entry(report.case.family()).or_default().push(report);
        }
        families
    }
}

/// A reporter that writes its report at the end of the run. The text form begins with the tested device, and may show
/// the progress.
pub struct RunReport<W> {
    out: W,
    form: Form,
    /// Shows a progress line in place of the previous line.
    progress: Option<fn(&Printable)>,
    allow: &'static str,
    notices: Vec<String>,
    provenance: Provenance,
    run: Option<Run>,
}

impl<W: Write> RunReport<W> {
    /// A reporter that writes a report in the form `form` to `out`.
    pub fn new(out: W, form: Form) -> Self {
        let (notices, provenance) = (Vec::new(), Provenance::default());
        Self { out, form, progress: None, allow: "", notices, provenance, run: None }
    }

    /// Sets the text that a user types before the name of a permission.
    #[must_use]
    pub fn allowed_by(self, allow: &'static str) -> Self {
        Self { allow, ..self }
    }

    /// Shows the progress of the run in a line.
    #[must_use]
    pub fn with_progress(self, progress: fn(&Printable)) -> Self {
        Self { progress: Some(progress), ..self }
    }

    fn show_progress(&self, text: &str) {
        if let Some(progress) = self.progress {
            progress(&Printable::line(text));
        }
    }

    fn start(&mut self, info: &RunInfo) -> io::Result<()> {
        self.run = Some(Run {
            info: info.clone(),
            provenance: Provenance::default(),
            cases: Vec::new(),
            comparison: None,
            other_clients: Vec::new(),
            notices: Vec::new(),
            summary: Summary::default(),
            allow: self.allow,
        });
        if !matches!(self.form, Form::Text(_)) {
            return Ok(());
        }
        let [name, _, software] = info.device.names.each_ref().map(|name| name.as_deref().unwrap_or("?"));
        let (name, software, bus) = (printable(name), printable(software), printable(&info.bus));
        let cases = if info.cases == 1 { "1 case".to_owned() } else { format!("{} cases", info.cases) };
        let out = &mut Visible::new(&mut self.out, false);
        writeln!(out, "node {} on {bus}: {name}, software {software}; {cases}\n", info.node)
    }

    fn finish(&mut self, summary: &Summary) -> io::Result<()> {
        self.show_progress("");
        let Some(mut run) = self.run.take() else { return Ok(()) };
        judged::name_judges(&mut run.cases);
        run.summary = *summary;
        run.notices = std::mem::take(&mut self.notices);
        run.provenance = std::mem::take(&mut self.provenance);
        run.write(self.form, &mut self.out)?;
        self.out.flush()
    }
}

impl<W: Write> Reporter for RunReport<W> {
    fn event(&mut self, event: &RunEvent<'_>) -> io::Result<()> {
        match (event, &mut self.run) {
            (RunEvent::RunStarted(info), _) => return self.start(info),
            (RunEvent::RunFinished(summary), _) => return self.finish(summary),
            (RunEvent::CaseStarted { case, number, of }, _) => {
                self.show_progress(&format!("[{number}/{of}] {}", case.id));
            }
            (RunEvent::Noticed(text), _) => self.notices.push((*text).to_owned()),
            (RunEvent::CaseFinished(report), Some(run)) => run.cases.push((*report).clone()),
            (RunEvent::DictionaryCompared(comparison), Some(run)) => run.comparison = Some((*comparison).clone()),
            (RunEvent::OtherClients(messages), Some(run)) => run.other_clients = messages.to_vec(),
            (_, None) => {}
        }
        Ok(())
    }

    fn comes_from(&mut self, provenance: &Provenance) {
        self.provenance = provenance.clone();
    }
}

/// Whether somebody has to look into a case with this verdict.
pub(crate) const fn is_bad(kind: Kind) -> bool {
    matches!(kind, Kind::Fail | Kind::Error | Kind::Inconclusive)
}

/// The tone of a verdict.
const fn tone(kind: Kind) -> Tone {
    match kind {
        Kind::Pass => Tone::Good,
        Kind::Tolerated | Kind::Deviation => Tone::Doubt,
        Kind::Fail | Kind::Error => Tone::Bad,
        Kind::Inconclusive => Tone::Odd,
        Kind::NotApplicable => Tone::Faint,
    }
}

/// A sign for each verdict, which distinguishes verdicts without colours.
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

/// The name of a case within its family: `download/read-only`.
fn name_in_family(id: &str) -> &str {
    id.splitn(3, '/').nth(2).unwrap_or(id)
}

/// The numbers of the first and the last frame of a case in the recording of the run. `None` if there is no recording.
fn recorded(report: &CaseReport) -> Option<[u64; 2]> {
    let number = |exhibit: &Exhibit| Some(exhibit.record.place.number).filter(|&number| number > 0);
    Some([report.evidence.frames().next().and_then(number)?, report.evidence.frames().last().and_then(number)?])
}

/// The expected result of CiA's conformance test tool, if the case corresponds to one of its tests. The tool accepts
/// tolerated answers.
fn cct_forecast(report: &CaseReport) -> Option<&'static str> {
    match (report.case.cct, report.verdict.kind()) {
        (Some(_), Kind::Pass | Kind::Tolerated) => Some("pass"),
        (Some(_), Kind::Fail | Kind::Deviation) => Some("fail"),
        _ => None,
    }
}

/// The objects that the case used: `1017h:00 (written and read back)`.
fn uses(report: &CaseReport) -> Option<String> {
    let uses: Vec<String> =
        report.uses.iter().map(|using| format!("{} ({})", using.multiplexer, using.purpose)).collect();
    (!uses.is_empty()).then(|| uses.join(", "))
}

/// The number of repetitions by verdict, if they differ: `3 pass, 1 fail`.
fn repetitions(report: &CaseReport) -> Option<String> {
    let counted = |kind: Kind| {
        let count = report.outcomes.iter().filter(|&&outcome| outcome == kind).count();
        (count > 0).then(|| format!("{count} {kind}"))
    };
    let counts: Vec<String> = Kind::ALL.into_iter().filter_map(counted).collect();
    report.is_flaky().then(|| format!("flaky: {}", counts.join(", ")))
}

/// The quarantine of the case: its end, and who looks into the failure.
fn quarantined(report: &CaseReport) -> Option<String> {
    report.quarantine.as_ref().map(ToString::to_string)
}

/// At most `most` frames that show a case's verdict best, and the number of frames before them: the frames up to the
/// worst breach, otherwise the last frames.
fn decisive(report: &CaseReport, most: usize) -> (Vec<&Exhibit>, u64) {
    let frames: Vec<&Exhibit> = report.evidence.frames().collect();
    let seen = report.verdict.worst().and_then(|ruled| ruled.breach.seen);
    let end = seen.map_or(frames.len(), |seen| frames.partition_point(|exhibit| exhibit.record.timestamp <= seen));
    let begin = end.saturating_sub(most);
    let omitted = if begin >= report.evidence.gap() { report.evidence.omitted() } else { 0 };
    (frames.get(begin..end).unwrap_or_default().to_vec(), begin as u64 + omitted)
}

/// The outcome in one line. `defects` is the number of defects that the failed cases show.
fn outcome(summary: &Summary, defects: usize) -> String {
    let counted = |kind: Kind, verb: &str| {
        let count = summary.count(kind);
        (count > 0).then(|| format!("{count} {verb}"))
    };
    let failed = match (summary.count(Kind::Fail), defects) {
        (0, _) => None,
        (1, _) => counted(Kind::Fail, "failed"),
        (count, 1) => Some(format!("{count} failed, all for the same defect")),
        (count, defects) if defects < count => Some(format!("{count} failed for {defects} defects")),
        _ => counted(Kind::Fail, "failed"),
    };
    let bad = [failed, counted(Kind::Error, "could not be run"), counted(Kind::Inconclusive, "could not be judged")];
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

/// The payload in hexadecimal, with spaces between the bytes.
fn hex(record: &Record) -> String {
    if record.frame.is_remote() { "remote request".to_owned() } else { hex::spaced(record.data()).to_string() }
}
