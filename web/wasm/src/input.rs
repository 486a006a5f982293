//! The captures of a page as one, with what could not be read in them.

use crate::file::{ChosenFile, FileReader, Seen};
use canvass_reports::quality::CaptureQuality;
use canvass_traces::{
    Capture, Damage, DamageKind, Format, Merge, Naming, OpenError, Quality, ReadOptions, Record, Source,
};

/// How captures are read.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(default)]
pub struct InputOptions {
    /// The id of their format, where it is not recognised.
    pub format: Option<String>,
    /// Equal names of channels are one channel.
    pub same_bus: bool,
}

/// Captures that are being read.
pub struct Input {
    merge: Merge,
    quality: Vec<Quality>,
    files: Vec<(ChosenFile, Seen)>,
    /// How many damages there were.
    damages: u64,
    told: Vec<String>,
}

/// What came out.
pub enum Next {
    /// A record.
    Record(Record),
    /// What makes sense of a frame that contradicts itself.
    Salvaged(Record),
    /// Something that can't be read.
    Damage,
}

impl Input {
    /// Maximum number of damages that are reported one by one.
    const TOLD: usize = 100;

    /// Opens them all.
    ///
    /// # Errors
    /// [`OpenError`] of the first that can't be opened.
    pub fn open(files: &[ChosenFile], options: &InputOptions, hashed: bool) -> Result<Self, OpenError> {
        let format = options.format.as_deref().and_then(Format::by_id);
        let read_options = ReadOptions { format, topics: Vec::new() };
        let seen = || if hashed { Seen::hashed() } else { Seen::default() };
        let files: Vec<_> = files.iter().map(|file| (file.clone(), seen())).collect();
        let open = |(file, seen): &(ChosenFile, Seen)| {
            let reader = FileReader::new(file.clone(), seen.clone());
            Capture::from_source(&file.name, Source::new(reader), &read_options)
        };
        let captures = files.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let naming = if options.same_bus { Naming::SameBus } else { Naming::BySource };
        let quality = vec![Quality::default(); captures.len()];
        Ok(Self { merge: Merge::new(captures, naming), quality, files, damages: 0, told: Vec::new() })
    }

    /// What comes next.
    #[inline]
    pub fn advance(&mut self) -> Option<Next> {
        let (source, item) = self.merge.next()?;
        match item {
            Ok(record) => {
                if let Some(quality) = self.quality.get_mut(source) {
                    quality.record(&record);
                }
                Some(Next::Record(record))
            }
            Err(damage) => Some(self.damaged(source, damage)),
        }
    }

    #[cold]
    fn damaged(&mut self, source: usize, damage: Damage) -> Next {
        if let Some(quality) = self.quality.get_mut(source) {
            quality.damage(&damage);
        }
        let counts = self.quality.iter().flat_map(|quality| quality.damages.by_kind());
        self.damages = counts.map(|(_, count)| count).fold(0, u64::saturating_add);
        if self.told.len() < Self::TOLD || matches!(damage.kind, DamageKind::Fatal) {
            let column = damage.column.map(|column| format!(":{column}")).unwrap_or_default();
            self.told.push(format!("{}:{}{column}: {damage}", self.merge.name(source), damage.place.number));
        }
        damage.salvaged.map_or(Next::Damage, |record| Next::Salvaged(*record))
    }

    /// How many things could not be read so far, frames that a recorder lost included.
    pub const fn damages(&self) -> u64 {
        self.damages
    }

    /// The first of them, in words.
    pub fn told(&self) -> &[String] {
        &self.told
    }

    /// The captures as one.
    pub const fn merge(&self) -> &Merge {
        &self.merge
    }

    /// How many bytes of the files were read.
    pub fn read(&self) -> u64 {
        self.files.iter().map(|(_, seen)| seen.bytes()).sum()
    }

    /// The captures and how far each can be trusted.
    pub fn captures(&self) -> Vec<CaptureQuality<'_>> {
        let captures = self.merge.sources().zip(&self.quality);
        captures.map(|(capture, quality)| CaptureQuality::new(capture, quality)).collect()
    }

    /// The files and what was read of them.
    pub fn files(&self) -> &[(ChosenFile, Seen)] {
        &self.files
    }
}
