//! The captures of a page, merged, with their damage.

use crate::file::{ChosenFile, FileReader, Seen};
use canvass_reports::quality::CaptureQuality;
use canvass_traces::{
    Capture, Damage, DamageKind, Format, Merge, Naming, OpenError, Quality, ReadOptions, Record, Source,
};

/// Options for reading captures.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(default)]
pub struct InputOptions {
    /// The id of the captures' format; `None`: recognised by the content.
    pub format: Option<String>,
    /// Whether equal names of channels mean the same channel.
    pub same_bus: bool,
}

/// Captures being read.
pub struct Input {
    merge: Merge,
    quality: Vec<Quality>,
    files: Vec<(ChosenFile, Seen)>,
    /// Number of damages so far.
    damages: u64,
    told: Vec<String>,
}

/// The next item of the captures.
pub enum Next {
    /// A record.
    Record(Record),
    /// A record salvaged from a frame that contradicts itself.
    Salvaged(Record),
    /// Damage: frames may be missing here.
    Damage,
}

impl Input {
    /// Maximum number of damages that are reported one by one.
    const TOLD: usize = 100;

    /// Opens all captures.
    ///
    /// # Errors
    /// [`OpenError`] of the first capture that can't be opened.
    pub fn open(files: &[ChosenFile], options: &InputOptions, hashed: bool) -> Result<Self, OpenError> {
        let format = options.format.as_deref().and_then(Format::by_id);
        let read_options = ReadOptions { format, ..ReadOptions::default() };
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

    /// The next item; `None` at the end.
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

    /// Number of damages so far, including frames that a recorder lost.
    pub const fn damages(&self) -> u64 {
        self.damages
    }

    /// The first damages as text.
    pub fn told(&self) -> &[String] {
        &self.told
    }

    /// The merged captures.
    pub const fn merge(&self) -> &Merge {
        &self.merge
    }

    /// Number of bytes read of all files.
    pub fn read(&self) -> u64 {
        self.files.iter().map(|(_, seen)| seen.bytes()).sum()
    }

    /// The captures with their quality.
    pub fn captures(&self) -> Vec<CaptureQuality<'_>> {
        let captures = self.merge.sources().zip(&self.quality);
        captures.map(|(capture, quality)| CaptureQuality::new(capture, quality)).collect()
    }

    /// The files, with the part that was read of each.
    pub fn files(&self) -> &[(ChosenFile, Seen)] {
        &self.files
    }
}
