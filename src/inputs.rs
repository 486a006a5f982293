//! The captures that a command reads: opens and merges them, and reports damage and quality.

use crate::damages::Damages;
use crate::interrupt::Interrupt;
use crate::live_source::{live, may_wait};
use crate::output::{Output, diagnostic};
use crate::progress::Progress;
use crate::quality::QualityOptions;
use crate::status::Failure;
use anyhow::{Result, anyhow};
use canvass_analyzer::findings::InOrder;
use canvass_reports::diagnosis::Reading;
use canvass_reports::quality::CaptureQuality;
use canvass_traces::{
    CanId, Capture, ChannelId, Channels, Columns, Damage, Format, Frame, Merge, Naming, OpenError, Quality,
    ReadOptions, Reader, Record, Source, TimeBase, Timestamp,
};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Options for reading captures.
#[derive(clap::Args, Default)]
pub struct InputOptions {
    /// The format of the captures, if canvass does not recognise it
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    format_in: Option<Format>,
    /// Read only these topics, in formats that have topics (MCAP)
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    topic: Vec<String>,
    /// The meaning of the numbers in pasted lines, where they fit several readings: time[ms],id,len,data
    #[arg(long, value_name = "NAMES")]
    columns: Option<Columns>,
    /// All files are from the same bus or buses: keep the channel names, and treat equal names as one channel
    ///
    /// Without it, the channels of several files are distinguished as FILE:CHANNEL.
    #[arg(long)]
    same_bus: bool,
    /// Stop with exit status 2 at the first damage
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    quality: QualityOptions,
}

/// Parses the id of a format, for clap.
pub fn parse_format(id: &str) -> Result<Format, String> {
    Format::by_id(id).ok_or_else(|| format!("expected one of {}", format_ids()))
}

/// The ids of all formats, for messages.
pub fn format_ids() -> String {
    Format::all().map(Format::id).collect::<Vec<_>>().join(", ")
}

/// The captures, merged by time.
pub struct Inputs<'a> {
    options: &'a InputOptions,
    merge: Merge,
    damages: Damages,
    /// Number of damages so far; kept here because it is needed for every record.
    damage_count: u64,
    /// The quality of each source.
    quality: Vec<Quality>,
    /// The latest record. It stays in place: moving it costs as much as reading it.
    record: Record,
    /// Sorts records by time, with `--in-order`.
    order: Option<Box<InOrder>>,
    output: Output,
    interrupt: Interrupt,
    is_live: bool,
    /// Whether the source ends itself on Ctrl-C and reports its end. The reader then does not check for Ctrl-C.
    ends_itself: bool,
    /// The first source that could not be read to its end.
    stopped: Option<String>,
}

/// The kind of the latest record, [`Inputs::record`].
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum RecordKind {
    Record,
    /// A frame salvaged from damage; it contradicts itself, and the damage was reported.
    Salvaged,
}

impl<'a> Inputs<'a> {
    /// Opens all files. `output` is flushed before each message, and while standard input has no data.
    pub fn open(files: &[PathBuf], options: &'a InputOptions, output: &Output) -> Result<Self, Failure> {
        let interrupt = Interrupt::watch()?;
        let is_live = files.iter().any(|file| is_stdin(file) || may_wait(file));
        let progress = Progress::of(files.iter().map(PathBuf::as_path), output);
        let open = |file: &PathBuf| options.open(file, output, &interrupt, &progress);
        let opened = files.iter().map(open).collect::<Result<Vec<_>>>();
        let captures = opened.map_err(|error| {
            // If Ctrl-C comes before the first byte of an input, the input looks empty.
            if interrupt.came() { anyhow!("interrupted before any input arrived") } else { error }
        })?;
        for capture in &captures {
            if let Some(interpretation) = capture.interpretation() {
                diagnostic(&format!("canvass: {}: read as: {interpretation}", capture.name()));
            }
        }
        Ok(Self { is_live, ..Self::merged(captures, options, output, interrupt) })
    }

    /// Reads a live bus.
    pub fn live(capture: Capture, options: &'a InputOptions, output: &Output, interrupt: Interrupt) -> Self {
        Self { is_live: true, ends_itself: true, ..Self::merged(vec![capture], options, output, interrupt) }
    }

    fn merged(captures: Vec<Capture>, options: &'a InputOptions, output: &Output, interrupt: Interrupt) -> Self {
        let naming = if options.same_bus { Naming::SameBus } else { Naming::BySource };
        Self {
            options,
            quality: vec![Quality::default(); captures.len()],
            record: Record::new(Timestamp(0), ChannelId(0), Frame::full(CanId::standard_masked(0), [0; 8])),
            order: None,
            merge: Merge::new(captures, naming),
            damages: Damages::default(),
            damage_count: 0,
            output: output.clone(),
            interrupt,
            is_live: false,
            ends_itself: false,
            stopped: None,
        }
    }

    /// Sorts records that are out of order by up to [`InOrder::WINDOW`].
    pub fn put_in_order(&mut self) {
        self.order = Some(Box::default());
    }

    /// Reads the next record; `None` at the end or after Ctrl-C.
    ///
    /// # Errors
    /// With `--strict`, the first damage.
    pub fn advance(&mut self) -> Result<Option<RecordKind>, Failure> {
        if self.order.is_some() { self.advance_in_order() } else { self.read() }
    }

    /// Reads on until the oldest record may be returned.
    #[cold]
    fn advance_in_order(&mut self) -> Result<Option<RecordKind>, Failure> {
        let mut is_at_end = false;
        while let Some(order) = &mut self.order {
            let next = if is_at_end { order.flush() } else { order.pop() };
            if let Some(next) = next {
                self.record.clone_from(next);
                return Ok(Some(RecordKind::Record));
            }
            if is_at_end {
                break;
            }
            is_at_end = self.read()?.is_none();
            if let (Some(order), false) = (&mut self.order, is_at_end) {
                order.push(&mut self.record);
            }
        }
        Ok(None)
    }

    /// Reads the next record, without sorting.
    #[inline]
    fn read(&mut self) -> Result<Option<RecordKind>, Failure> {
        while (self.ends_itself || !self.interrupt.came())
            && let Some((source, item)) = self.merge.next()
        {
            match item {
                Ok(record) => {
                    self.record = record;
                    if let Some(quality) = self.quality.get_mut(source) {
                        quality.record(&self.record);
                    }
                    return Ok(Some(RecordKind::Record));
                }
                // After Ctrl-C the last line may be cut off, which is no damage of the file.
                Err(_) if self.interrupt.came() && !self.ends_itself => {}
                Err(damage) => {
                    self.report(source, &damage)?;
                    if let Some(record) = damage.salvaged {
                        self.record = *record;
                        return Ok(Some(RecordKind::Salvaged));
                    }
                }
            }
        }
        Ok(None)
    }

    /// The latest record.
    pub const fn record(&self) -> &Record {
        &self.record
    }

    /// Moves the latest record to `reading`; afterwards [`Inputs::record`] is undefined.
    pub fn hand_over(&mut self, reading: &mut Reading) -> io::Result<()> {
        reading.record(&mut self.record, &self.merge)
    }

    /// The merged captures.
    pub const fn merge(&self) -> &Merge {
        &self.merge
    }

    fn report(&mut self, source: usize, damage: &Damage) -> Result<(), Failure> {
        self.output.flush()?;
        if let Some(quality) = self.quality.get_mut(source) {
            quality.damage(damage);
        }
        self.damage_count = self.count_damages();
        let name = self.merge.name(source);
        self.damages.report(name, damage);
        if self.options.strict {
            return Err(stopped(name).into());
        }
        if damage.kind.is_fatal() {
            self.stopped.get_or_insert_with(|| name.to_owned());
        }
        Ok(())
    }

    /// Number of damages so far, including losses reported by the recorder; each may hide missing frames.
    pub const fn damages(&self) -> u64 {
        self.damage_count
    }

    fn count_damages(&self) -> u64 {
        let counts = self.quality.iter().flat_map(|quality| quality.damages.by_kind());
        counts.map(|(_, count)| count).fold(0, u64::saturating_add)
    }

    /// Whether standard input is among the captures, so that frames may arrive live.
    pub fn is_live(&self) -> bool {
        self.is_live
    }

    /// The channels seen so far.
    pub fn channels(&self) -> &Channels {
        self.merge.channels()
    }

    /// A channel's name in its own file.
    pub fn own_name(&self, channel: ChannelId) -> &str {
        self.merge.own_name(channel)
    }

    /// The time base of the captures, as far as it is known.
    pub fn time_base(&self) -> TimeBase {
        self.merge.time_base()
    }

    /// Prints the totals of the damage, the quality if it is wanted, and a warning if the times of the captures count
    /// from different origins.
    ///
    /// # Errors
    /// If the quality can't be written, a file could not be read to its end, or Ctrl-C interrupted the reading.
    pub fn finish(self) -> Result<(), Failure> {
        self.output.flush()?;
        self.damages.summarise();
        self.warn_of_time_bases();
        self.options.quality.report(&self.captures(), self.merge.channels())?;
        match self.stopped {
            Some(name) => Err(stopped(&name).into()),
            None if self.interrupt.came() && !self.is_live => Err(anyhow!("interrupted: the rest was not read").into()),
            None => Ok(()),
        }
    }

    /// The captures, and their quality so far.
    pub fn captures(&self) -> Vec<CaptureQuality<'_>> {
        let captures = self.merge.sources().zip(&self.quality);
        captures.map(|(capture, quality)| CaptureQuality::new(capture, quality)).collect()
    }

    fn warn_of_time_bases(&self) {
        let Some(odd) = self.merge.odd_source() else { return };
        let base = |at: usize| self.merge.sources().nth(at).map(Reader::time_base).unwrap_or_default();
        diagnostic(&format!(
            "canvass: times of {} count from {}, those of {} from {}: they are merged as numbers",
            self.merge.name(0),
            base(0),
            self.merge.name(odd),
            base(odd)
        ));
    }
}

fn stopped(name: &str) -> anyhow::Error {
    anyhow!("{name}: stopped there")
}

/// Whether the path stands for standard input.
pub fn is_stdin(file: &Path) -> bool {
    file.as_os_str() == "-"
}

impl InputOptions {
    /// The output file of `--quality`, if there is one.
    pub fn quality_file(&self) -> Option<&Path> {
        self.quality.file()
    }

    fn open(&self, file: &Path, output: &Output, interrupt: &Interrupt, progress: &Progress) -> Result<Capture> {
        let options = ReadOptions { format: self.format_in, topics: self.topic.clone(), columns: self.columns.clone() };
        let (output, interrupt) = (output.clone(), interrupt.clone());
        if is_stdin(file) {
            let source = Source::new(live(|| Ok(io::stdin()), output, interrupt));
            return Ok(Capture::from_source("-", source, &options)?);
        }
        if may_wait(file) {
            let path = file.to_owned();
            let source = Source::new(live(move || File::open(path), output, interrupt));
            return Ok(Capture::from_source(&file.display().to_string(), source, &options)?);
        }
        let opened = File::open(file).map_err(|source| OpenError::Io { path: file.to_owned(), source })?;
        let name = file.display().to_string();
        Ok(Capture::from_source(&name, Source::new(progress.count(opened)), &options)?)
    }
}
