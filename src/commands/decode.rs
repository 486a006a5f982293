//! `canvass decode`: captures in words.

use crate::inputs::{InputOptions, Inputs, Seen};
use crate::output::{Color, Output};
use crate::selection::Selection;
use crate::status::{Failure, Status};
use crate::time_range::TimeRange;
use canvass_analyzer::Meaning;
use canvass_analyzer::network::Network;
use canvass_reports::decode::{JsonLines, Line, Lines, TextLines, TimeStyle};
use canvass_traces::Record;
use std::path::PathBuf;

/// Decode captures: one annotated line per frame
///
/// The format of a capture is recognised by its content. Several captures are merged by time. What can't be read is
/// reported with its place and reason on standard error, and the rest is decoded.
#[derive(clap::Args)]
pub struct Args {
    /// Capture files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// How to print the frames
    #[arg(long, value_enum, default_value_t)]
    format: DecodeFormat,
    /// Which time to show
    #[arg(long, value_enum, default_value_t)]
    time: Time,
    #[command(flatten)]
    range: TimeRange,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    input: InputOptions,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum DecodeFormat {
    /// Aligned lines
    #[default]
    Text,
    /// JSON Lines
    Json,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum Time {
    /// As in the capture
    #[default]
    Absolute,
    /// Since the first frame
    Relative,
    /// Since the frame before
    Delta,
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let output = Output::default();
        let mut lines: Box<dyn Lines> = match self.format {
            DecodeFormat::Text => Box::new(TextLines::new(self.time.style(), color.on_stdout())),
            DecodeFormat::Json => Box::new(JsonLines::new()),
        };
        let (mut network, mut range) = (self.selection.network()?, self.range);
        let mut inputs = Inputs::open(&self.files, &self.input, &output)?;
        while let Some(Seen::Record(record) | Seen::Salvaged(record)) = inputs.next()? {
            self.show(&record, &inputs, &mut network, &mut range, lines.as_mut(), &output)?;
        }
        self.selection.warn_of_unknown_channels(&inputs);
        inputs.finish()?;
        Ok(Status::Good)
    }

    fn show(
        &self,
        record: &Record,
        inputs: &Inputs<'_>,
        network: &mut Network,
        range: &mut TimeRange,
        lines: &mut dyn Lines,
        output: &Output,
    ) -> std::io::Result<()> {
        let decoded = network.handle(record);
        if !range.contains(record.timestamp)
            || !self.selection.has_channel(record, inputs)
            || !self.selection.has(record, &decoded, inputs)
        {
            return Ok(());
        }
        let Some(bus) = network.bus(record.channel) else { return Ok(()) };
        let meaning = Meaning::new(record, &decoded, bus);
        let line = Line { record, channels: inputs.channels(), decoded: &decoded, meaning };
        output.append(|buffer| lines.line(&line, buffer))
    }
}

impl Time {
    const fn style(self) -> TimeStyle {
        match self {
            Self::Absolute => TimeStyle::Absolute,
            Self::Relative => TimeStyle::Relative,
            Self::Delta => TimeStyle::Delta,
        }
    }
}
