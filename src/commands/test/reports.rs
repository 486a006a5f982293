//! `--format` and `--report`: where a run's events go.

use crate::output::Color;
use anyhow::{Context, Result, anyhow};
use canvass_reports::conformance::terminal::{Style, Terminal};
use canvass_reports::conformance::{Document, Render, Reporter, html, json, junit, markdown};
use canvass_suite::runner::RunEvent;
use clap::ValueEnum;
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A form of the result.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, ValueEnum)]
pub enum ReportFormat {
    /// For people, on a terminal
    #[default]
    Table,
    /// The contract for programs
    Json,
    /// For CI servers
    Junit,
    /// One page for a browser
    Html,
    /// For merge requests and wikis
    #[value(alias = "md")]
    Markdown,
}

/// `FORMAT=FILE`.
#[derive(Clone, Debug)]
pub struct ReportArg {
    format: ReportFormat,
    file: PathBuf,
}

impl ReportArg {
    /// The form.
    pub fn format(&self) -> ReportFormat {
        self.format
    }

    /// Where it goes.
    pub fn file(&self) -> &Path {
        &self.file
    }
}

impl FromStr for ReportArg {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (format, file) = text.split_once('=').context("expected FORMAT=FILE, such as html=report.html")?;
        let format = ReportFormat::from_str(format, false)
            .map_err(|_| anyhow!("expected table, json, junit, html or markdown, found \"{format}\""))?;
        Ok(Self { format, file: file.into() })
    }
}

/// All reports of a run.
pub struct Reports(Vec<Box<dyn Reporter>>);

impl Reports {
    /// Opens all files before the device is touched: a report that can't be written is known at once.
    pub fn open(format: ReportFormat, files: &[ReportArg], color: Color) -> Result<Self> {
        let style = Style { color: color.on_stdout(), progress: io::stderr().is_terminal(), width: width() };
        let mut reports = vec![reporter(format, Box::new(io::stdout()), style)];
        for ReportArg { format, file } in files {
            let out = File::create(file).with_context(|| format!("can't write {}", file.display()))?;
            let plain = Style { color: false, progress: false, width: None };
            reports.push(reporter(*format, Box::new(BufWriter::new(out)), plain));
        }
        Ok(Self(reports))
    }

    /// Passes an event on to all.
    pub fn event(&mut self, event: &RunEvent<'_>) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|report| report.event(event))
    }
}

fn reporter(format: ReportFormat, out: Box<dyn Write>, style: Style) -> Box<dyn Reporter> {
    let render: Render = match format {
        ReportFormat::Table => return Box::new(Terminal::new(out, io::stderr(), style)),
        ReportFormat::Json => json::render,
        ReportFormat::Junit => junit::render,
        ReportFormat::Html => html::render,
        ReportFormat::Markdown => markdown::render,
    };
    Box::new(Document::new(out, render))
}

/// The width of the terminal, where standard output is one.
fn width() -> Option<u16> {
    terminal_size::terminal_size_of(io::stdout()).map(|(width, _)| width.0)
}
