//! `canvass decode`: captures as text.

use super::decode_events;
use crate::files::Files;
use crate::inputs::{InputOptions, Inputs, is_stdin};
use crate::output::{Color, Output, diagnostic, terminal_width};
use crate::selection::Selection;
use crate::status::{Failure, Status};
use crate::time_range::TimeRange;
use anyhow::anyhow;
use canvass_analyzer::Meaning;
use canvass_analyzer::network::{Network, Skipping};
use canvass_reports::decode::{CsvLines, JsonLines, Line, Lines, TableLines, TextLines, TimeStyle};
use canvass_traces::TimeBase;
use std::io::IsTerminal as _;
use std::path::PathBuf;

/// The keys that end the input of a terminal.
const END_OF_INPUT: &str = if cfg!(windows) { "Ctrl-Z and Enter" } else { "Ctrl-D" };

/// Decode captures: one annotated line per frame, or one per event
///
/// The format of a capture is recognised by its content. Several captures are merged by time. Standard error reports
/// what can't be read, with its place and reason; the rest is decoded.
#[derive(clap::Args)]
pub struct Args {
    /// Capture files; - is standard input
    #[arg(value_name = "FILE", default_value = "-")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    view: View,
    #[command(flatten)]
    input: InputOptions,
}

/// Options for the output of frames.
#[derive(clap::Args)]
pub struct View {
    /// How to print the frames
    #[arg(long, value_enum, default_value_t)]
    format: DecodeFormat,
    /// Print events instead of frames: whole SDO transfers, states, errors, layer setting, COB-IDs and mappings
    #[arg(long)]
    events: bool,
    /// Sort frames that are up to 20 ms out of order; recorders with several threads or adapters write such files
    #[arg(long, conflicts_with = "events")]
    in_order: bool,
    /// The time to print; JSON always has integer nanoseconds
    #[arg(long, value_enum, default_value_t)]
    time: Time,
    #[command(flatten)]
    range: TimeRange,
    #[command(flatten)]
    selection: Selection,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum DecodeFormat {
    /// Aligned lines
    #[default]
    Text,
    /// A table with a header, no wider than the terminal
    Table,
    /// JSON Lines
    Json,
    /// Comma-separated values with a header
    Csv,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum Time {
    /// The time as in the capture
    #[default]
    Absolute,
    /// Time since the first frame
    Relative,
    /// Time since the frame before
    Delta,
    /// Date and time of day in UTC (RFC 3339)
    Utc,
    /// Date and time of day in the zone of this computer
    Local,
}

/// The state of decoding: the network, and the frames that need no decoding.
struct Decoding {
    network: Network,
    /// Remembers which frames are not selected and change no state, so that frames like them are skipped; `None`
    /// without a selection.
    skipping: Option<Skipping>,
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let output = Output::text(color.on_stdout());
        // Errors in the options are reported before any file is read.
        let network = self.view.network()?;
        let files = Files::new().reads(&self.files).describes(self.view.selection.descriptions());
        files.writes(self.input.quality_file())?;
        if self.files.iter().any(|file| is_stdin(file)) && std::io::stdin().is_terminal() {
            diagnostic(&format!("canvass: paste frames, then press {END_OF_INPUT}"));
        }
        let inputs = Inputs::open(&self.files, &self.input, &output)?;
        self.view.show(inputs, network, color, &output)
    }
}

impl View {
    /// Makes a network that knows the given devices.
    pub fn network(&self) -> Result<Network, Failure> {
        self.selection.network()
    }

    /// Prints all frames of the inputs.
    pub fn show(
        self,
        mut inputs: Inputs<'_>,
        network: Network,
        color: Color,
        output: &Output,
    ) -> Result<Status, Failure> {
        if self.events {
            return self.show_events(inputs, network, color, output);
        }
        let mut lines = self.lines(color);
        output.append(|buffer| lines.begin(buffer))?;
        let (mut range, mut comment) = (self.range, String::new());
        let mut decoding = Decoding { network, skipping: self.selection.needs_decoding().then(Skipping::default) };
        if self.in_order {
            inputs.put_in_order();
        }
        while inputs.advance()?.is_some() {
            if let Some(latest) = inputs.record().comment() {
                comment.clear();
                comment.push_str(latest);
            }
            self.show_frame(&inputs, &mut decoding, &mut range, (lines.as_mut(), &mut comment), output)?;
        }
        self.end(inputs)
    }

    fn lines(&self, color: Color) -> Box<dyn Lines> {
        let (time, color) = (self.time.style(), color.on_stdout());
        match self.format {
            DecodeFormat::Text => Box::new(TextLines::new(time, color)),
            DecodeFormat::Table => Box::new(TableLines::new(time, color, terminal_width().map(usize::from))),
            DecodeFormat::Json => Box::new(JsonLines::new()),
            DecodeFormat::Csv => Box::new(CsvLines::new(time)),
        }
    }

    fn show_events(
        self,
        mut inputs: Inputs<'_>,
        mut network: Network,
        color: Color,
        output: &Output,
    ) -> Result<Status, Failure> {
        let mut events = match self.format {
            DecodeFormat::Text => decode_events::text(self.time.style(), color),
            DecodeFormat::Json => decode_events::json(),
            DecodeFormat::Table | DecodeFormat::Csv => {
                return Err(anyhow!("--events has the formats text and json").into());
            }
        };
        decode_events::show(&mut inputs, &mut network, self.range, &self.selection, events.as_mut(), output)?;
        self.end(inputs)
    }

    fn end(&self, inputs: Inputs<'_>) -> Result<Status, Failure> {
        self.selection.warn_of_nothing(&inputs);
        if matches!(self.time, Time::Utc | Time::Local) && inputs.time_base() != TimeBase::Utc {
            let base = inputs.time_base();
            diagnostic(&format!(
                "canvass: the times of the capture count from {base}, not from 1970: no date can be shown"
            ));
        }
        inputs.finish()?;
        Ok(Status::Good)
    }

    /// Prints the latest frame if it is selected, after its comment. A comment that several frames share is printed
    /// once.
    fn show_frame(
        &self,
        inputs: &Inputs<'_>,
        Decoding { network, skipping }: &mut Decoding,
        range: &mut TimeRange,
        (lines, comment): (&mut dyn Lines, &mut String),
        output: &Output,
    ) -> std::io::Result<()> {
        let record = inputs.record();
        if skipping.as_mut().is_some_and(|skipping| skipping.set().skips(record)) {
            return Ok(());
        }
        let decoded = network.handle(record);
        let Some(bus) = network.bus(record.channel) else { return Ok(()) };
        let is_asked = range.contains(record.timestamp) && self.selection.has_channel(record, inputs);
        let is_chosen = is_asked && self.selection.has(record, &decoded, inputs);
        if let Some(skipping) = skipping {
            let refuses = |steady| is_asked && self.selection.refuses_alike(record, &decoded, inputs, steady);
            skipping.taken(bus, record, &decoded, refuses);
        }
        if !is_chosen {
            return Ok(());
        }
        let meaning = Meaning::new(record, &decoded, bus);
        let line = Line { record, channels: inputs.channels(), decoded: &decoded, meaning };
        if !comment.is_empty() {
            output.append(|buffer| lines.comment(comment, buffer))?;
            comment.clear();
        }
        output.append(|buffer| lines.line(&line, buffer))
    }
}

impl Time {
    const fn style(self) -> TimeStyle {
        match self {
            Self::Absolute => TimeStyle::Absolute,
            Self::Relative => TimeStyle::Relative,
            Self::Delta => TimeStyle::Delta,
            Self::Utc => TimeStyle::Utc,
            Self::Local => TimeStyle::Local,
        }
    }
}
