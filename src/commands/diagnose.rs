//! `canvass diagnose`: what was wrong on a bus.

use crate::devices::DeviceArg;
use crate::inputs::{InputOptions, Inputs, Seen};
use crate::output::{Color, Output};
use crate::status::{Failure, Status};
use crate::time_range::TimeRange;
use canvass_analyzer::findings::{Diagnosis, Results, Severity, SourceQuality, Thresholds};
use canvass_conformance::models::Model;
use canvass_reports::diagnosis::{self, Diagnosed, Style};
use canvass_reports::quality::CaptureQuality;
use canvass_traces::Channels;
use std::io::{self, Write};
use std::path::PathBuf;

/// Diagnose captures: what was on the bus, what was wrong, and the frames that prove it
///
/// `canvass list rules` shows what is looked for, `canvass explain RULE` what it means and what to do. Several captures
/// are merged by time.
#[derive(clap::Args)]
pub struct Args {
    /// Capture files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    format: DiagnoseFormat,
    /// From which severity on findings make the exit status 1
    #[arg(long, value_enum, value_name = "SEVERITY", default_value_t)]
    fail_on: FailOn,
    /// Set a threshold of a rule, such as bus/load.percent=70; can be given several times
    #[arg(long, value_name = "RULE.NAME=VALUE")]
    threshold: Vec<String>,
    /// The bit rate of the bus in bit/s, such as 250k; without it, it is inferred where possible
    #[arg(long, value_name = "RATE", value_parser = parse_bit_rate)]
    bit_rate: Option<u32>,
    /// Which device a node is: a built-in model or an EDS or DCF file
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    #[command(flatten)]
    range: TimeRange,
    #[command(flatten)]
    input: InputOptions,
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
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum FailOn {
    /// Errors
    #[default]
    Error,
    /// Warnings and errors
    Warning,
    /// Nothing: the status tells only whether the captures could be read
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

/// A bit rate as it is typed: in bit/s, or with `k` or `M`.
fn parse_bit_rate(text: &str) -> Result<u32, String> {
    let (digits, factor) = match text.strip_suffix(['k', 'K']) {
        Some(digits) => (digits, 1_000),
        None => text.strip_suffix(['M', 'm']).map_or((text, 1), |digits| (digits, 1_000_000)),
    };
    let rate = digits.parse::<u32>().ok().and_then(|rate| rate.checked_mul(factor));
    rate.filter(|rate| (1_000..=1_000_000).contains(rate)).ok_or_else(|| "expected 1k to 1M, such as 250k".to_owned())
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let mut diagnosis = self.diagnosis()?;
        let mut range = self.range;
        let output = Output::default();
        let mut inputs = Inputs::open(&self.files, &self.input, &output)?;
        let mut damages = 0;
        // A frame that contradicts itself proves nothing.
        while let Some(seen) = inputs.next()? {
            let found = inputs.damages();
            if found != damages {
                damages = found;
                diagnosis.interrupted();
            }
            if let Seen::Record(record) = seen
                && range.contains(record.timestamp)
            {
                diagnosis.record(&record);
            }
        }
        let captures = inputs.captures();
        let sources: Vec<_> =
            captures.iter().map(|capture| SourceQuality { name: capture.name, quality: capture.quality }).collect();
        let results = diagnosis.finish(&sources);
        self.show(&results, inputs.channels(), &captures, color)?;
        drop(captures);
        inputs.finish()?;
        let fails = |least| results.findings.iter().any(|finding| finding.severity >= least);
        Ok(if self.fail_on.least().is_some_and(fails) { Status::Findings } else { Status::Good })
    }

    fn diagnosis(&self) -> Result<Diagnosis, Failure> {
        let mut thresholds = Thresholds::default();
        for threshold in &self.threshold {
            thresholds.set(threshold)?;
        }
        let mut diagnosis = Diagnosis::new(thresholds);
        diagnosis.offer(Model::candidates());
        for device in &self.device {
            diagnosis.describe(device.node, device.describe()?);
        }
        if let Some(bit_rate) = self.bit_rate {
            diagnosis.set_bit_rate(bit_rate);
        }
        Ok(diagnosis)
    }

    fn show(
        &self,
        results: &Results,
        channels: &Channels,
        captures: &[CaptureQuality<'_>],
        color: Color,
    ) -> io::Result<()> {
        let diagnosed = Diagnosed { results, channels, captures };
        let mut out = io::BufWriter::new(io::stdout().lock());
        match self.format {
            DiagnoseFormat::Table => {
                let width = terminal_size::terminal_size().map(|(width, _)| width.0);
                diagnosis::table(&diagnosed, Style { color: color.on_stdout(), width }, &mut out)
            }
            DiagnoseFormat::Json => diagnosis::json(&diagnosed, &mut out),
            DiagnoseFormat::Markdown => diagnosis::markdown(&diagnosed, &mut out),
            DiagnoseFormat::Junit => diagnosis::junit(&diagnosed, self.fail_on.least(), &mut out),
        }?;
        out.flush()
    }
}
