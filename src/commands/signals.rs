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
use canvass_traces::{Duration, Record};
use std::path::PathBuf;
use tempfile::SpooledTempFile;

/// Print the values of PDOs as columns over time, for plots and data frames
///
/// Each PDO gives one row with the latest value of every column; unknown values are empty. A column is named
/// CHANNEL.NODE.OBJECT [UNIT]. The mapping must be known, from --device or from SDO traffic of the capture. Times are
/// integer nanoseconds.
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
        let sheet: Box<dyn Sheet> = match self.format {
            SignalFormat::Csv => Box::new(CsvSheet::new(SpooledTempFile::new(IN_MEMORY), self.every.is_none())),
            SignalFormat::Json => Box::new(JsonSheet::new()),
        };
        let (network, sampler) = (self.selection.network()?, Sampler::new(self.every));
        let mut rows = Rows { selection: &self.selection, network, range: self.range, sampler, sheet };
        let mut inputs = Inputs::open(&self.files, &self.input, &output)?;
        while inputs.advance()?.is_some() {
            rows.take(inputs.record(), &inputs, &output)?;
        }
        let Rows { mut sampler, mut sheet, .. } = rows;
        output.append_with(|buffer| sampler.finish(sheet.as_mut(), buffer))?;
        while output.append_with(|buffer| sheet.finish(sampler.columns(), buffer))? {}
        self.selection.warn_of_nothing(&inputs);
        inputs.finish()?;
        warn(&sampler);
        Ok(Status::Good)
    }
}

/// Turns records into rows.
struct Rows<'a> {
    selection: &'a Selection,
    network: Network,
    range: TimeRange,
    sampler: Sampler,
    sheet: Box<dyn Sheet>,
}

impl Rows<'_> {
    fn take(&mut self, record: &Record, inputs: &Inputs<'_>, output: &Output) -> std::io::Result<()> {
        let decoded = self.network.handle(record);
        let chosen = self.range.contains(record.timestamp)
            && self.selection.has_channel(record, inputs)
            && self.selection.has(record, &decoded, inputs);
        let Some(bus) = self.network.bus(record.channel).filter(|_| chosen) else { return Ok(()) };
        let meaning = Meaning::new(record, &decoded, bus);
        let (sampler, sheet) = (&mut self.sampler, self.sheet.as_mut());
        output.append_with(|buffer| sampler.frame(record, inputs.channels(), &decoded, &meaning, sheet, buffer))
    }
}

fn warn(sampler: &Sampler) {
    if sampler.columns().is_empty() {
        diagnostic("canvass: no PDO with a known mapping: describe the device of a node with --device NODE=MODEL|FILE");
    }
    if sampler.columns().left_out > 0 {
        let (left_out, most) = (sampler.columns().left_out, Columns::MOST);
        diagnostic(&format!("canvass: {left_out} values left out: there are more than {most} columns"));
    }
    if sampler.skipped() > 0 {
        diagnostic(&format!("canvass: {} long silences left out", sampler.skipped()));
    }
}
