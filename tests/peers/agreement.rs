//! Compares exchanged frames, apart from the known defects of peers.

use crate::kept::{Kept, kept};
use crate::recording::{FRAMES, Seen, recording};
use canvass_traces::Frame;
use std::path::{Path, PathBuf};

/// A defect of a peer. Frames with a defect are not exchanged; a separate exchange asserts that the peer still gets
/// them wrong, so that the lists of defects stay true.
pub struct Defect {
    /// The effect of the defect on the frames.
    pub what: &'static str,
    /// Whether the defect concerns a frame.
    pub concerns: fn(&Frame) -> bool,
}

/// The transfer of frames from canvass to a peer, or from a peer to canvass.
pub struct Way<'a> {
    /// The name in error messages.
    pub name: &'a str,
    /// Changes of the frames before they are sent, since the peer could not hold the originals.
    pub before: &'a [Kept],
    /// Losses in the transfer, since the format or the peer has no place for the data.
    pub losses: &'a [Kept],
    /// The defects of the peer.
    pub defects: &'a [Defect],
}

impl Way<'_> {
    /// Sends the recording to the peer and compares: `exchange` returns the lines of the frames that arrive, or the
    /// reason why none do.
    ///
    /// `exchange` gets a path for the file, without extension, in a folder for this test alone.
    pub fn agrees(&self, exchange: impl Fn(&Path, &[Seen]) -> Result<Vec<String>, String>) {
        let folder = tempfile::tempdir().unwrap();
        let path: PathBuf = folder.path().join("capture");
        let all: Vec<Seen> = recording().iter().map(|seen| kept(seen, self.before)).collect();
        let (wrong, right): (Vec<Seen>, Vec<Seen>) =
            all.into_iter().partition(|seen| self.defects.iter().any(|defect| (defect.concerns)(&seen.record.frame)));
        assert!(right.len() > FRAMES / 2, "{}", self.name);
        let arrived = exchange(&path, &right).unwrap_or_else(|error| panic!("{}: {error}", self.name));
        self.assert_same(&arrived, &self.expected(&right));
        for defect in self.defects {
            let concerned: Vec<Seen> =
                wrong.iter().filter(|seen| (defect.concerns)(&seen.record.frame)).cloned().collect();
            assert!(!concerned.is_empty(), "{}: {}", self.name, defect.what);
            let gone = exchange(&path, &concerned).is_ok_and(|arrived| arrived == self.expected(&concerned));
            assert!(!gone, "{}: strike this defect out, it is gone: {}", self.name, defect.what);
        }
    }

    fn expected(&self, sent: &[Seen]) -> Vec<String> {
        sent.iter().map(|seen| kept(seen, self.losses).to_string()).collect()
    }

    fn assert_same(&self, arrived: &[String], expected: &[String]) {
        for (n, (arrived, expected)) in arrived.iter().zip(expected).enumerate() {
            assert_eq!(arrived, expected, "{}, frame {}", self.name, n + 1);
        }
        assert_eq!(arrived.len(), expected.len(), "{}", self.name);
    }
}
