//! The result on a terminal: progress while the run goes on, then what was wrong, then the count.

use super::skipped::Skipped;
use super::told::Told;
use super::{Reporter, cct_forecast, decisive, outcome, repetitions, symbol};
use crate::escape::printable;
use canvass_suite::runner::{CaseReport, RunEvent, RunInfo, Summary};
use canvass_suite::verdict::Kind;
use comfy_table::{Attribute, Cell, CellAlignment, Color, ContentArrangement, Table, presets};
use std::io::{self, Write};

/// At most so many frames of a case are printed, the last ones: the verdict is made of them.
const FRAMES: usize = 16;

/// As many breaches of a case are shown; JSON and the page have all.
const BREACHES: usize = 8;

/// The columns of a file, which has no width of its own.
const PAGE: u16 = 120;

/// How to print.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Style {
    /// With colours.
    pub color: bool,
    /// One line that tells how far the run is: only where the progress goes to a terminal.
    pub progress: bool,
    /// The width of the terminal in columns, where it is one.
    pub width: Option<u16>,
}

/// Prints results to one stream and progress to another.
#[derive(Debug)]
pub struct Terminal<O, P> {
    out: O,
    progress: P,
    style: Style,
    told: Vec<CaseReport>,
    skipped: Skipped,
    notices: Vec<String>,
}

impl<O: Write, P: Write> Terminal<O, P> {
    /// Results go to `out`, progress to `progress`.
    pub fn new(out: O, progress: P, style: Style) -> Self {
        Self { out, progress, style, told: Vec::new(), skipped: Skipped::default(), notices: Vec::new() }
    }

    fn show_progress(&mut self, text: &str) -> io::Result<()> {
        if self.style.progress {
            // Back to the start of the line, and clear what was there.
            write!(self.progress, "\r\x1b[K{text}")?;
            self.progress.flush()?;
        }
        Ok(())
    }

    fn painted(&self, kind: Kind, text: &str) -> String {
        let code = match kind {
            Kind::Pass => "32",
            Kind::Tolerated | Kind::Deviation => "33",
            Kind::Fail | Kind::Error => "31",
            Kind::Inconclusive => "35",
            Kind::NotApplicable => "2",
        };
        if self.style.color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }

    fn start(&mut self, info: &RunInfo) -> io::Result<()> {
        let [name, _, software] = info.device.names.each_ref().map(|name| name.as_deref().unwrap_or("?"));
        let (name, software, bus) = (printable(name), printable(software), printable(&info.bus));
        writeln!(self.out, "node {} on {bus}: {name}, software {software}; {} cases", info.node, info.cases)
    }

    fn keep(&mut self, report: &CaseReport) {
        match report.verdict.kind() {
            Kind::Pass if report.notes.is_empty() && !report.is_flaky() => {}
            Kind::NotApplicable => {
                self.skipped.add(report.case.id, &report.verdict.reason().unwrap_or_default());
            }
            _ => self.told.push(report.clone()),
        }
    }

    fn finish(&mut self, summary: &Summary) -> io::Result<()> {
        self.show_progress("")?;
        for report in std::mem::take(&mut self.told) {
            self.case(&report)?;
        }
        if !self.skipped.is_empty() {
            writeln!(self.out, "\n{}", self.painted(Kind::NotApplicable, "not applicable"))?;
        }
        std::mem::take(&mut self.skipped).write(self.style.width.unwrap_or(PAGE), &mut self.out)?;
        writeln!(self.out, "\n{}", self.table(summary))?;
        writeln!(self.out, "{}, in {} on the bus.", outcome(summary), summary.duration)?;
        if let Some(host) = &summary.host {
            writeln!(self.out, "{}", super::host::sentence(host))?;
        }
        for notice in std::mem::take(&mut self.notices) {
            writeln!(self.out, "note  {}", printable(&notice))?;
        }
        self.out.flush()
    }

    fn case(&mut self, report: &CaseReport) -> io::Result<()> {
        let kind = report.verdict.kind();
        let title = self.painted(kind, &format!("{} {kind}", symbol(kind)));
        writeln!(self.out, "\n{title}  {}  [{}]", report.case.id, report.case.clause)?;
        let told = Told::all(report);
        let hidden = told.len().saturating_sub(BREACHES);
        told.iter().take(BREACHES).try_for_each(|told| self.told(told))?;
        if hidden > 0 {
            writeln!(self.out, "  … {hidden} more breach{}", if hidden == 1 { "" } else { "es" })?;
        }
        if let (Some(forecast), Some(number)) = (cct_forecast(report), report.case.cct) {
            writeln!(self.out, "    forecast  case {number} of CiA's test tool would {forecast}")?;
        }
        if let Some(repetitions) = repetitions(report) {
            writeln!(self.out, "    {repetitions}")?;
        }
        for measurement in &report.measurements {
            writeln!(self.out, "    measured  {}", printable(&measurement.to_string()))?;
        }
        for note in &report.notes {
            writeln!(self.out, "    note  {}", printable(note))?;
        }
        if matches!(kind, Kind::Pass) { Ok(()) } else { self.frames(report) }
    }

    fn told(&mut self, told: &Told) -> io::Result<()> {
        writeln!(self.out, "  {}", printable(&told.duty))?;
        writeln!(self.out, "    expected  {}", printable(&told.expected))?;
        writeln!(self.out, "    found     {}", printable(&told.found))?;
        if let Some(excuse) = &told.excuse {
            let label = told.authority().to_lowercase();
            writeln!(self.out, "    {label:10}  {}", printable(&excuse.documented))?;
        }
        match told.waiver() {
            Some(waiver) => writeln!(self.out, "    as data   {}", printable(&waiver)),
            None => Ok(()),
        }
    }

    fn frames(&mut self, report: &CaseReport) -> io::Result<()> {
        let (frames, before) = decisive(report, FRAMES);
        if before > 0 {
            let plural = if before == 1 { "" } else { "s" };
            writeln!(self.out, "    … {before} frame{plural} before")?;
        }
        for exhibit in frames {
            let (record, text) = (&exhibit.record, printable(&exhibit.text));
            let frame = record.frame.to_string();
            writeln!(self.out, "    ({}) {frame:<21} {:<2} {text}", record.timestamp, record.direction.to_string())?;
        }
        Ok(())
    }

    fn table(&self, summary: &Summary) -> Table {
        let mut table = Table::new();
        table.load_style(presets::UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Dynamic);
        if self.style.color {
            table.enforce_styling()
        } else {
            table.force_no_tty()
        };
        table.set_width(self.style.width.unwrap_or(80));
        table.set_header(["verdict", "cases"]);
        for kind in Kind::ALL {
            let (count, color) = (summary.count(kind), color(kind));
            let mut name = Cell::new(format!("{} {kind}", symbol(kind)));
            if count > 0 {
                name = name.fg(color).add_attribute(Attribute::Bold);
            }
            table.add_row([name, Cell::new(count).set_alignment(CellAlignment::Right)]);
        }
        table
    }
}

const fn color(kind: Kind) -> Color {
    match kind {
        Kind::Pass => Color::Green,
        Kind::Tolerated | Kind::Deviation => Color::Yellow,
        Kind::Fail | Kind::Error => Color::Red,
        Kind::Inconclusive => Color::Magenta,
        Kind::NotApplicable => Color::DarkGrey,
    }
}

impl<O: Write, P: Write> Reporter for Terminal<O, P> {
    fn event(&mut self, event: &RunEvent<'_>) -> io::Result<()> {
        match event {
            RunEvent::RunStarted(info) => self.start(info),
            RunEvent::CaseStarted { case, number, of } => self.show_progress(&format!("[{number}/{of}] {}", case.id)),
            RunEvent::CaseFinished(report) => {
                self.keep(report);
                Ok(())
            }
            RunEvent::Noticed(text) => {
                self.notices.push((*text).to_owned());
                Ok(())
            }
            RunEvent::RunFinished(summary) => self.finish(summary),
        }
    }
}
