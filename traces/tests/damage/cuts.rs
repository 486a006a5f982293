//! Captures that end at any byte: the frames are the first ones of the whole capture, and each frame that is cut is
//! reported.

use crate::corpus::{Sample, are_first, read, samples};

/// Whether a frame of the whole capture began before the cut and is missing.
fn loses(sample: &Sample, end: usize, read: usize) -> bool {
    if sample.compressed {
        return end > 0;
    }
    let begun = |at: usize| !sample.bytes[at..end].trim_ascii().is_empty();
    sample.frames[read..].iter().any(|frame| (frame.place.offset as usize) < end && begun(frame.place.offset as usize))
}

/// The manual prints a frame with length 4 and six bytes: if it is cut after the fourth byte, the line is right.
const CONTRADICTS_ITSELF: &str = "kuebler-5.7.7.txt";

#[test]
fn a_cut_capture_gives_its_first_frames_and_says_what_is_lost() {
    let mut silent = Vec::new();
    for sample in samples(|sample| sample.name != CONTRADICTS_ITSELF) {
        for end in 0..sample.bytes.len() {
            let name = &sample.name;
            // The format is no longer recognised, which is reported when the capture is opened.
            let Some((frames, damages)) = read(&sample.bytes[..end]) else { continue };
            assert!(are_first(&sample, &frames), "{name} cut at {end}: {frames:#?}");
            if damages.is_empty() && loses(&sample, end, frames.len()) {
                silent.push(format!("{name} cut at {end}: {} frames", frames.len()));
            }
        }
    }
    assert!(silent.is_empty(), "nothing is said of {} cuts:\n{}", silent.len(), silent.join("\n"));
}
