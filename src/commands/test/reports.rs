//! `--format` and `--report`: the outputs of a run's events.

use crate::output::{Color, document, is_seen, raw, show_progress, terminal_width, unless_closed};
use crate::shown;
use crate::whole_file::WholeFile;
use anyhow::{Context, Result};
use canvass_reports::conformance::{Reporter, RunReport};
use canvass_reports::document::{self, Form, Style};
use canvass_reports::provenance::Provenance;
use canvass_suite::runner::RunEvent;
use clap::ValueEnum;
use std::cell::RefCell;
use std::io::{self, BufWriter, Write};
use std::rc::Rc;

/// A format of the result.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, ValueEnum)]
pub enum ReportFormat {
    /// For people, on a terminal
    #[default]
    Table,
    /// The documented JSON contract
    Json,
    /// For CI servers
    Junit,
    /// One page for a browser
    Html,
    /// For merge requests and wikis
    #[value(alias = "md")]
    Markdown,
    /// For alerts of code hosts (SARIF 2.1.0)
    Sarif,
    /// For paper: a first page to sign, and all details as an appendix
    Pdf,
    /// The first pages of the PDF alone
    PdfSummary,
}

impl shown::Format for ReportFormat {
    const DEFAULT: &'static str = "table";
}

impl ReportFormat {
    /// Whether the report is no text.
    const fn is_binary(self) -> bool {
        matches!(self, Self::Pdf | Self::PdfSummary)
    }

    /// The form of a report in this format; text is printed in `style`.
    pub const fn form(self, style: Style) -> Form {
        match self {
            Self::Table => Form::Text(style),
            Self::Json => Form::Json,
            Self::Junit => Form::Junit,
            Self::Html => Form::Html,
            Self::Markdown => Form::Markdown,
            Self::Sarif => Form::Sarif,
            Self::Pdf => Form::Pdf { appendix: true },
            Self::PdfSummary => Form::Pdf { appendix: false },
        }
    }
}

/// The options for the output of a result in these formats.
pub type Shown = shown::Shown<ReportFormat>;
/// A value of `--report` in these formats.
pub type ReportArg = shown::ReportArg<ReportFormat>;

impl Shown {
    /// Writes the result to standard output and into the files. An error with one output does not stop the others.
    ///
    /// # Errors
    /// The first output that could not be written. A closed standard output is no error.
    pub fn write(&self, report: &dyn document::Report) -> Result<()> {
        let into_file = |arg: &ReportArg| write_file(report, arg.format(), WholeFile::create(arg.file())?);
        let format = self.of_stdout()?;
        let files: Vec<Result<()>> = self.in_files().map(into_file).collect();
        print(report, format)?;
        files.into_iter().collect()
    }
}

/// Writes a report to standard output. A reader that closes standard output early is no error.
///
/// # Errors
/// If the report can't be written.
pub fn print(report: &dyn document::Report, format: ReportFormat) -> io::Result<()> {
    let style = Style { color: false, width: terminal_width() };
    let mut out = of_stdout(format, false);
    unless_closed(report.write(format.form(style), &mut out).and_then(|()| out.flush()))
}

/// Standard output for a report. Control characters of texts are escaped, a PDF is written as it is.
fn of_stdout(format: ReportFormat, colors: bool) -> Box<dyn Write> {
    if format.is_binary() { Box::new(raw()) } else { Box::new(document(colors)) }
}

/// The file of a report. Control characters of texts are escaped, a PDF is written as it is.
fn of_file(format: ReportFormat, file: &WholeFile) -> Result<Box<dyn Write>> {
    Ok(if format.is_binary() { Box::new(BufWriter::new(file.writer()?)) } else { Box::new(file.document()?) })
}

/// Writes a report into a file.
///
/// # Errors
/// If the file can't be written.
pub fn write_file(report: &dyn document::Report, format: ReportFormat, file: WholeFile) -> Result<()> {
    let mut out = of_file(format, &file)?;
    report
        .write(format.form(Style::default()), &mut out)
        .and_then(|()| out.flush())
        .context("can't write the report")?;
    file.complete()
}

/// A report that stays in memory.
#[derive(Clone, Default)]
pub struct Kept(Rc<RefCell<Vec<u8>>>);

impl Kept {
    /// The bytes written; complete after the run.
    pub fn take(&self) -> Vec<u8> {
        self.0.take()
    }
}

impl Write for Kept {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// All reports of a run. An error with one report does not stop the others.
pub struct Reports(Vec<Report>);

struct Report {
    reporter: Box<dyn Reporter>,
    /// The file; `None` for standard output.
    file: Option<WholeFile>,
    written: io::Result<()>,
}

/// The option that gives a permission, for messages.
const ALLOW: &str = "--allow ";

impl Reports {
    /// Creates all files before the device is touched, so that an unwritable path is reported at once.
    pub fn open(shown: &Shown, color: Color) -> Result<Self> {
        let (format, style) = (shown.of_stdout()?, Style { color: color.on_stdout(), width: terminal_width() });
        let of_stdout = reporter(format, of_stdout(format, style.color), style);
        let is_watched = is_seen() && format == ReportFormat::Table;
        let of_stdout = if is_watched { of_stdout.with_progress(show_progress) } else { of_stdout };
        let mut reports = vec![Report { reporter: Box::new(of_stdout), file: None, written: Ok(()) }];
        for wanted in shown.in_files() {
            let (format, file) = (wanted.format(), WholeFile::create(wanted.file())?);
            let reporter = Box::new(reporter(format, of_file(format, &file)?, Style::default()));
            reports.push(Report { reporter, file: Some(file), written: Ok(()) });
        }
        Ok(Self(reports))
    }

    /// Adds a report in memory, for the program's own use.
    pub fn keep(&mut self, format: ReportFormat) -> Kept {
        let kept = Kept::default();
        let reporter = Box::new(reporter(format, Box::new(kept.clone()), Style::default()));
        self.0.push(Report { reporter, file: None, written: Ok(()) });
        kept
    }

    /// Passes an event to all reports without an error so far.
    pub fn event(&mut self, event: &RunEvent<'_>) {
        for Report { reporter, written, .. } in self.0.iter_mut().filter(|report| report.written.is_ok()) {
            *written = reporter.event(event);
        }
    }

    /// Sets the provenance of all reports.
    pub fn comes_from(&mut self, provenance: &Provenance) {
        self.0.iter_mut().for_each(|report| report.reporter.comes_from(provenance));
    }

    /// Completes the reports, and gives the files their final names.
    ///
    /// # Errors
    /// The first report that could not be written. A closed standard output is no error.
    pub fn finish(self) -> Result<()> {
        let ends: Vec<Result<()>> = self.0.into_iter().map(Report::finish).collect();
        ends.into_iter().collect()
    }
}

impl Report {
    fn finish(self) -> Result<()> {
        // Dropping the reporter flushes its buffer into the file.
        drop(self.reporter);
        match self.file {
            Some(file) => self.written.map_err(Into::into).and_then(|()| file.complete()),
            None => unless_closed(self.written).map_err(Into::into),
        }
        .context("can't write the report")
    }
}

fn reporter(format: ReportFormat, out: Box<dyn Write>, style: Style) -> RunReport<Box<dyn Write>> {
    RunReport::new(out, format.form(style)).allowed_by(ALLOW)
}
