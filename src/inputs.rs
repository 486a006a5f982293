//! The captures that a command reads: opened, merged, and watched for damage and quality.

use crate::damages::Damages;
use crate::interrupt::Interrupt;
use crate::output::{Output, diagnostic};
use crate::quality::QualityOptions;
use crate::status::Failure;
use crate::stdin;
use anyhow::{Result, anyhow};
use canvass_reports::quality::CaptureQuality;
use canvass_traces::{
    CanId, Capture, ChannelId, Channels, Damage, Format, Frame, Merge, Naming, Quality, ReadOptions, Reader, Record,
    Source, TimeBase, Timestamp,
};
use std::path::{Path, PathBuf};

/// How captures are read.
#[derive(clap::Args, Default)]
pub struct InputOptions {
    /// The format of the captures, where it is not recognised
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    format_in: Option<Format>,
    /// Read only these topics, in formats that have topics (MCAP)
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    topic: Vec<String>,
    /// Several files are of the same bus or buses: keep the channels' names, and take equal names for one channel
    ///
    /// Without it, the channels of several files are told apart as FILE:CHANNEL.
    #[arg(long)]
    same_bus: bool,
    /// Stop with status 2 at the first thing that can't be read
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    quality: QualityOptions,
}

/// The format with that id, as clap wants to know it.
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
    /// How many there were so far: asked for at every record.
    damage_count: u64,
    /// By source.
    quality: Vec<Quality>,
    /// What came out last. It stays here: moving it costs as much as reading it.
    record: Record,
    output: Output,
    interrupt: Interrupt,
    is_live: bool,
    /// The first source that could not be read to its end.
    stopped: Option<String>,
}

/// What has come out of the captures: [`Inputs::record`] is it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// A record.
    Record,
    /// What makes sense of a frame that contradicts itself; its damage was reported.
    Salvaged,
}

impl<'a> Inputs<'a> {
    /// Opens all files; `output` is flushed before anything is reported, and while standard input has nothing.
    pub fn open(files: &[PathBuf], options: &'a InputOptions, output: &Output) -> Result<Self, Failure> {
        let interrupt = Interrupt::watch()?;
        let is_live = files.iter().any(|file| is_stdin(file));
        let captures = files.iter().map(|file| options.open(file, output, &interrupt)).collect::<Result<Vec<_>>>()?;
        Ok(Self::merged(captures, options, output, interrupt, is_live))
    }

    /// A live bus.
    pub fn live(capture: Capture, options: &'a InputOptions, output: &Output, interrupt: Interrupt) -> Self {
        Self::merged(vec![capture], options, output, interrupt, true)
    }

    fn merged(
        captures: Vec<Capture>,
        options: &'a InputOptions,
        output: &Output,
        interrupt: Interrupt,
        is_live: bool,
    ) -> Self {
        let naming = if options.same_bus { Naming::SameBus } else { Naming::BySource };
        Self {
            options,
            quality: vec![Quality::default(); captures.len()],
            record: Record::new(Timestamp(0), ChannelId(0), Frame::full(CanId::standard_masked(0), [0; 8])),
            merge: Merge::new(captures, naming),
            damages: Damages::default(),
            damage_count: 0,
            output: output.clone(),
            interrupt,
            is_live,
            stopped: None,
        }
    }

    /// Goes on to what comes next; `None` at the end or when interrupted.
    ///
    /// # Errors
    /// With `--strict`, the first damage.
    pub fn advance(&mut self) -> Result<Option<Seen>, Failure> {
        while !self.interrupt.came()
            && let Some((source, item)) = self.merge.next()
        {
            match item {
                Ok(record) => {
                    self.record = record;
                    if let Some(quality) = self.quality.get_mut(source) {
                        quality.record(&self.record);
                    }
                    return Ok(Some(Seen::Record));
                }
                // Its end is not the file's: a last line may be cut there.
                Err(_) if self.interrupt.came() => {}
                Err(damage) => {
                    self.report(source, &damage)?;
                    if let Some(record) = damage.salvaged {
                        self.record = *record;
                        return Ok(Some(Seen::Salvaged));
                    }
                }
            }
        }
        Ok(None)
    }

    /// What came out last.
    pub const fn record(&self) -> &Record {
        &self.record
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

    /// How many damages there were so far, frames that a recorder lost included: frames may be missing there.
    pub const fn damages(&self) -> u64 {
        self.damage_count
    }

    fn count_damages(&self) -> u64 {
        let counts = self.quality.iter().flat_map(|quality| quality.damages.by_kind());
        counts.map(|(_, count)| count).fold(0, u64::saturating_add)
    }

    /// Whether standard input is among them: frames may come as they are seen.
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

    /// What the times count from, as far as it has shown.
    pub fn time_base(&self) -> TimeBase {
        self.merge.time_base()
    }

    /// Says what has come of reading.
    ///
    /// # Errors
    /// If a file could not be read to its end, or the reading of files was interrupted.
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

    /// The captures, and how far each can be trusted so far.
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

fn is_stdin(file: &Path) -> bool {
    file.as_os_str() == "-"
}

impl InputOptions {
    fn open(&self, file: &Path, output: &Output, interrupt: &Interrupt) -> Result<Capture> {
        let options = ReadOptions { format: self.format_in, topics: self.topic.clone() };
        if is_stdin(file) {
            let source = Source::new(stdin::live(output.clone(), interrupt.clone()));
            return Ok(Capture::from_source("-", source, &options)?);
        }
        Ok(Capture::open(file, &options)?)
    }
}
