//! The frames that the page shows: all frames of a small capture, otherwise the frames around findings and the first
//! and last frames.

use canvass_analyzer::findings::{Exhibit, Observed, Reported};
use canvass_analyzer::{Meaning, NodeId, Service};
use canvass_traces::{ChannelId, Frame, Place, Record, Timestamp};
use std::collections::{BTreeMap, HashMap, VecDeque};
use std::fmt::Write as _;

/// Maximum number of frames of a capture that is shown whole.
const WHOLE: usize = 3_000;
/// Number of frames shown from the start of a longer capture.
const OPENING: usize = 40;
/// Number of frames shown before the frame of a finding.
const BEFORE: u64 = 40;
/// Number of frames shown after the frame of a finding.
const BEHIND: u64 = 20;
/// Maximum number of frames around findings.
const MOST: usize = 30_000;
/// Maximum number of places of findings of one rule.
const MOST_OF_RULE: u32 = 30;
/// Maximum number of shown bytes of a payload.
const BYTES: usize = 64;
/// Maximum number of shown characters of the meaning of a frame.
const CHARACTERS: usize = 400;

/// Collects the frames to show, in bounded memory.
#[derive(Default)]
pub(crate) struct Excerpt {
    seen: u64,
    /// The latest frames.
    ring: VecDeque<Shown>,
    opening: Vec<Shown>,
    /// The kept frames by their number, each with the number of places that need it.
    kept: BTreeMap<u64, (Shown, u32)>,
    places: HashMap<Key, Spot>,
    by_rule: HashMap<&'static str, u32>,
    /// The frame numbers after which places are complete, in the order of time. An entry is out of date if its place
    /// has moved since.
    due: VecDeque<(u64, Key)>,
}

/// The place of a finding: its first occurrence or its worst one.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    finding: usize,
    first: bool,
}

/// The frame of a place, and the range of frames that are already kept for it.
#[derive(Clone, Copy, Default)]
struct Spot {
    at: u64,
    kept: Option<(u64, u64)>,
}

/// A frame as the page shows it.
#[derive(Clone)]
pub struct Shown {
    /// Number of the frame in the capture, from 1; 0 if unknown.
    pub number: u64,
    /// The time of the frame.
    pub time: Timestamp,
    /// The channel of the frame.
    pub channel: ChannelId,
    /// The place of the frame in its file.
    pub place: Place,
    /// The frame, or its head.
    pub frame: Frame,
    /// The beginning of a payload that does not fit into the head.
    pub long: Vec<u8>,
    /// The length of the payload in bytes.
    pub len: usize,
    pub service: Option<Service>,
    /// The node that the frame is about.
    pub node: Option<NodeId>,
    /// The meaning of the frame.
    pub text: String,
}

impl Shown {
    fn set(&mut self, number: u64, record: &Record, observed: &Observed<'_>) {
        let data = record.data();
        *self = Self {
            number,
            service: Some(observed.decoded.service),
            node: observed.decoded.node,
            text: std::mem::take(&mut self.text),
            ..Self::of(record)
        };
        self.len = data.len();
        self.text.clear();
        // Writing to a string can't fail.
        let _ = write!(self.text, "{}", Meaning::new(record, observed.decoded, observed.bus));
        self.shorten();
    }

    fn of(record: &Record) -> Self {
        let data = record.data();
        let long = if data.len() > 8 { data.iter().take(BYTES).copied().collect() } else { Vec::new() };
        Self {
            number: 0,
            time: record.timestamp,
            channel: record.channel,
            place: record.place,
            frame: record.frame,
            long,
            len: data.len(),
            service: None,
            node: None,
            text: String::new(),
        }
    }

    fn shorten(&mut self) {
        // A text never has more characters than bytes, so the slow count is rarely needed.
        if self.text.len() > CHARACTERS
            && let Some((at, _)) = self.text.char_indices().nth(CHARACTERS)
        {
            self.text.truncate(at);
            self.text.push('…');
        }
    }

    /// The payload, or the beginning of a long one.
    pub fn data(&self) -> &[u8] {
        if self.len > 8 { &self.long } else { self.frame.data() }
    }

    /// The key by which the frame of an exhibit is recognised.
    fn key(&self) -> FrameKey {
        (self.time, self.channel, self.place.number, self.place.offset)
    }
}

/// The properties that distinguish frames of several captures.
pub(crate) type FrameKey = (Timestamp, ChannelId, u64, u64);

/// The frame of an exhibit, if it has one.
pub(crate) fn key_of(exhibit: &Exhibit) -> Option<FrameKey> {
    let record = exhibit.record.as_ref()?;
    Some((record.timestamp, record.channel, record.place.number, record.place.offset))
}

impl Excerpt {
    /// Number of frames in the capture.
    pub const fn seen(&self) -> u64 {
        self.seen
    }

    /// Takes a frame.
    pub fn frame(&mut self, record: &Record, observed: &Observed<'_>) {
        self.seen += 1;
        let full = self.ring.len() as u64 > BEFORE + BEHIND;
        let mut shown = full.then(|| self.ring.pop_front()).flatten().unwrap_or_else(|| Shown::of(record));
        shown.set(self.seen, record, observed);
        if self.opening.len() < WHOLE {
            self.opening.push(shown.clone());
        }
        self.ring.push_back(shown);
        for reported in observed.reported {
            self.reported(*reported);
        }
        while self.due.front().is_some_and(|(due, _)| *due <= self.seen) {
            if let Some((_, key)) = self.due.pop_front() {
                self.keep(key, false);
            }
        }
    }

    /// Sets a place to the latest frame, which is part of a finding.
    fn reported(&mut self, Reported { finding, rule }: Reported) {
        let key = Key { finding, first: !self.places.contains_key(&Key { finding, first: true }) };
        if !self.places.contains_key(&key) {
            let of_rule = self.by_rule.entry(rule).or_default();
            if *of_rule >= MOST_OF_RULE {
                return;
            }
            *of_rule += 1;
        }
        self.places.entry(key).or_default().at = self.seen;
        self.due.push_back((self.seen + BEHIND, key));
    }

    /// Keeps the frames around a place instead of the frames kept for it before. The call comes when the place is
    /// complete or when the capture ends.
    fn keep(&mut self, key: Key, at_end: bool) {
        let Some(spot) = self.places.get_mut(&key) else { return };
        if !at_end && spot.at + BEHIND > self.seen {
            // The place has moved to a worse occurrence, so that more frames follow.
            return;
        }
        let (first, last) = (spot.at.saturating_sub(BEFORE), spot.at + BEHIND);
        let before = spot.kept.replace((first, last));
        let around = self.ring.iter().filter(|shown| (first..=last).contains(&shown.number));
        for shown in around {
            if let Some((_, uses)) = self.kept.get_mut(&shown.number) {
                *uses += 1;
            } else if self.kept.len() < MOST {
                self.kept.insert(shown.number, (shown.clone(), 1));
            }
        }
        if let Some((first, last)) = before {
            (first..=last).for_each(|number| self.release(number));
        }
    }

    /// Releases a frame from one of its places.
    fn release(&mut self, number: u64) {
        if let Some((_, uses)) = self.kept.get_mut(&number) {
            *uses -= 1;
            if *uses == 0 {
                self.kept.remove(&number);
            }
        }
    }

    /// All frames to show, in their order. Frames of exhibits that are missing are added.
    pub fn finish<'e>(mut self, exhibits: impl Iterator<Item = &'e Exhibit>) -> Vec<Shown> {
        while let Some((_, key)) = self.due.pop_front() {
            self.keep(key, true);
        }
        let opening = if self.seen <= WHOLE as u64 { WHOLE } else { OPENING };
        let mut frames: BTreeMap<u64, Shown> = self.kept.into_iter().map(|(number, kept)| (number, kept.0)).collect();
        let ends = self.opening.into_iter().take(opening).chain(self.ring);
        frames.extend(ends.map(|shown| (shown.number, shown)));
        let mut frames: Vec<Shown> = frames.into_values().collect();
        let mut known: HashMap<FrameKey, ()> = frames.iter().map(|shown| (shown.key(), ())).collect();
        let mut others = Vec::new();
        for exhibit in exhibits {
            let (Some(record), Some(key)) = (&exhibit.record, key_of(exhibit)) else { continue };
            if known.insert(key, ()).is_none() {
                let mut shown = Shown { text: exhibit.text.clone(), ..Shown::of(record) };
                shown.shorten();
                others.push(shown);
            }
        }
        merge(&mut frames, others);
        frames
    }
}

/// Inserts `others` among the frames by their times. The frames keep their order, even if their clock stepped back.
fn merge(frames: &mut Vec<Shown>, mut others: Vec<Shown>) {
    others.sort_by_key(|shown| (shown.time, shown.place.number));
    let mut others = others.into_iter().peekable();
    let mut merged = Vec::with_capacity(frames.len() + others.len());
    for shown in std::mem::take(frames) {
        while let Some(other) = others.next_if(|other| other.time < shown.time) {
            merged.push(other);
        }
        merged.push(shown);
    }
    merged.extend(others);
    *frames = merged;
}

/// The position of each frame in the list.
pub fn places(frames: &[Shown]) -> HashMap<FrameKey, usize> {
    frames.iter().enumerate().map(|(at, shown)| (shown.key(), at)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::findings::{Diagnosis, Results, Thresholds};
    use canvass_traces::parse_frame;

    /// The shown frames of a bus with a heartbeat every millisecond, and the results of the diagnosis.
    fn shown(frames: u64, also: &dyn Fn(u64) -> Option<&'static str>) -> (Vec<Shown>, Results) {
        let (mut diagnosis, mut excerpt) = (Diagnosis::new(Thresholds::default()), Excerpt::default());
        for n in 1..=frames {
            let frame = parse_frame(also(n).unwrap_or("705#05")).unwrap().frame;
            let record = Record::new(Timestamp(n * 1_000_123), ChannelId(0), frame).at(n, n * 30);
            let observed = diagnosis.record(&record).unwrap();
            excerpt.frame(&record, &observed);
        }
        let results = diagnosis.finish(&[]);
        let frames = excerpt.finish(results.findings.iter().flat_map(|finding| &finding.evidence));
        (frames, results)
    }

    fn has(frames: &[Shown], numbers: std::ops::RangeInclusive<u64>) -> bool {
        numbers.into_iter().all(|number| frames.iter().any(|shown| shown.number == number))
    }

    #[test]
    fn a_small_capture_is_shown_whole() {
        let (frames, _) = shown(WHOLE as u64, &|_| None);
        assert_eq!(frames.len(), WHOLE);
        assert_eq!(frames[7].text, "heartbeat: operational");
    }

    #[test]
    fn of_a_large_one_the_frames_around_findings() {
        let at = |n| match n {
            50_000 => Some("085#1081110000000000"),
            50_500 => Some("085#0000000000000000"),
            _ => None,
        };
        let (frames, results) = shown(100_000, &at);
        assert!(results.findings.iter().any(|finding| finding.rule.id == "emcy/raised"), "{results:?}");
        assert!(frames.len() < 600, "{}", frames.len());
        assert!(has(&frames, 1..=OPENING as u64) && has(&frames, 99_980..=100_000));
        assert!(has(&frames, 50_000 - BEFORE..=50_000 + BEHIND), "first");
        assert!(frames.is_sorted_by_key(|shown| shown.time));
        let places = places(&frames);
        for exhibit in results.findings.iter().flat_map(|finding| &finding.evidence) {
            assert!(key_of(exhibit).is_none_or(|key| places.contains_key(&key)), "{exhibit:?} leads nowhere");
        }
    }

    /// A bus on which everything is wrong all the time.
    #[test]
    fn what_is_kept_is_bounded() {
        let mut state = 1_u64;
        let (mut diagnosis, mut excerpt) = (Diagnosis::new(Thresholds::default()), Excerpt::default());
        for n in 1..=60_000_u64 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let (id, data) = (state >> 53, (state << 11).to_be_bytes());
            let id = canvass_traces::CanId::standard_masked(id as u32);
            let record = Record::new(Timestamp(n * 500_000 + state % 400_000), ChannelId(0), Frame::full(id, data));
            let record = record.at(n, n);
            let observed = diagnosis.record(&record).unwrap();
            excerpt.frame(&record, &observed);
            assert!(excerpt.kept.len() <= MOST && excerpt.ring.len() as u64 <= BEFORE + BEHIND + 1);
            assert!(excerpt.due.len() < 100 * BEHIND as usize);
        }
        let results = diagnosis.finish(&[]);
        assert!(results.findings.len() > 500, "{}", results.findings.len());
        let frames = excerpt.finish(results.findings.iter().flat_map(|finding| &finding.evidence));
        assert!(frames.len() < MOST + results.findings.len() * 8 + 200);
    }
}
