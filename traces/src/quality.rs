//! The quality of a capture: its content, its losses, and the reliability of its clock.
//!
//! Frames and damages are counted in the order of their source, in constant memory.
//!
//! - **Time resolution**: the largest power of ten, of at most one second, that divides all times seen. A clock of
//!   10 ms shows as 10 ms; a fine clock shows its last digit within a few frames.
//! - **Clock steps**: a frame that is older than the one before it in the same source.
//! - **Gaps**: an interval of more than [`Gaps::FACTOR`] times the usual one. About 99 of 100 intervals are not longer
//!   than the *usual* one, which adapts: a longer interval raises it by a quarter, a shorter one lowers it by 1/512. (A
//!   median would take every pause between the bursts of a SYNC cycle for a gap.) The usual interval begins at 1 s and
//!   counts as at least 10 ms, so an interval of 10 s is a gap at the beginning, and less than 100 ms never is.

mod clock;
mod gaps;

pub use clock::{ClockSteps, Resolution};
pub use gaps::{Gap, Gaps};

use crate::{ChannelId, Damage, DamageKind, Duration, Frame, Place, Record, Timestamp};

/// The quality of one source, or of all sources together.
///
/// ```
/// use canvass_traces::{Capture, Quality, ReadOptions, Reader, Source};
///
/// let log = "(1.000000) can0 705#05\n(2.500000) can0 70\n(4.000000) can0 705#R1\n";
/// let mut capture = Capture::from_source("a.log", Source::from_bytes(log), &ReadOptions::default())?;
/// let mut quality = Quality::default();
/// while let Some(item) = capture.next() {
///     match item {
///         Ok(record) => quality.record(&record),
///         Err(damage) => quality.damage(&damage),
///     }
/// }
/// assert_eq!((quality.frames.standard, quality.frames.remote, quality.damages.malformed), (1, 1, 1));
/// assert_eq!(quality.duration().as_millis(), 3000.0);
/// # Ok::<(), canvass_traces::OpenError>(())
/// ```
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Quality {
    /// The frames by kind.
    pub frames: FrameCounts,
    /// The frames by channel: the index is the [`ChannelId`].
    pub channels: Vec<u64>,
    /// Unreadable parts of the source.
    pub damages: DamageCounts,
    /// The time of the first frame.
    pub first: Option<Timestamp>,
    /// The time of the last frame.
    pub last: Option<Timestamp>,
    /// Backward steps of the clock.
    pub steps: ClockSteps,
    /// Resolution of the times.
    pub resolution: Resolution,
    /// Intervals without recorded frames.
    pub gaps: Gaps,
    /// Number of frames with exactly the time of the frame before on the same channel. Frames follow each other on a
    /// bus, so a large number shows a coarse clock.
    pub simultaneous: u64,
    /// The channel of the last frame.
    last_channel: ChannelId,
}

/// Frames by kind: every frame is counted once.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct FrameCounts {
    /// Classical data frames of 11 bits.
    pub standard: u64,
    /// Classical data frames of 29 bits.
    pub extended: u64,
    /// Remote frames.
    pub remote: u64,
    /// Error frames.
    pub error: u64,
    /// CAN FD frames.
    pub fd: u64,
    /// CAN XL frames.
    pub xl: u64,
}

/// Damages by kind.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct DamageCounts {
    /// Lines, packets or messages that break the rules of their format.
    pub malformed: u64,
    /// Lines, packets or messages that end early or were cut.
    pub truncated: u64,
    /// Lines, packets or messages of an unsupported kind.
    pub unsupported: u64,
    /// Frames that the recorder reports as lost.
    pub dropped: u64,
    /// Files without their proper end.
    pub unfinished: u64,
    /// Files whose rest can't be read.
    pub unreadable: u64,
}

impl Quality {
    /// Counts the next record of the source.
    #[inline]
    pub fn record(&mut self, record: &Record) {
        let time = record.timestamp;
        self.frames.count(&record.frame);
        let channel = usize::from(record.channel.0);
        match self.channels.get_mut(channel) {
            Some(frames) => *frames += 1,
            None => self.add_channel(record.channel),
        }
        self.resolution.see(time);
        self.simultaneous += u64::from(self.last == Some(time) && self.last_channel == record.channel);
        self.last_channel = record.channel;
        match self.last.replace(time) {
            Some(last) if time >= last => self.gaps.interval(last, time, record.place),
            Some(last) => self.steps.step(last, time, record.place),
            None => self.first = Some(time),
        }
    }

    #[cold]
    fn add_channel(&mut self, channel: ChannelId) {
        self.channels.resize(usize::from(channel.0), 0);
        self.channels.push(1);
    }

    /// Counts a damage.
    pub fn damage(&mut self, damage: &Damage) {
        self.damages.count(damage.kind);
    }

    /// Time from the first frame to the last one; zero if the clock stepped back before its start.
    pub fn duration(&self) -> Duration {
        match (self.first, self.last) {
            (Some(first), Some(last)) => last.since(first),
            _ => Duration::ZERO,
        }
    }

    /// Adds the counts of another source. The largest step and gap are the largest of both sources.
    pub fn add(&mut self, other: &Self) {
        self.frames.add(other.frames);
        if self.channels.len() < other.channels.len() {
            self.channels.resize(other.channels.len(), 0);
        }
        for (sum, frames) in self.channels.iter_mut().zip(&other.channels) {
            *sum += frames;
        }
        self.damages.add(other.damages);
        self.first = self.first.into_iter().chain(other.first).min();
        self.last = self.last.max(other.last);
        self.steps.add(&other.steps);
        self.resolution.add(other.resolution);
        self.gaps.add(&other.gaps);
        self.simultaneous += other.simultaneous;
    }
}

impl FrameCounts {
    /// The kinds with their names and counts.
    pub fn by_kind(&self) -> [(&'static str, u64); 6] {
        let Self { standard, extended, remote, error, fd, xl } = *self;
        [("standard", standard), ("extended", extended), ("remote", remote), ("error", error), ("fd", fd), ("xl", xl)]
    }

    /// The number of all frames.
    pub fn total(&self) -> u64 {
        self.by_kind().iter().map(|(_, count)| count).sum()
    }

    #[inline]
    fn count(&mut self, frame: &Frame) {
        let kind = match () {
            () if frame.is_error() => &mut self.error,
            () if frame.is_remote() => &mut self.remote,
            () if frame.is_fd() => &mut self.fd,
            () if frame.is_xl() => &mut self.xl,
            () if frame.id().is_extended() => &mut self.extended,
            () => &mut self.standard,
        };
        *kind += 1;
    }

    fn add(&mut self, other: Self) {
        self.standard += other.standard;
        self.extended += other.extended;
        self.remote += other.remote;
        self.error += other.error;
        self.fd += other.fd;
        self.xl += other.xl;
    }
}

impl DamageCounts {
    /// The kinds with their names and counts.
    pub fn by_kind(&self) -> [(&'static str, u64); 6] {
        let Self { malformed, truncated, unsupported, dropped, unfinished, unreadable } = *self;
        [
            ("malformed", malformed),
            ("truncated", truncated),
            ("unsupported", unsupported),
            ("dropped", dropped),
            ("unfinished", unfinished),
            ("unreadable", unreadable),
        ]
    }

    /// Whether everything could be read and the recorder lost no frame.
    pub fn is_empty(&self) -> bool {
        self.by_kind().iter().all(|(_, count)| *count == 0)
    }

    fn count(&mut self, kind: DamageKind) {
        match kind {
            DamageKind::Malformed => self.malformed += 1,
            DamageKind::Truncated => self.truncated += 1,
            DamageKind::Unsupported => self.unsupported += 1,
            // The number comes from the file, so it may be huge.
            DamageKind::Dropped(frames) => self.dropped = self.dropped.saturating_add(frames),
            DamageKind::Unfinished => self.unfinished += 1,
            DamageKind::Fatal => self.unreadable += 1,
        }
    }

    fn add(&mut self, other: Self) {
        self.malformed += other.malformed;
        self.truncated += other.truncated;
        self.unsupported += other.unsupported;
        self.dropped = self.dropped.saturating_add(other.dropped);
        self.unfinished += other.unfinished;
        self.unreadable += other.unreadable;
    }
}

/// The time and place of an observation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sighting {
    /// The time of the observed frame.
    pub time: Timestamp,
    /// The place of the frame in its source.
    pub place: Place,
}

#[cfg(test)]
mod tests;
