//! `canvass convert`: captures from one format to another.

use crate::destination::{Destination, complete_beginning};
use crate::files::Files;
use crate::inputs::{InputOptions, Inputs, RecordKind, format_ids};
use crate::output::{Output, diagnostic};
use crate::selection::Selection;
use crate::status::{Failure, Status};
use crate::time_range::{TimePoint, TimeRange};
use crate::whole_file::WholeFile;
use anyhow::{anyhow, bail};
use canvass_analyzer::network::Network;
use canvass_traces::{Format, Loss, Losses, Record, Recording, WriteOptions, Writer};
use std::path::PathBuf;
use std::str::FromStr;

/// Convert captures to another format
///
/// The extension of OUT gives the output format; .gz or .zst after it compresses the file. --to names another format.
/// Several captures are merged by time. Standard error reports what can't be read and what the output format can't
/// hold. On Ctrl-C the file is completed.
#[derive(clap::Args)]
#[command(override_usage = "canvass convert [OPTIONS] <IN>... <OUT>")]
#[command(after_help = "\
Examples:
  canvass convert field.mcap field.log             a candump log
  canvass convert a.trc b.asc both.pcapng          two recorders' captures as one, by time
  canvass convert in.log out.asc --from +10 --to +20 --node 5,6
  candump -L can0 | canvass convert - --to pcapng live.pcapng.zst")]
pub struct Args {
    /// Capture files, and the file to write; - is standard input or output
    #[arg(required = true, value_name = "IN... OUT")]
    files: Vec<PathBuf>,
    /// The output format, such as pcapng, or a time as for --from, after which frames are left out. Can be given once
    /// for each of the two
    #[arg(long, value_name = "FORMAT|TIME")]
    to: Vec<To>,
    /// Leave out frames before this time: seconds as in the capture, +SECONDS since its first frame, or
    /// 2025-01-28T10:47:15Z
    #[arg(long, value_name = "TIME")]
    from: Option<TimePoint>,
    /// Overwrite OUT if it exists
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    input: InputOptions,
}

/// A value of `--to`: a format or a time.
#[derive(Clone, Copy, PartialEq, Debug)]
enum To {
    Format(Format),
    Time(TimePoint),
}

impl FromStr for To {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(format) = Format::by_id(text) {
            return Ok(Self::Format(format));
        }
        // A text that does not begin like a time is reported as an unknown format.
        text.parse()
            .map(Self::Time)
            .map_err(|_| format!("expected a format ({}) or a time (12.5, +12.5, 2025-01-28T10:47:15Z)", format_ids()))
    }
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let (to_format, to_time) = formats_and_times(&self.to)?;
        let (out, files) = match self.files.split_last() {
            Some((out, files)) if !files.is_empty() => (out, files),
            _ => return Err(anyhow!("expected captures to read and a file to write, such as: in.log out.asc").into()),
        };
        let destination = Destination::new(out, to_format, self.force)?;
        let used = Files::new().reads(files).describes(self.selection.descriptions());
        used.writes([out])?.writes(self.input.quality_file())?;
        let output = Output::capture();
        let mut inputs = Inputs::open(files, &self.input, &output)?;
        let (sink, whole) = match inputs.is_live() {
            true => (destination.open_growing(&output)?, None),
            false => destination.open(&output)?,
        };
        let mut conversion = Conversion {
            selection: &self.selection,
            network: self.selection.network()?,
            range: TimeRange::new(self.from, to_time),
            sink: Some(sink),
            whole,
            flushes: inputs.is_live() && destination.is_stdout(),
            destination,
            recording: None,
        };
        let converted = conversion.run(&mut inputs);
        // The file is completed also after an error, so that its frames can be read.
        let finished = conversion.finish(&inputs);
        converted?;
        finished?;
        self.selection.warn_of_nothing(&inputs);
        inputs.finish()?;
        Ok(Status::Good)
    }
}

/// The format and the time among the values of `--to`.
fn formats_and_times(to: &[To]) -> anyhow::Result<(Option<Format>, Option<TimePoint>)> {
    let (mut format, mut time) = (None, None);
    for to in to {
        let before = match *to {
            To::Format(new) => format.replace(new).is_some(),
            To::Time(new) => time.replace(new).is_some(),
        };
        if before {
            bail!("--to names two formats or two times: expected one of each at most");
        }
    }
    Ok((format, time))
}

struct Conversion<'a> {
    selection: &'a Selection,
    network: Network,
    range: TimeRange,
    destination: Destination,
    sink: Option<Box<dyn std::io::Write>>,
    /// The file that gets its final name when it is complete; `None` for standard output.
    whole: Option<WholeFile>,
    /// The output; opened with the first record, whose time base its header needs.
    recording: Option<Recording>,
    /// Whether each frame is written out at once, for a live reader.
    flushes: bool,
}

impl Conversion<'_> {
    fn run(&mut self, inputs: &mut Inputs<'_>) -> Result<(), Failure> {
        while let Some(kind) = inputs.advance()? {
            // A salvaged frame contradicts itself; in the output it would look like a good frame.
            if kind == RecordKind::Record && self.chooses(inputs.record(), inputs) {
                let flushes = self.flushes;
                let recording = self.recording(inputs)?;
                recording.write(inputs.record(), inputs.channels())?;
                if flushes {
                    recording.flush()?;
                }
            }
        }
        Ok(())
    }

    fn chooses(&mut self, record: &Record, inputs: &Inputs<'_>) -> bool {
        let selection = self.selection;
        // The meaning of a frame may depend on all frames before it.
        let decoded = selection.needs_decoding().then(|| self.network.handle(record));
        self.range.contains(record.timestamp)
            && selection.has_channel(record, inputs)
            && decoded.is_none_or(|decoded| selection.has(record, &decoded, inputs))
    }

    fn recording(&mut self, inputs: &Inputs<'_>) -> Result<&mut Recording, Failure> {
        if let Some(sink) = self.sink.take() {
            let (time_base, live) = (inputs.time_base(), self.flushes);
            let options = WriteOptions { time_base, live, ..WriteOptions::default() };
            let Destination { format, compression, .. } = self.destination;
            self.recording = Some(Recording::create(sink, format, compression, &options)?);
        }
        self.recording.as_mut().ok_or_else(|| anyhow!("the output could not be opened").into())
    }

    fn finish(&mut self, inputs: &Inputs<'_>) -> Result<(), Failure> {
        let (format, whole) = (self.destination.format, self.whole.take());
        let recording = self.recording(inputs)?;
        recording.finish()?;
        if let Some(whole) = whole {
            complete_beginning(whole.writer()?, recording)?;
            whole.complete()?;
        }
        report_losses(format, recording.losses());
        Ok(())
    }
}

fn report_losses(format: Format, losses: &Losses) {
    for (loss, frames) in losses.iter() {
        let plural = if frames == 1 { "" } else { "s" };
        diagnostic(&match loss {
            Loss::Frame => format!("canvass: {format} can't hold {}: {frames} frame{plural} left out", loss.name()),
            _ => format!("canvass: {format} can't hold {}: dropped from {frames} frame{plural}", loss.name()),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn to_names_a_format_a_time_or_both() {
        let parsed = |texts: &[&str]| formats_and_times(&texts.iter().map(|t| t.parse().unwrap()).collect::<Vec<_>>());
        assert_eq!(parsed(&["pcapng"]).unwrap(), (Some(Format::Pcapng), None));
        assert_eq!(parsed(&["+5", "csv"]).unwrap(), (Some(Format::PythonCanCsv), Some("+5".parse().unwrap())));
        assert!(parsed(&["csv", "asc"]).is_err());
        assert!(parsed(&["1", "2"]).is_err());
        assert!("xlsx".parse::<To>().unwrap_err().contains("pcapng"));
    }
}
