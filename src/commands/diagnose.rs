//! `canvass diagnose`: problems of a bus.

use crate::destination::refuse_existing;
use crate::devices::{self, DeviceArg};
use crate::files::Files;
use crate::inputs::{InputOptions, Inputs, RecordKind};
use crate::output::{Color, Output, document, is_terminal, unless_closed};
use crate::provenance::{Collected, Hashes, Remarks, Subject, Typed};
use crate::selection::Channels;
use crate::shown::{Format, Shown};
use crate::status::{Failure, Status};
use crate::time_range::TimeRange;
use crate::whole_file::WholeFile;
use anyhow::{Context, anyhow};
use canvass_analyzer::NodeRange;
use canvass_analyzer::findings::{Diagnosis, Severity, SourceQuality, Thresholds};
use canvass_device::address::parse_bit_rate;
use canvass_device::models::Model;
use canvass_reports::diagnosis::{Advice, Diagnosed, DiagnosisReport, Reading, html};
use canvass_reports::document::{Form, Report as _, Style};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

/// Diagnose captures: traffic on the bus, problems, and the frames that prove them
///
/// `canvass list rules` lists the rules, `canvass explain RULE` explains a rule and its remedy. Several captures are
/// merged by time.
#[derive(clap::Args)]
pub struct Args {
    /// Capture files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    shown: Shown<DiagnoseFormat>,
    /// Write the result to a file instead of standard output
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite the file of --output if it exists
    #[arg(long)]
    force: bool,
    /// Print all findings with all their frames, and all nodes
    #[arg(long, short)]
    verbose: bool,
    /// The lowest severity of findings that makes the exit status 1
    #[arg(long, value_enum, value_name = "SEVERITY", default_value_t)]
    fail_on: FailOn,
    /// Set a threshold of a rule, such as bus/load.percent=70; can be given several times
    #[arg(long, value_name = "RULE.NAME=VALUE")]
    threshold: Vec<String>,
    /// The bit rate of the bus in bit/s, such as 250k (default: from the capture, or inferred from its frames)
    #[arg(long, value_name = "RATE", value_parser = parse_bit_rate)]
    bit_rate: Option<u32>,
    /// The device of a node: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    /// Only findings that concern these nodes, such as 5 or 1..8,63, with their causes and consequences at others. All
    /// frames are judged
    #[arg(long, value_name = "NODE", value_delimiter = ',')]
    node: Vec<NodeRange>,
    #[command(flatten)]
    channels: Channels,
    #[command(flatten)]
    range: TimeRange,
    #[command(flatten)]
    input: InputOptions,
    #[command(flatten)]
    remarks: Remarks,
}

#[derive(Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum DiagnoseFormat {
    /// For people: a summary, the findings, a table of nodes
    #[default]
    Table,
    /// One JSON object
    Json,
    /// For tickets and wikis
    Markdown,
    /// JUnit XML: each rule is a case
    Junit,
    /// One page for a browser, with plots and the frames around findings
    Html,
}

impl Format for DiagnoseFormat {
    const DEFAULT: &'static str = "table";
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum FailOn {
    /// Exit status 1 with errors
    #[default]
    Error,
    /// Exit status 1 with warnings and errors
    Warning,
    /// Never exit status 1 for findings; the status tells only whether the captures could be read
    Never,
}

impl FailOn {
    const fn least(self) -> Option<Severity> {
        match self {
            Self::Error => Some(Severity::Error),
            Self::Warning => Some(Severity::Warning),
            Self::Never => None,
        }
    }
}

/// The options that show the parts that the table leaves out.
const ADVICE: Advice = Advice {
    findings: ": --verbose and the page (--format html) show all",
    rows: ": --verbose shows all",
    bit_rate: " (see --bit-rate)",
};

impl Args {
    pub fn run(self, color: Color, typed: &Typed) -> Result<Status, Failure> {
        let mut provenance = self.provenance(typed)?;
        let diagnosis = self.diagnosis()?;
        let mut range = self.range;
        let destinations = self.destinations()?;
        let is_page = destinations.iter().any(|to| to.format == DiagnoseFormat::Html);
        let collector = is_page.then(html::Collector::default);
        let mut reading = Reading::new(diagnosis, collector);
        let output = Output::text(false);
        let hashes = Hashes::begin("capture", &self.files);
        let mut inputs = Inputs::open(&self.files, &self.input, &output)?;
        let mut damages = 0;
        // A frame that contradicts itself is no evidence.
        while let Some(kind) = inputs.advance()? {
            let found = inputs.damages();
            if found != damages {
                damages = found;
                reading.interrupted(inputs.merge())?;
            }
            reading.see_channel(inputs.record().channel, inputs.merge());
            let channel = inputs.record().channel;
            let is_wanted = range.contains(inputs.record().timestamp) && self.channels.has(channel, &inputs);
            if kind == RecordKind::Record && is_wanted {
                inputs.hand_over(&mut reading)?;
            }
        }
        let captures = inputs.captures();
        let sources: Vec<_> =
            captures.iter().map(|capture| SourceQuality { name: capture.name, quality: capture.quality }).collect();
        let (mut results, collector) = reading.finish(inputs.merge(), &sources)?;
        if !self.node.is_empty() {
            results.keep_nodes(|node| self.node.iter().any(|range| range.contains(node)));
        }
        provenance.files(hashes.finish());
        provenance.nodes_of(&results, inputs.channels());
        let provenance = &provenance.0;
        let diagnosed = Diagnosed { results: &results, channels: inputs.channels(), captures: &captures, provenance };
        self.show(&diagnosed, collector, color, destinations)?;
        drop(captures);
        self.channels.warn_of_unknown(&inputs);
        inputs.finish()?;
        let fails = |least| results.findings.iter().any(|finding| finding.severity >= least);
        Ok(if self.fail_on.least().is_some_and(fails) { Status::Findings } else { Status::Good })
    }

    /// The provenance of the result, as far as it is known before the captures are read.
    fn provenance(&self, typed: &Typed) -> Result<Collected, Failure> {
        let mut provenance = Collected::begin(&self.remarks, typed, Subject::Files)?;
        provenance.descriptions(None, self.device.iter().map(|device| &*device.device));
        Ok(provenance)
    }

    fn diagnosis(&self) -> Result<Diagnosis, Failure> {
        let mut thresholds = Thresholds::default();
        for threshold in &self.threshold {
            thresholds.set(threshold)?;
        }
        let mut diagnosis = Diagnosis::new(thresholds);
        diagnosis.offer(Model::candidates());
        devices::each(&self.device, |node, known| diagnosis.describe(node, Arc::clone(known)))?;
        if let Some(bit_rate) = self.bit_rate {
            diagnosis.set_bit_rate(bit_rate);
        }
        Ok(diagnosis)
    }

    /// All places for the result. Files are created before the captures are read, so that an unwritable path is reported
    /// at once.
    fn destinations(&self) -> Result<Vec<Destination>, Failure> {
        let devices = self.device.iter().map(|device| &*device.device);
        let files = Files::new().reads(&self.files).describes(devices);
        files.writes(&self.output)?.writes(self.shown.files())?.writes(self.input.quality_file())?;
        let mut all = vec![self.main_destination()?];
        for report in self.shown.in_files() {
            all.push(Destination { format: report.format(), file: Some(WholeFile::create(report.file())?) });
        }
        if all.iter().filter(|to| to.format == DiagnoseFormat::Html).count() > 1 {
            return Err(anyhow!("the page is written once: give html to one of --format and --report").into());
        }
        Ok(all)
    }

    /// Standard output, or the file of `--output`.
    fn main_destination(&self) -> Result<Destination, Failure> {
        let format = self.shown.of_stdout()?;
        let Some(path) = self.output.as_ref().filter(|path| path.as_os_str() != "-") else {
            if format == DiagnoseFormat::Html && is_terminal() {
                return Err(anyhow!(
                    "the page is for a browser: write it with --report html=FILE, or redirect standard output"
                )
                .into());
            }
            return Ok(Destination { format, file: None });
        };
        if !self.force {
            refuse_existing(path)?;
        }
        Ok(Destination { format, file: Some(WholeFile::create(path)?) })
    }

    /// Writes the result everywhere. An error with one place does not stop the others.
    fn show(
        &self,
        diagnosed: &Diagnosed<'_>,
        mut collector: Option<html::Collector>,
        color: Color,
        destinations: Vec<Destination>,
    ) -> Result<(), Failure> {
        let report =
            DiagnosisReport { diagnosed, is_verbose: self.verbose, advice: ADVICE, fail_on: self.fail_on.least() };
        let written: Vec<_> = destinations.into_iter().map(|to| to.write(&report, &mut collector, color)).collect();
        written.into_iter().collect()
    }
}

/// A place for the result.
struct Destination {
    format: DiagnoseFormat,
    /// The file; `None` for standard output.
    file: Option<WholeFile>,
}

impl Destination {
    fn write(
        self,
        report: &DiagnosisReport<'_>,
        collector: &mut Option<html::Collector>,
        color: Color,
    ) -> Result<(), Failure> {
        let to_file = self.file.is_some();
        let sink: Box<dyn Write> = match &self.file {
            Some(file) => Box::new(file.document()?),
            None => Box::new(document(color.on_stdout())),
        };
        let mut out = io::BufWriter::new(sink);
        let width = terminal_size::terminal_size().map(|(width, _)| width.0).filter(|_| !to_file);
        let style = Style { color: color.on_stdout() && !to_file, width };
        let written = match self.format {
            DiagnoseFormat::Table => report.write(Form::Text(style), &mut out),
            DiagnoseFormat::Json => report.write(Form::Json, &mut out),
            DiagnoseFormat::Markdown => report.write(Form::Markdown, &mut out),
            DiagnoseFormat::Junit => report.write(Form::Junit, &mut out),
            DiagnoseFormat::Html => html::render(report.diagnosed, collector.take().unwrap_or_default(), &mut out),
        };
        let written = written.and_then(|()| out.flush());
        drop(out);
        match self.file {
            Some(file) => {
                written.context("can't write the report")?;
                Ok(file.complete()?)
            }
            // The exit status does not depend on a reader that closes the pipe early.
            None => Ok(unless_closed(written)?),
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_default_format_has_its_name() {
        crate::shown::expect_default::<super::DiagnoseFormat>();
        crate::shown::expect_default::<crate::commands::test::reports::ReportFormat>();
    }
}
