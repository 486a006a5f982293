//! A capture that ends at any byte: its frames are the first ones of the whole, and what began and is not there is said.

use crate::corpus::{Sample, read, samples};

/// Whether something that became a frame had begun before the cut and did not come out.
fn loses(sample: &Sample, end: usize, read: usize) -> bool {
    if sample.compressed {
        return end > 0;
    }
    let begun = |at: usize| !sample.bytes[at..end].trim_ascii().is_empty();
    sample.frames[read..].iter().any(|frame| (frame.place.offset as usize) < end && begun(frame.place.offset as usize))
}

/// The manual prints a frame with length 4 and six bytes: cut after the fourth, it is a good one.
const CONTRADICTS_ITSELF: &str = "kuebler-5.7.7.txt";

#[test]
fn a_cut_capture_gives_its_first_frames_and_says_what_is_lost() {
    let mut silent = Vec::new();
    for sample in samples(|sample| sample.name != CONTRADICTS_ITSELF) {
        for end in 0..sample.bytes.len() {
            let name = &sample.name;
            // Of no known format any more: that is said when it is opened.
            let Some((frames, damages)) = read(&sample.bytes[..end]) else { continue };
            assert!(sample.frames.starts_with(&frames), "{name} cut at {end}: {frames:#?}");
            if damages.is_empty() && loses(&sample, end, frames.len()) {
                silent.push(format!("{name} cut at {end}: {} frames", frames.len()));
            }
        }
    }
    assert!(silent.is_empty(), "nothing is said of {} cuts:\n{}", silent.len(), silent.join("\n"));
}
