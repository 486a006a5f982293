//! The result on a terminal: progress while the run goes on, then what was wrong, then the count.

use super::dictionary;
use super::skipped::Skipped;
use super::{Reporter, outcome, screen, symbol};
use crate::color::{self, Color};
use crate::escape::{Printable, Visible, printable};
use crate::provenance::{self, Provenance};
use crate::table;
use canvass_suite::runner::{CaseReport, RunEvent, RunInfo, Summary};
use canvass_suite::verdict::Kind;
use comfy_table::{Cell, CellAlignment, Table};
use std::io::{self, Write};

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
    /// What the user has to type before the name of a permission.
    pub allow: &'static str,
}

/// Prints results to one stream and progress to another.
#[derive(Debug)]
pub struct Terminal<O> {
    out: Visible<O>,
    /// Shows a line in place of the one before it.
    progress: fn(&Printable),
    style: Style,
    told: Vec<CaseReport>,
    skipped: Skipped,
    /// The object dictionary before and after.
    compared: Vec<String>,
    notices: Vec<String>,
    provenance: Provenance,
}

impl<O: Write> Terminal<O> {
    /// Results go to `out`; `progress` shows a line in place of the one before it.
    pub fn new(out: O, progress: fn(&Printable), style: Style) -> Self {
        let out = Visible::new(out, style.color);
        let (told, skipped, compared, notices) = (Vec::new(), Skipped::default(), Vec::new(), Vec::new());
        Self { out, progress, style, told, skipped, compared, notices, provenance: Provenance::default() }
    }

    fn show_progress(&self, text: &str) {
        if self.style.progress {
            (self.progress)(&Printable::line(text));
        }
    }

    fn painted(&self, kind: Kind, text: &str) -> String {
        Color::of_verdict(kind).paint(text, self.style.color)
    }

    fn start(&mut self, info: &RunInfo) -> io::Result<()> {
        let [name, _, software] = info.device.names.each_ref().map(|name| name.as_deref().unwrap_or("?"));
        let (name, software, bus) = (printable(name), printable(software), printable(&info.bus));
        let cases = if info.cases == 1 { "1 case".to_owned() } else { format!("{} cases", info.cases) };
        writeln!(self.out, "node {} on {bus}: {name}, software {software}; {cases}", info.node)
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
        self.show_progress("");
        let told = std::mem::take(&mut self.told);
        told.iter().try_for_each(|report| self.case(report))?;
        if !self.skipped.is_empty() {
            writeln!(self.out, "\n{}", self.painted(Kind::NotApplicable, "not applicable"))?;
        }
        std::mem::take(&mut self.skipped).write(self.style.width.unwrap_or(PAGE), self.style.allow, &mut self.out)?;
        writeln!(self.out)?;
        provenance::text(&self.provenance, &mut self.out)?;
        writeln!(self.out, "\n{}", self.table(summary))?;
        writeln!(self.out, "{}, in {} on the bus.", outcome(summary), summary.duration)?;
        if let Some(host) = &summary.host {
            writeln!(self.out, "{}", super::host::sentence(host))?;
        }
        for line in std::mem::take(&mut self.compared) {
            writeln!(self.out, "{}", printable(&line))?;
        }
        for notice in std::mem::take(&mut self.notices) {
            writeln!(self.out, "note  {}", printable(&notice))?;
        }
        self.list(&told)?;
        self.out.flush()
    }

    fn case(&mut self, report: &CaseReport) -> io::Result<()> {
        let kind = report.verdict.kind();
        let title = self.painted(kind, &format!("{} {kind}", symbol(kind)));
        writeln!(self.out, "\n{title}  {}  [{}]", report.case.id, report.case.clause)?;
        screen::lines(report).iter().try_for_each(|line| writeln!(self.out, "{line}"))
    }

    /// What somebody has to look into comes last: it is what is seen when the run is over.
    fn list(&mut self, told: &[CaseReport]) -> io::Result<()> {
        let bad: Vec<&CaseReport> = told.iter().filter(|report| screen::is_bad(report.verdict.kind())).collect();
        if !bad.is_empty() {
            writeln!(self.out)?;
        }
        for report in bad {
            let line = self.painted(report.verdict.kind(), &screen::listed(report));
            writeln!(self.out, "{line}")?;
        }
        Ok(())
    }

    fn table(&self, summary: &Summary) -> Table {
        let mut table = table::table(self.style.width.unwrap_or(80), self.style.color);
        table.set_header(["verdict", "cases"]);
        for kind in Kind::ALL {
            let count = summary.count(kind);
            let mut name = Cell::new(format!("{} {kind}", symbol(kind)));
            if count > 0 {
                name = color::bold(Color::of_verdict(kind).cell(name));
            }
            table.add_row([name, Cell::new(count).set_alignment(CellAlignment::Right)]);
        }
        table
    }
}

impl<O: Write> Reporter for Terminal<O> {
    fn event(&mut self, event: &RunEvent<'_>) -> io::Result<()> {
        match event {
            RunEvent::RunStarted(info) => self.start(info),
            RunEvent::CaseStarted { case, number, of } => {
                self.show_progress(&format!("[{number}/{of}] {}", case.id));
                Ok(())
            }
            RunEvent::CaseFinished(report) => {
                self.keep(report);
                Ok(())
            }
            RunEvent::DictionaryCompared(comparison) => {
                self.compared = dictionary::lines(comparison);
                Ok(())
            }
            RunEvent::Noticed(text) => {
                self.notices.push((*text).to_owned());
                Ok(())
            }
            // A notice tells of them.
            RunEvent::OtherClients(_) => Ok(()),
            RunEvent::RunFinished(summary) => self.finish(summary),
        }
    }

    fn comes_from(&mut self, provenance: &Provenance) {
        self.provenance = provenance.clone();
    }
}
