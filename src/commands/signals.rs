//! `canvass signals`: values of PDOs as columns over time.

use crate::files::Files;
use crate::inputs::{InputOptions, Inputs};
use crate::live::parse_span;
use crate::output::{Output, diagnostic};
use crate::selection::Selection;
use crate::status::{Failure, Status};
use crate::time_range::TimeRange;
use anyhow::Result;
use canvass_analyzer::Meaning;
use canvass_analyzer::network::Network;
use canvass_reports::signals::{Columns, CsvSheet, JsonSheet, Sampler, Sheet};
use canvass_traces::{Channels, Duration, Record};
use std::path::PathBuf;
use tempfile::SpooledTempFile;

/// Print the values of PDOs as columns over time, for plots and data frames
///
/// Each PDO gives one row with the latest value of every column; unknown values are empty. A column has a name such as
/// node 5 Position value [steps]; the name begins with the channel if the first column has another one. The mapping must be known, from --device or from SDO traffic of the capture. Times are
/// integer nanoseconds. Mapped values that no column has are told on standard error.
#[derive(clap::Args)]
pub struct Args {
    /// Capture files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// How to print the rows
    #[arg(long, value_enum, default_value_t)]
    format: SignalFormat,
    /// One row per interval, such as 10ms, with the latest values, instead of one for each PDO
    #[arg(long, value_name = "SPAN", value_parser = parse_span)]
    every: Option<Duration>,
    #[command(flatten)]
    range: TimeRange,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    input: InputOptions,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum SignalFormat {
    /// Comma-separated values; the header names all columns, so nothing is printed before the whole capture is read
    #[default]
    Csv,
    /// JSON Lines, printed while the capture is read
    Json,
}

/// Memory for rows that wait for the header; further rows wait in a temporary file.
const IN_MEMORY: usize = 64 << 20;

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let files = Files::new().reads(&self.files).describes(self.selection.descriptions());
        files.writes(self.input.quality_file())?;
        let output = Output::text(false);
        let mut sheet: Box<dyn Sheet> = match self.format {
            SignalFormat::Csv => Box::new(CsvSheet::new(SpooledTempFile::new(IN_MEMORY), self.every.is_none())),
            SignalFormat::Json => Box::new(JsonSheet::new()),
        };
        let (network, sampler) = (self.selection.network()?, Sampler::new(self.every));
        let mut rows = Rows { selection: &self.selection, network, range: self.range, sampler, sheet: sheet.as_mut() };
        let mut inputs = Inputs::open(&self.files, &self.input, &output)?;
        while inputs.advance()?.is_some() {
            rows.take(inputs.record(), &inputs, &output)?;
        }
        let Rows { mut sampler, .. } = rows;
        output.append_with(|buffer| sampler.finish(sheet.as_mut(), buffer))?;
        while output.append_with(|buffer| sheet.finish(sampler.columns(), buffer))? {}
        self.selection.warn_of_nothing(&inputs);
        warn(&sampler, inputs.channels());
        inputs.finish()?;
        Ok(Status::Good)
    }
}

/// Turns records into rows.
pub struct Rows<'a> {
    pub selection: &'a Selection,
    pub network: Network,
    pub range: TimeRange,
    pub sampler: Sampler,
    pub sheet: &'a mut dyn Sheet,
}

impl Rows<'_> {
    /// Takes the next record of the inputs.
    pub fn take(&mut self, record: &Record, inputs: &Inputs<'_>, output: &Output) -> std::io::Result<()> {
        let decoded = self.network.handle(record);
        let chosen = self.range.contains(record.timestamp)
            && self.selection.has_channel(record, inputs)
            && self.selection.has(record, &decoded, inputs);
        let Some(bus) = self.network.bus(record.channel).filter(|_| chosen) else { return Ok(()) };
        let meaning = Meaning::new(record, &decoded, bus);
        let (sampler, sheet) = (&mut self.sampler, &mut *self.sheet);
        output.append_with(|buffer| sampler.frame(record, inputs.channels(), &decoded, &meaning, sheet, buffer))
    }
}

/// Says what the rows do not have, and what to do.
pub fn warn(sampler: &Sampler, channels: &Channels) {
    for line in sampler.dropped().lines(channels) {
        diagnostic(&format!("canvass: left out: {line}"));
    }
    let unmapped: Vec<String> =
        sampler.dropped().unmapped().map(|node| format!("--device {node}=MODEL|FILE")).collect();
    if !unmapped.is_empty() {
        diagnostic(&format!("canvass: describe the devices of these nodes: {}", shortened(&unmapped)));
    } else if sampler.columns().is_empty() {
        diagnostic("canvass: the capture has no PDO");
    }
    if sampler.columns().left_out > 0 {
        let (left_out, most) = (sampler.columns().left_out, Columns::MOST);
        diagnostic(&format!("canvass: {left_out} values left out: there are more than {most} columns"));
    }
    if sampler.skipped() > 0 {
        diagnostic(&format!("canvass: {} long silences left out", sampler.skipped()));
    }
}

/// The first of many options.
fn shortened(options: &[String]) -> String {
    const TOLD: usize = 8;
    let more = if options.len() > TOLD { " ..." } else { "" };
    format!("{}{more}", options.iter().take(TOLD).map(String::as_str).collect::<Vec<_>>().join(" "))
}
