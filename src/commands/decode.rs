//! `canvass decode`: captures in words.

use crate::damages::Damages;
use crate::devices::{DeviceArg, parse_node};
use crate::output::{Color, Output};
use crate::status::{Failure, Status};
use crate::time_range::TimeRange;
use anyhow::anyhow;
use canvass_analyzer::filter::{Filter, Subject};
use canvass_analyzer::network::{Decoded, Network};
use canvass_analyzer::{Meaning, NodeId};
use canvass_reports::decode::{JsonLines, Line, Lines, TextLines, TimeStyle};
use canvass_traces::{Capture, Format, ReadOptions, Reader, Record, Source};
use std::path::{Path, PathBuf};

/// Decode captures: one annotated line per frame
///
/// The format of a capture is recognised by its content. What can't be read is reported with its place and reason on
/// standard error, and the rest is decoded.
#[derive(clap::Args)]
pub struct Args {
    /// Capture files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// How to print the frames
    #[arg(long, value_enum, default_value_t)]
    format: DecodeFormat,
    /// The format of the captures, where it is not recognised
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    format_in: Option<Format>,
    /// Which time to show
    #[arg(long, value_enum, default_value_t)]
    time: Time,
    /// Show only frames of these nodes
    #[arg(long, value_name = "NODE", value_parser = parse_node, value_delimiter = ',')]
    node: Vec<NodeId>,
    #[command(flatten)]
    range: TimeRange,
    /// Show only frames that pass this filter, such as 'service=sdo and node in 1..8 and index=0x6003 or abort'
    #[arg(long, value_name = "EXPRESSION")]
    filter: Option<Filter>,
    /// Which device a node is: a built-in model or an EDS or DCF file
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    /// Stop with status 2 at the first thing that can't be read
    #[arg(long)]
    strict: bool,
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

pub fn parse_format(id: &str) -> Result<Format, String> {
    Format::by_id(id).ok_or_else(|| {
        let known: Vec<_> = Format::all().map(Format::id).collect();
        format!("expected one of {}", known.join(", "))
    })
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let output = Output::default();
        let mut lines: Box<dyn Lines> = match self.format {
            DecodeFormat::Text => Box::new(TextLines::new(self.time.style(), color.on_stdout())),
            DecodeFormat::Json => Box::new(JsonLines::new()),
        };
        let mut damages = Damages::default();
        for file in &self.files {
            let (mut network, mut range) = (self.network()?, self.range);
            let mut capture = self.open(file, &output)?;
            while let Some(item) = capture.next() {
                match item {
                    Ok(record) => self.show(&record, &capture, &mut network, &mut range, lines.as_mut(), &output)?,
                    Err(damage) => {
                        output.flush()?;
                        damages.report(capture.name(), &damage);
                        if let Some(record) = &damage.salvaged {
                            self.show(record, &capture, &mut network, &mut range, lines.as_mut(), &output)?;
                        }
                        if self.strict || damage.kind.is_fatal() {
                            output.flush()?;
                            return Err(anyhow!("{}: stopped there", capture.name()).into());
                        }
                    }
                }
            }
        }
        output.flush()?;
        damages.summarise();
        Ok(Status::Good)
    }

    fn passes(&self, record: &Record, decoded: &Decoded, capture: &Capture) -> bool {
        let node = self.node.is_empty() || decoded.node.is_some_and(|node| self.node.contains(&node));
        let subject = Subject { record, decoded, channel: capture.channels().name(record.channel) };
        node && self.filter.as_ref().is_none_or(|filter| filter.matches(&subject))
    }

    fn network(&self) -> Result<Network, Failure> {
        let mut network = Network::new();
        for device in &self.device {
            network.describe(device.node, device.describe()?);
        }
        Ok(network)
    }

    fn open(&self, file: &Path, output: &Output) -> Result<Capture, Failure> {
        let options = ReadOptions { format: self.format_in, ..ReadOptions::default() };
        if file.as_os_str() == "-" {
            let source = Source::new(output.flushed_by_stdin());
            return Ok(Capture::from_source("-", source, &options)?);
        }
        Ok(Capture::open(file, &options)?)
    }

    fn show(
        &self,
        record: &Record,
        capture: &Capture,
        network: &mut Network,
        range: &mut TimeRange,
        lines: &mut dyn Lines,
        output: &Output,
    ) -> std::io::Result<()> {
        let decoded = network.handle(record);
        if !range.contains(record.timestamp) || !self.passes(record, &decoded, capture) {
            return Ok(());
        }
        let Some(bus) = network.bus(record.channel) else { return Ok(()) };
        let meaning = Meaning::new(record, &decoded, bus);
        let line = Line { record, channels: capture.channels(), decoded: &decoded, meaning };
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
