//! Reads a capture record by record, and collects its quality.

use super::access::Notes;
use super::{Access, AccessError, CaptureFile};
use canvass_traces::{
    Capture, ChannelId, Damage, Format, Frame, Merge, Naming, OpenError, Quality, ReadOptions, Record, SkipSet, Source,
    TimeBase, Timestamp,
};

/// A capture being read.
pub struct Reading {
    name: String,
    merge: Merge,
    notes: Notes,
    quality: Quality,
    record: Record,
    /// Why the capture could not be read to its end.
    stopped: Option<String>,
}

/// An item of a capture.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// A record.
    Record,
    /// A record salvaged from a frame that contradicts itself.
    Salvaged,
    /// Damage: frames may be missing here.
    Damage,
}

/// A file that is no readable capture.
pub struct Unreadable {
    /// Why the file is no readable capture.
    pub reason: String,
    /// The SHA-256 of the file in hexadecimal, if it was requested.
    pub sha256: Option<String>,
}

impl Reading {
    /// Opens a capture; with `hashes`, the SHA-256 of the file is computed while it is read.
    ///
    /// # Errors
    /// [`AccessError`] if the file can't be read. Wrong content is never an error, but [`Unreadable`].
    pub fn open(access: &Access, file: &CaptureFile, hashes: bool) -> Result<Result<Self, Unreadable>, AccessError> {
        let (reader, notes) = access.open(file, hashes)?;
        let capture = Capture::from_source(&file.name, Source::new(reader), &ReadOptions::default());
        let failed = |reason: String| AccessError::Read { name: file.name.clone(), reason };
        match capture {
            Ok(capture) => Ok(Ok(Self::of(file, capture, notes))),
            Err(error) => match notes.failure() {
                Some(reason) => Err(failed(reason)),
                None => {
                    let sha256 = if hashes { Some(access.hash(file)?) } else { None };
                    Ok(Err(Unreadable { reason: reason(&error), sha256 }))
                }
            },
        }
    }

    fn of(file: &CaptureFile, capture: Capture, notes: Notes) -> Self {
        let frame = Frame::full(canvass_traces::CanId::standard_masked(0), [0; 8]);
        Self {
            name: file.name.clone(),
            merge: Merge::new(vec![capture], Naming::BySource),
            notes,
            quality: Quality::default(),
            record: Record::new(Timestamp(0), ChannelId(0), frame),
            stopped: None,
        }
    }

    /// Reads the next item; `None` at the end.
    ///
    /// # Errors
    /// [`AccessError`] if the file can't be read further.
    #[inline]
    pub fn advance(&mut self) -> Result<Option<Seen>, AccessError> {
        match self.merge.next() {
            Some((_, Ok(record))) => {
                self.record = record;
                self.quality.record(&self.record);
                Ok(Some(Seen::Record))
            }
            Some((_, Err(damage))) => self.damaged(damage).map(Some),
            None => Ok(None),
        }
    }

    /// Reads the next item that is not skipped. The quality then does not count the records, as skipped records are not
    /// examined.
    ///
    /// # Errors
    /// As [`Reading::advance`].
    #[inline]
    pub fn advance_kept(&mut self, skip: &mut SkipSet) -> Result<Option<Seen>, AccessError> {
        match self.merge.next_kept(skip, &mut self.record) {
            Some((_, Ok(()))) => Ok(Some(Seen::Record)),
            Some((_, Err(damage))) => self.damaged(damage).map(Some),
            None => Ok(None),
        }
    }

    #[cold]
    fn damaged(&mut self, damage: Damage) -> Result<Seen, AccessError> {
        if let Some(reason) = self.notes.failure() {
            return Err(AccessError::Read { name: self.name.clone(), reason });
        }
        self.quality.damage(&damage);
        if damage.kind.is_fatal() {
            self.stopped.get_or_insert_with(|| format!("at {}: {damage}", damage.place.number));
        }
        Ok(match damage.salvaged {
            Some(record) => {
                self.record = *record;
                Seen::Salvaged
            }
            None => Seen::Damage,
        })
    }

    /// The latest record.
    pub const fn record(&self) -> &Record {
        &self.record
    }

    /// Passes the latest record to a diagnosis.
    ///
    /// # Errors
    /// If the diagnosis collects frames for a page and can't write its temporary file.
    pub fn hand_over(&mut self, diagnosis: &mut canvass_reports::diagnosis::Reading) -> std::io::Result<()> {
        diagnosis.record(&mut self.record, &self.merge)
    }

    /// The capture as a merge of a single capture.
    pub const fn merge(&self) -> &Merge {
        &self.merge
    }

    /// The quality of the capture so far.
    pub const fn quality(&self) -> &Quality {
        &self.quality
    }

    /// The format of the capture.
    pub fn format(&self) -> Option<Format> {
        self.merge.sources().next().map(Capture::format)
    }

    /// The time base of the capture, as far as it is known.
    pub fn time_base(&self) -> TimeBase {
        self.merge.sources().next().map_or(TimeBase::None, canvass_traces::Reader::time_base)
    }

    /// Why the capture could not be read to its end.
    pub fn stopped(&self) -> Option<&str> {
        self.stopped.as_deref()
    }

    /// The SHA-256 of the file in hexadecimal, if it was requested. Call it after the last item: it also hashes the
    /// bytes that the reader did not need.
    ///
    /// # Errors
    /// [`AccessError`] if the file can't be read again.
    pub fn sha256(&self, access: &Access, file: &CaptureFile) -> Result<Option<String>, AccessError> {
        match self.notes.sha256() {
            Some((hashed, _)) if hashed < file.size => access.hash(file).map(Some),
            known => Ok(known.map(|(_, sha256)| sha256)),
        }
    }
}

/// Why a file is no capture. The text does not name the file, which the caller knows.
fn reason(error: &OpenError) -> String {
    match error {
        OpenError::Io { source, .. } => source.to_string(),
        OpenError::Source { source, .. } => source.to_string(),
        OpenError::Empty(_) => "empty: expected a capture".to_owned(),
        OpenError::Unread { reason, .. } => reason.to_string(),
        OpenError::Ambiguous { question, .. } => question.to_string(),
        OpenError::Misfit { .. } => "no line is read as a frame".to_owned(),
        OpenError::Unknown { .. } => {
            let known: Vec<&str> = Format::all().map(Format::id).collect();
            format!("of no known format: expected one of {}", known.join(", "))
        }
    }
}
