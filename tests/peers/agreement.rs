//! Comparing what was exchanged, and what peers are known to get wrong.

use crate::kept::{Kept, kept};
use crate::recording::{FRAMES, Seen, recording};
use canvass_traces::Frame;
use std::path::{Path, PathBuf};

/// What a peer gets wrong. Such frames are not exchanged with it; that it still gets them wrong is asserted, so that
/// the lists of defects stay true.
pub struct Defect {
    /// What happens to the frames.
    pub what: &'static str,
    /// Which frames those are.
    pub concerns: fn(&Frame) -> bool,
}

/// A way of frames from canvass to a peer, or from a peer to canvass.
pub struct Way<'a> {
    /// For messages.
    pub name: &'a str,
    /// What is not sent, since the peer could not hold it.
    pub before: &'a [Kept],
    /// What can't arrive, since the format or the peer has no place for it.
    pub losses: &'a [Kept],
    /// What the peer gets wrong.
    pub defects: &'a [Defect],
}

impl Way<'_> {
    /// Sends the recording on its way: `exchange` gives the lines of what arrives, or why nothing does.
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
