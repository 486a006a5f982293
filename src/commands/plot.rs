//! `canvass plot`: values of PDOs as curves, in the terminal or as a picture.

use super::signals::{Rows, warn};
use crate::files::Files;
use crate::inputs::{InputOptions, Inputs};
use crate::output::{Output, diagnostic, print, terminal_width, write_bytes};
use crate::selection::Selection;
use crate::status::{Failure, Status};
use crate::time_range::TimeRange;
use crate::whole_file::write_whole;
use anyhow::{Result, anyhow};
use canvass_reports::escape::Printable;
use canvass_reports::plot::Curves;
use canvass_reports::signals::{Columns, Sampler};
use canvass_reports::time::{Clock, TimeStyle};
use canvass_traces::Timestamp;
use std::path::PathBuf;

/// Draw the values of PDOs as curves over time, in the terminal or as a picture
///
/// The columns are those of canvass signals. Values of one unit have one axis. All peaks are drawn, however long the
/// capture is. The mapping must be known, from --device or from SDO traffic of the capture.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass plot machine.log --device 5=encoder.eds --signal 'node 5 position'
  canvass plot machine.log --device 5=encoder.eds --signal position --signal speed -o position.svg")]
pub struct Args {
    /// Capture files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Draw the columns whose names contain these words, such as 'node 5 position' (default: all columns)
    #[arg(long, value_name = "WORDS")]
    signal: Vec<String>,
    /// Write the picture to this file, as SVG, instead of drawing in the terminal; - is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    range: TimeRange,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    input: InputOptions,
}

/// The width of the drawing if standard output is no terminal.
const WIDTH: u16 = 100;

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let files = Files::new().reads(&self.files).describes(self.selection.descriptions());
        files.writes(self.output.iter().map(PathBuf::as_path).chain(self.input.quality_file()))?;
        let output = Output::text(false);
        let mut curves = Curves::new(&self.signal);
        let mut rows = Rows {
            selection: &self.selection,
            network: self.selection.network()?,
            range: self.range,
            sampler: Sampler::new(None),
            sheet: &mut curves,
        };
        let mut inputs = Inputs::open(&self.files, &self.input, &output)?;
        while inputs.advance()?.is_some() {
            rows.take(inputs.record(), &inputs, &output)?;
        }
        let sampler = rows.sampler;
        self.selection.warn_of_nothing(&inputs);
        warn(&sampler, inputs.channels());
        inputs.finish()?;
        if curves.left_out > 0 {
            diagnostic(&format!("canvass: {} curves left out: choose some by --signal", curves.left_out));
        }
        let plot = curves.plot(sampler.columns(), begins).ok_or_else(|| self.nothing(sampler.columns()))?;
        match &self.output {
            Some(path) if path.as_os_str() == "-" => write_bytes(plot.svg().as_bytes())?,
            Some(path) => write_whole(path, plot.svg().as_bytes())?,
            None => print(&Printable::document(&plot.text(terminal_width().unwrap_or(WIDTH).into())))?,
        }
        Ok(Status::Good)
    }

    /// Why there is nothing to draw, with the names of the columns that there are.
    fn nothing(&self, columns: &Columns) -> anyhow::Error {
        const TOLD: usize = 20;
        if columns.is_empty() {
            return anyhow!("there is nothing to draw: no PDO has a known mapping");
        }
        let names: Vec<&str> = columns.iter().take(TOLD).map(|column| column.name.as_str()).collect();
        let more = if columns.len() > TOLD { ", ..." } else { "" };
        let wished = self.signal.iter().map(|wish| format!("{wish:?}")).collect::<Vec<_>>().join(" or ");
        anyhow!("no column with a value is named {wished}: expected one of {}{more}", names.join(", "))
    }
}

/// The time of the left end: a date, or seconds if the capture counts from its start.
fn begins(time: Timestamp) -> String {
    const YEAR_1990: Timestamp = Timestamp(631_152_000_000_000_000);
    let (style, note) = if time < YEAR_1990 { (TimeStyle::Absolute, " of the capture") } else { (TimeStyle::Utc, "") };
    let mut text = Vec::new();
    Clock::new(style).push(time, &mut text);
    format!("{}{note}", String::from_utf8_lossy(&text).trim())
}
