//! The two frames of each SRDO, and which CAN-IDs of 101h to 180h carry SRDOs where no parameters tell.

use crate::NodeId;
use crate::wire::srdo::{Fit, Half, Pair, Srdo, is_inverse};
use canvass_traces::{Duration, Frame, Timestamp};
use std::collections::BTreeMap;

/// The SRDO pairs of a bus. A pair is one only when the inverted data were seen after the data; until then its
/// frames are of no known use.
#[derive(Clone, Default)]
pub struct SrdoPairs {
    /// By [`Pair::position`]; not made before the first frame.
    pairs: Vec<PairState>,
    /// Those whose parameters are known, by node and number.
    configured: BTreeMap<(NodeId, u8), PairState>,
}

#[derive(Clone, Copy, Default)]
struct PairState {
    /// It was seen to be a pair.
    known: bool,
    /// The data whose inverse is due.
    normal: Option<(Timestamp, Frame)>,
}

/// The longest time that may lie between the two frames (safety-relevant object validation time, one byte of
/// milliseconds).
const VALIDATION_TIME: Duration = Duration(255_000_000);

impl SrdoPairs {
    /// Takes a frame; `None` where it is not known to be of an SRDO.
    pub fn handle(&mut self, now: Timestamp, can_id: u16, frame: &Frame) -> Option<(Pair, Srdo)> {
        let (pair, half) = Pair::of(can_id)?;
        if self.pairs.is_empty() {
            self.pairs.resize(64, PairState::default());
        }
        let state = self.pairs.get_mut(pair.position())?;
        let fit = state.take(now, half, frame);
        state.known |= fit == Fit::Inverse;
        state.known.then_some((pair, Srdo { number: None, half, fit }))
    }

    /// Takes a frame of an SRDO whose parameters are known.
    pub fn configured(&mut self, now: Timestamp, node: NodeId, number: u8, half: Half, frame: &Frame) -> Srdo {
        let state = self.configured.entry((node, number)).or_default();
        Srdo { number: Some(number), half, fit: state.take(now, half, frame) }
    }
}

impl PairState {
    fn take(&mut self, now: Timestamp, half: Half, frame: &Frame) -> Fit {
        match half {
            Half::Normal => {
                self.normal = Some((now, *frame));
                Fit::Alone
            }
            Half::Inverted => self.fit(now, frame),
        }
    }

    fn fit(&mut self, now: Timestamp, inverted: &Frame) -> Fit {
        match self.normal.take() {
            Some((then, normal)) if now - then <= VALIDATION_TIME => {
                if is_inverse(normal.data(), inverted.data()) {
                    Fit::Inverse
                } else {
                    Fit::Different
                }
            }
            _ => Fit::Alone,
        }
    }
}
