//! The quality of captures, as text and as JSON ([`QualityResult`], described in `docs/quality.md`).

use crate::escape::printable;
use crate::results::quality::{Channel, Gap, Place, QualityResult, Source, Steps};
use crate::results::{self, Contract};
use canvass_traces::quality::{Gaps, Sighting};
use canvass_traces::{Capture, ChannelId, Channels, Format, Quality, Reader, TimeBase};
use std::fmt::Write;

/// One capture with its quality.
#[derive(Clone, Copy, Debug)]
pub struct CaptureQuality<'a> {
    /// The file's name.
    pub name: &'a str,
    pub format: Format,
    /// The origin of the capture's times.
    pub time_base: TimeBase,
    /// The quality of the capture.
    pub quality: &'a Quality,
}

impl<'a> CaptureQuality<'a> {
    /// The quality of a capture that was read.
    pub fn new(capture: &'a Capture, quality: &'a Quality) -> Self {
        Self { name: capture.name(), format: capture.format(), time_base: capture.time_base(), quality }
    }
}

/// The quality of all captures together.
fn total(captures: &[CaptureQuality<'_>]) -> Quality {
    captures.iter().fold(Quality::default(), |mut total, capture| {
        total.add(capture.quality);
        total
    })
}

/// The quality of each capture, and the total if there are several. `channels` names the channels of all captures.
pub fn text(captures: &[CaptureQuality<'_>], channels: &Channels) -> String {
    let mut text = String::from("capture quality\n");
    for capture in captures {
        let name = printable(capture.name);
        // Writing to a string can't fail.
        let _ = writeln!(text, "{name} ({})", capture.format);
        push_quality(&mut text, Some(&name), capture.quality, channels);
    }
    if captures.len() > 1 {
        let _ = writeln!(text, "all {} captures", captures.len());
        push_quality(&mut text, None, &total(captures), channels);
    }
    text
}

fn push_quality(text: &mut String, name: Option<&str>, quality: &Quality, channels: &Channels) {
    let mut row = |label: &str, value: String| {
        let _ = writeln!(text, "  {label:<11}{value}");
    };
    row("frames", frames(quality));
    let by_channel = by_channel(quality, channels).map(|(name, frames)| format!("{} {frames}", printable(name)));
    match by_channel.collect::<Vec<_>>() {
        none if none.is_empty() => {}
        some => row("channels", some.join(", ")),
    }
    if let (Some(first), Some(last)) = (quality.first, quality.last) {
        let resolution = quality.resolution.get().map(|unit| format!(", resolution {unit}")).unwrap_or_default();
        row("time", format!("{first} to {last}, {}{resolution}", quality.duration()));
    }
    row("damage", damages(quality));
    row("clock", clock(quality, name));
    row("gaps", gaps(&quality.gaps, name));
    for warning in warnings(quality) {
        row("warning", warning);
    }
}

/// The number of frames by kind: `5000: 4000 standard, 1000 error`.
fn frames(quality: &Quality) -> String {
    let kinds: Vec<String> = counted(&quality.frames.by_kind()).collect();
    let colon = if kinds.is_empty() { "" } else { ": " };
    format!("{}{colon}{}", quality.frames.total(), kinds.join(", "))
}

fn counted<'a>(counts: &'a [(&'static str, u64)]) -> impl Iterator<Item = String> + 'a {
    counts.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{count} {name}"))
}

fn damages(quality: &Quality) -> String {
    if quality.damages.is_empty() {
        return "none".to_owned();
    }
    let shown: Vec<String> = counted(&quality.damages.by_kind()).collect();
    shown.join(", ")
}

fn clock(quality: &Quality, name: Option<&str>) -> String {
    match quality.steps.first {
        None => "no steps back".to_owned(),
        Some(first) => {
            let count = quality.steps.count;
            let steps = if count == 1 { "step" } else { "steps" };
            format!("{count} {steps} back, the largest {}, the first at {}", quality.steps.largest, place(name, first))
        }
    }
}

fn gaps(gaps: &Gaps, name: Option<&str>) -> String {
    match gaps.largest {
        None => "none".to_owned(),
        Some(gap) => {
            let end = place(name, gap.end);
            format!("{}, the largest {} until {end}, where at most {} was usual", gaps.count, gap.length, gap.usual)
        }
    }
}

/// The place of a damage: its line or offset in the file, or its time if the file is not known.
fn place(name: Option<&str>, at: Sighting) -> String {
    match name {
        Some(name) => format!("{name}:{}", at.place.number),
        None => at.time.to_string(),
    }
}

/// The warnings about a capture.
pub fn warnings(quality: &Quality) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(resolution) = quality.resolution.get()
        && quality.resolution.is_coarse()
    {
        warnings.push(format!("times are no finer than {resolution}: the order and delays of frames are not certain"));
    }
    if quality.damages.dropped > 0 {
        warnings.push(format!("the recorder lost {} frames", quality.damages.dropped));
    }
    if quality.damages.unfinished > 0 {
        warnings.push("the recording has no proper end: the last frames may be missing".to_owned());
    }
    if quality.steps.count > 0 {
        warnings.push("the clock stepped back: times before and after can't be compared".to_owned());
    }
    warnings
}

/// The quality of the captures as a JSON result.
pub fn json(captures: &[CaptureQuality<'_>], channels: &Channels) -> QualityResult {
    let source = |capture: &CaptureQuality<'_>| Source {
        format: capture.format.id().into(),
        name: capture.name.to_owned(),
        time_base: time_base(capture.time_base).into(),
        quality: figures(capture.quality, channels),
    };
    QualityResult {
        schema: QualityResult::SCHEMA.into(),
        sources: captures.iter().map(source).collect(),
        total: figures(&total(captures), channels),
    }
}

fn figures(quality: &Quality, channels: &Channels) -> results::quality::Quality {
    let by_kind = |counts: &[(&'static str, u64)]| counts.iter().map(|&(name, count)| (name.into(), count)).collect();
    let channel = |(name, frames): (&str, u64)| Channel { frames, name: name.to_owned() };
    let gap = |gap: canvass_traces::quality::Gap| Gap {
        end: seen(gap.end),
        length_ns: gap.length.nanos(),
        usual_ns: gap.usual.nanos(),
    };
    results::quality::Quality {
        channels: by_channel(quality, channels).map(channel).collect(),
        clock_steps_back: Steps {
            count: quality.steps.count,
            first: quality.steps.first.map(seen),
            largest_ns: quality.steps.largest.nanos(),
        },
        damages: by_kind(&quality.damages.by_kind()),
        duration_ns: quality.duration().nanos(),
        first_t: quality.first.map(|time| time.nanos()),
        frames: quality.frames.total(),
        gaps: results::quality::Gaps { count: quality.gaps.count, largest: quality.gaps.largest.map(gap) },
        kinds: by_kind(&quality.frames.by_kind()),
        last_t: quality.last.map(|time| time.nanos()),
        resolution_ns: quality.resolution.get().map(|unit| unit.nanos()),
        warnings: warnings(quality),
    }
}

fn seen(at: Sighting) -> Place {
    Place { number: at.place.number, offset: at.place.offset, t: at.time.nanos() }
}

/// The JSON name of a time base.
pub const fn time_base(base: TimeBase) -> &'static str {
    match base {
        TimeBase::Utc => "utc",
        TimeBase::Local => "local",
        TimeBase::Start => "start",
        TimeBase::None => "none",
    }
}

/// The channels with frames, and the number of frames.
fn by_channel<'a>(quality: &'a Quality, channels: &'a Channels) -> impl Iterator<Item = (&'a str, u64)> {
    let named = quality.channels.iter().enumerate();
    named.filter(|(_, frames)| **frames > 0).map(|(id, frames)| (channels.name(ChannelId(id as u16)), *frames))
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{CanId, Damage, DamageKind, Frame, Record, Timestamp};
    use serde_json::json as value_of;

    const SECOND: u64 = 1_000_000_000;

    fn seen(channels: &mut Channels) -> Quality {
        let mut quality = Quality::default();
        let frame = Frame::full(CanId::standard_masked(0x181), [0; 8]);
        for (n, (channel, time)) in [("can0", 1), ("can\x1b[31m", 2), ("can0", 30), ("can0", 29)].iter().enumerate() {
            let record = Record::new(Timestamp(time * SECOND), channels.intern(channel), frame);
            quality.record(&record.at(n as u64 + 1, 100));
        }
        quality.damage(&Damage::new(DamageKind::Dropped(7), canvass_traces::Place::default(), "", b""));
        quality
    }

    #[test]
    fn as_text() {
        let mut channels = Channels::new();
        let quality = seen(&mut channels);
        let capture =
            CaptureQuality { name: "a.log", format: Format::Candump, time_base: TimeBase::Start, quality: &quality };
        assert_eq!(
            text(&[capture], &channels),
            "capture quality\n\
             a.log (candump)\n\
             \x20 frames     4: 4 standard\n\
             \x20 channels   can0 3, can\\x1B[31m 1\n\
             \x20 time       1.000000000 to 29.000000000, 28 s, resolution 1 s\n\
             \x20 damage     7 dropped\n\
             \x20 clock      1 step back, the largest 1 s, the first at a.log:4\n\
             \x20 gaps       1, the largest 28 s until a.log:3, where at most 998.046 ms was usual\n\
             \x20 warning    times are no finer than 1 s: the order and delays of frames are not certain\n\
             \x20 warning    the recorder lost 7 frames\n\
             \x20 warning    the clock stepped back: times before and after can't be compared\n"
        );
        assert!(text(&[capture, capture], &channels).contains("all 2 captures\n  frames     8: 8 standard\n"));
    }

    #[test]
    fn as_json() {
        let mut channels = Channels::new();
        let quality = seen(&mut channels);
        let capture =
            CaptureQuality { name: "a.log", format: Format::Candump, time_base: TimeBase::Start, quality: &quality };
        let value = value_of!(json(&[capture, capture], &channels));
        assert_eq!(value["schema"], "canvass/quality/1");
        let source = &value["sources"][1];
        assert_eq!(
            (&source["name"], &source["format"], &source["time_base"]),
            (&value_of!("a.log"), &value_of!("candump"), &value_of!("start"))
        );
        assert_eq!(source["channels"][1], value_of!({ "name": "can\u{1b}[31m", "frames": 1 }));
        assert_eq!(source["first_t"], SECOND);
        assert_eq!(source["clock_steps_back"]["first"], value_of!({ "t": 29 * SECOND, "number": 4, "offset": 100 }));
        assert_eq!(source["gaps"]["largest"]["length_ns"], 28 * SECOND);
        assert_eq!(value["total"]["frames"], 8);
        assert_eq!(value["total"]["damages"]["dropped"], 14);
    }

    #[test]
    fn nothing_seen() {
        let quality = Quality::default();
        let capture = CaptureQuality { name: "-", format: Format::Mcap, time_base: TimeBase::Utc, quality: &quality };
        let total = json(&[capture], &Channels::new()).total;
        assert_eq!((total.first_t, total.resolution_ns), (None, None));
        assert!(text(&[capture], &Channels::new()).contains("  frames     0\n  damage     none\n"));
    }
}
