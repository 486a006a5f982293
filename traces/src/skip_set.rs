//! Frames that the reader of a capture does not need.

use crate::{ChannelId, Frame, FrameKind, Record, Timestamp};

/// Frames of a capture to skip, by channel and CAN-ID: [`crate::Merge::next_kept`] skips them, if possible before
/// it parses them.
///
/// The set contains only classical data frames without a comment, and no damages. It may change with each frame.
///
/// ```
/// use canvass_traces::{Capture, ChannelId, Merge, Naming, ReadOptions, SkipSet, Source};
///
/// let log = "(1.000000) can0 185#01\n(2.000000) can0 185#02\n(3.000000) can0 705#05\n";
/// let capture = Capture::from_source("a.log", Source::from_bytes(log), &ReadOptions::default())?;
/// let (mut merge, mut skip) = (Merge::new(vec![capture], Naming::BySource), SkipSet::default());
/// let mut record = merge.next().unwrap().1?;
/// assert_eq!(record.frame.to_string(), "185#01");
/// skip.all(ChannelId(0), 0x185);
/// merge.next_kept(&mut skip, &mut record).unwrap().1?;
/// assert_eq!(record.frame.to_string(), "705#05");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct SkipSet {
    channels: Vec<Option<Box<Skipped>>>,
    /// Number of skipped CAN-IDs.
    len: usize,
    /// Number of frames skipped since the last [`SkipSet::take`]; and the time of the last one, if no kept frame
    /// followed.
    skipped: (usize, Option<Timestamp>),
}

/// The skipped CAN-IDs of a channel.
struct Skipped {
    standard: [Which; 2048],
    extended: Which,
}

/// The skipped frames of a CAN-ID.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Which {
    None,
    /// Frames of one byte with this value.
    Byte(u8),
    All,
}

impl Which {
    /// Whether any frame is skipped.
    #[inline]
    pub(crate) fn may_have(self) -> bool {
        self != Self::None
    }

    /// Whether a classical data frame of `len` bytes is skipped; `data` is called only if the bytes matter.
    #[inline]
    pub(crate) fn has(self, data: impl FnOnce() -> [u8; 8], len: usize) -> bool {
        match self {
            Self::None => false,
            Self::Byte(byte) => len == 1 && data()[0] == byte,
            Self::All => true,
        }
    }
}

impl SkipSet {
    /// Number of channels on which frames can be skipped.
    const CHANNELS: usize = 64;
    /// Maximum number of frames skipped in a row. The next frame is returned even if the set has it, so that the caller
    /// gets control.
    pub(crate) const IN_A_ROW: usize = 1 << 16;

    /// Skips all frames with an 11-bit CAN-ID.
    pub fn all(&mut self, channel: ChannelId, can_id: u16) {
        self.set(channel, can_id, Which::All);
    }

    /// Skips the frames of one byte with this value and CAN-ID (11 bits).
    pub fn byte(&mut self, channel: ChannelId, can_id: u16, byte: u8) {
        self.set(channel, can_id, Which::Byte(byte));
    }

    /// Skips no frame with an 11-bit CAN-ID.
    #[inline]
    pub fn none(&mut self, channel: ChannelId, can_id: u16) {
        if self.of(channel, crate::CanId::standard_masked(can_id.into())) != Which::None {
            self.set(channel, can_id, Which::None);
        }
    }

    /// Skips all frames with 29-bit CAN-IDs.
    pub fn extended(&mut self, channel: ChannelId) {
        if let Some(skipped) = self.channel_mut(channel)
            && std::mem::replace(&mut skipped.extended, Which::All) == Which::None
        {
            self.len += 1;
        }
    }

    /// Stops skipping on a channel.
    pub fn forget(&mut self, channel: ChannelId) {
        if let Some(skipped) = self.channels.get_mut(usize::from(channel.0)).and_then(Option::take) {
            let all = skipped.standard.iter().chain([&skipped.extended]);
            self.len -= all.filter(|which| **which != Which::None).count();
        }
    }

    /// Whether the set is empty.
    #[inline]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Takes the number of frames skipped since the last call; and the time of the last one, if no kept frame followed.
    #[inline]
    pub fn take(&mut self) -> (usize, Option<Timestamp>) {
        std::mem::take(&mut self.skipped)
    }

    /// Whether the record is skipped; if so, counts it.
    #[inline]
    pub fn skips(&mut self, record: &Record) -> bool {
        let skips = !self.is_empty() && record.comment().is_none() && self.has(record.channel, &record.frame);
        if skips {
            self.skipped_at(Some(record.timestamp), 1);
        }
        skips
    }

    /// Counts skipped frames; `time` is the time of the last one, if no kept frame followed.
    #[inline]
    pub(crate) const fn skipped_at(&mut self, time: Option<Timestamp>, frames: usize) {
        self.skipped = (self.skipped.0 + frames, time);
    }

    #[inline]
    fn has(&self, channel: ChannelId, frame: &Frame) -> bool {
        let is_classical_data = frame.kind() == FrameKind::Data && !frame.is_fd() && !frame.is_xl();
        is_classical_data && self.of(channel, frame.id()).has(|| frame.bytes(), frame.len())
    }

    /// The frames with this CAN-ID that are skipped.
    #[inline]
    pub(crate) fn of(&self, channel: ChannelId, id: crate::CanId) -> Which {
        let Some(Some(skipped)) = self.channels.get(usize::from(channel.0)) else { return Which::None };
        match id.as_standard() {
            Some(id) => skipped.standard.get(usize::from(id)).copied().unwrap_or(Which::None),
            None => skipped.extended,
        }
    }

    fn set(&mut self, channel: ChannelId, can_id: u16, which: Which) {
        let Some(place) = self.channel_mut(channel).and_then(|skipped| skipped.standard.get_mut(usize::from(can_id)))
        else {
            return;
        };
        let before = std::mem::replace(place, which);
        self.len += usize::from(which != Which::None);
        self.len -= usize::from(before != Which::None);
    }

    fn channel_mut(&mut self, channel: ChannelId) -> Option<&mut Skipped> {
        let at = usize::from(channel.0);
        if at >= Self::CHANNELS {
            return None;
        }
        if self.channels.len() <= at {
            self.channels.resize_with(at + 1, || None);
        }
        let none = || Box::new(Skipped { standard: [Which::None; 2048], extended: Which::None });
        Some(self.channels.get_mut(at)?.get_or_insert_with(none))
    }
}

impl std::fmt::Debug for SkipSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SkipSet({} CAN-IDs)", self.len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CanId, Capture, Flags, Merge, Naming, ReadOptions, Source};

    fn record(frame: Frame) -> Record {
        Record::new(Timestamp(7), ChannelId(0), frame)
    }

    #[test]
    fn only_classical_data_frames_without_a_comment() {
        let (id, wide) = (CanId::standard_masked(0x185), CanId::extended_masked(0x185));
        let mut skip = SkipSet::default();
        skip.all(ChannelId(0), 0x185);
        assert!(skip.skips(&record(Frame::new(id, &[1, 2]).unwrap())));
        assert_eq!((skip.take(), skip.take()), ((1, Some(Timestamp(7))), (0, None)));
        for other in [Frame::remote(id, 1).unwrap(), Frame::fd(id, Flags::NONE, &[1]).unwrap()] {
            assert!(!skip.skips(&record(other)));
        }
        assert!(!skip.skips(&record(Frame::new(id, &[]).unwrap()).with_comment("case")));
        assert!(!skip.skips(&record(Frame::new(wide, &[]).unwrap())));
        assert!(!skip.skips(&Record::new(Timestamp(7), ChannelId(1), Frame::new(id, &[]).unwrap())));
        skip.extended(ChannelId(0));
        assert!(skip.skips(&record(Frame::new(wide, &[]).unwrap())));
        skip.none(ChannelId(0), 0x185);
        assert!(!skip.skips(&record(Frame::new(id, &[1, 2]).unwrap())) && !skip.is_empty());
        skip.forget(ChannelId(0));
        assert!(skip.is_empty());
    }

    #[test]
    fn one_byte() {
        let id = CanId::standard_masked(0x705);
        let mut skip = SkipSet::default();
        skip.byte(ChannelId(0), 0x705, 5);
        let skipped = [&[5][..], &[], &[4], &[5, 5]].map(|data| skip.skips(&record(Frame::new(id, data).unwrap())));
        assert_eq!(skipped, [true, false, false, false]);
        skip.all(ChannelId(9999), 0x705);
        assert_eq!(skip.len, 1, "of so many channels none is kept");
    }

    /// For any log, skipping frames keeps the other records and their line numbers.
    #[test]
    fn a_log_without_some_frames_is_the_log_without_their_lines() {
        let mut log = String::new();
        for n in 0..2_000_u32 {
            let name = ["can0", "can1", " can0"][n as usize % 3];
            let id = [0x185, 0x705, 0x585, 0x80][(n / 3) as usize % 4];
            log += &match n % 97 {
                5 => "# canvass: a comment\n".to_owned(),
                11 => "no frame\n".to_owned(),
                17 => format!("({n}.000000) {name} {id:03X}#1\n"),
                23 => format!("({n}.000000) {name} {id:03X}#R\n"),
                31 => format!("(17000{n:05}.000000) {name} 00000{id:03X}#11 R\r\n"),
                _ => format!("(17000{n:05}.000000) {name} {id:03X}#{:02X}\n", n % 2 + 4),
            };
        }
        let open = || {
            let source = Source::from_bytes(log.clone());
            let capture = Capture::from_source("a.log", source, &ReadOptions::default()).unwrap();
            Merge::new(vec![capture], Naming::BySource)
        };
        let shown = |item: &Result<Record, crate::Damage>| format!("{item:?}");
        let mut without = SkipSet::default();
        without.all(ChannelId(0), 0x185);
        without.byte(ChannelId(0), 0x705, 5);
        without.extended(ChannelId(1));
        let all = open().map(|item| item.1).collect::<Vec<_>>();
        let expected: Vec<String> =
            all.iter().filter(|item| !matches!(item, Ok(record) if without.skips(record))).map(shown).collect();
        let (mut merge, mut kept) = (open(), Vec::new());
        let mut next = record(Frame::full(CanId::standard_masked(0), [0; 8]));
        while let Some((_, item)) = merge.next_kept(&mut without, &mut next) {
            kept.push(shown(&item.map(|()| next.clone())));
        }
        assert!(kept.len() < all.len() * 3 / 4);
        assert_eq!(kept, expected);
    }
}
