//! Captures with one damaged byte: each frame that is lost is reported.

use crate::corpus::{Sample, Xorshift, each, read, samples};
use canvass_traces::{Damage, DamageKind, Format};

/// Number of random values that replace each byte, in addition to values that make comments and line ends.
const TRIED: usize = 4;
/// Maximum number of places in a sample at which a byte is damaged, one place at a time. The places are spread over
/// the sample.
const PLACES: usize = 1_200;

/// The number of lost frames that a damage explains: any number if the file ends there, or the damage compares counts or
/// concerns many records.
fn told(damage: &Damage) -> u64 {
    match damage.kind {
        DamageKind::Dropped(frames) => frames,
        DamageKind::Malformed if ["say", "says", "can't be read"].iter().any(|end| damage.expected.ends_with(end)) => {
            u64::MAX
        }
        DamageKind::Malformed | DamageKind::Unsupported => 1,
        DamageKind::Truncated | DamageKind::Unfinished | DamageKind::Fatal => u64::MAX,
    }
}

/// The bytes from the first frame on: damage before it is reported for the whole file.
fn rows(sample: &Sample) -> std::ops::Range<usize> {
    let first = sample.frames.iter().map(|frame| frame.place.offset).min().unwrap_or_default();
    first as usize..sample.bytes.len()
}

/// A damage that no reader can detect: the type of an object in a plain container of BLF, which has no checksum,
/// becomes another known type.
fn becomes_another(sample: &Sample, at: usize) -> bool {
    sample.name == "python-can-plain.blf" && sample.bytes[at - 12..].starts_with(b"LOBJ")
}

/// Whether the damaged byte was a line end: then two lines are joined into one damage.
fn joins(sample: &Sample, at: usize) -> bool {
    let is_binary = matches!(
        sample.format,
        Format::Pcap | Format::Pcapng | Format::Mcap | Format::Blf | Format::Mf4 | Format::Sqlite
    );
    !is_binary && sample.bytes[at] == b'\n'
}

fn account(sample: &Sample) -> Vec<String> {
    let mut random = Xorshift(0x9E37_79B9_7F4A_7C15);
    let mut silent = Vec::new();
    let rows = rows(sample);
    let step = rows.len().div_ceil(PLACES);
    for at in rows.step_by(step).map(|at| (at + random.below(step)).min(sample.bytes.len() - 1)).collect::<Vec<_>>() {
        let others = [b'#', b';', b'\n', b' ', sample.bytes[at] ^ 1 << (at % 8)];
        let values: Vec<u8> = others.into_iter().chain((0..TRIED).map(|_| random.next() as u8)).collect();
        for value in values {
            let mut bytes = sample.bytes.clone();
            bytes[at] = value;
            let Some((frames, damages)) = read(&bytes) else { continue };
            let told =
                damages.iter().fold(u64::from(joins(sample, at)), |sum, damage| sum.saturating_add(told(damage)));
            let lost = sample.frames.len().saturating_sub(frames.len()) as u64;
            if told < lost && !becomes_another(sample, at) {
                let (from, to) = (sample.bytes[at], value);
                silent.push(format!("{}: {from:02X} at {at} to {to:02X}: {lost} lost, {damages:?}", sample.name));
            }
        }
    }
    silent
}

#[test]
fn each_lost_frame_is_told_in_every_format() {
    let silent = each(&samples(|sample| !sample.compressed), account);
    assert!(silent.is_empty(), "{} losses are not told:\n{}", silent.len(), silent.join("\n"));
}
