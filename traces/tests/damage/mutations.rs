//! 10 000 random changes of every capture: reading always ends, without a panic, and with no more frames than the bytes
//! can hold.

use crate::corpus::{Sample, Xorshift, each, read, samples};
use canvass_traces::{Format, ReadOptions, Source};

const MUTATIONS: u64 = 10_000;
/// Maximum memory for reading a small capture: a container or chunk that states 32 MiB, twice while the buffer grows,
/// and the window of zstd.
const MOST_BYTES: u64 = 160 << 20;

/// Values that often cause errors in lengths and counts.
const ODD: [u32; 8] = [0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF];

/// Changes bytes in one of the ways in which files are damaged; returns the number of additional frames that this may
/// make.
fn mutate(bytes: &mut Vec<u8>, random: &mut Xorshift) -> usize {
    let at = random.below(bytes.len());
    let length = random.below(64).min(bytes.len() - at);
    match random.below(7) {
        0 => bytes[at] = random.next() as u8,
        1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes.insert(at, random.next() as u8),
        3 => drop(bytes.drain(at..at + length)),
        4 => bytes.truncate(at + 1),
        5 => {
            let odd = ODD[random.below(ODD.len())].to_le_bytes();
            for (place, byte) in bytes[at..].iter_mut().zip(odd) {
                *place = byte;
            }
        }
        _ => {
            let twice = bytes[at..at + length].to_vec();
            bytes.splice(at..at, twice);
            return length / 4 + 1;
        }
    }
    1
}

fn survive(sample: &Sample) -> Vec<()> {
    let mut random = Xorshift(0x9E37_79B9_7F4A_7C15);
    for n in 0..MUTATIONS {
        let mut bytes = sample.bytes.clone();
        let mut more = 4;
        for _ in 0..=random.below(4) {
            if !bytes.is_empty() {
                more += mutate(&mut bytes, &mut random);
            }
        }
        // Some captures are also read as their original format, even if it is no longer recognised.
        let mut counts = None;
        let taken = allocation_counter::measure(|| {
            counts = match n % 8 {
                0 => Some(read_as(sample.format, &bytes)),
                _ => read(&bytes).map(|(frames, damages)| (frames.len(), damages.len())),
            };
        });
        assert!(taken.bytes_max < MOST_BYTES, "{} mutation {n}: {} bytes", sample.name, taken.bytes_max);
        let Some((frames, damages)) = counts else { continue };
        if !sample.compressed {
            assert!(frames <= sample.frames.len() + more, "{} mutation {n}: {frames} frames", sample.name);
            assert!(damages <= bytes.len() + 1, "{} mutation {n}: {damages} damages", sample.name);
        }
    }
    Vec::new()
}

fn read_as(format: Format, bytes: &[u8]) -> (usize, usize) {
    let reader = format.open(Source::from_bytes(bytes), &ReadOptions::default());
    reader.fold((0, 0), |(frames, damages), item| match item {
        Ok(_) => (frames + 1, damages),
        Err(_) => (frames, damages + 1),
    })
}

#[test]
fn captures_of_every_format_are_survived() {
    each(&samples(|_| true), survive);
}
