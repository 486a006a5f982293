//! Pairs the two frames of each SRDO, and finds the CAN-IDs of 101h to 180h that carry SRDOs without known
//! parameters.

use crate::NodeId;
use crate::wire::srdo::{Fit, Half, Pair, Srdo, is_inverse};
use canvass_traces::{Duration, Frame, Timestamp};
use std::collections::BTreeMap;

/// The SRDO pairs of a bus. Two CAN-IDs are a pair only after the inverted data followed the data; until then their
/// frames have no known use.
#[derive(Clone, Default)]
pub(crate) struct SrdoPairs {
    /// The pairs by [`Pair::position`]; empty before the first frame.
    pairs: Vec<PairState>,
    /// The pairs with known parameters, by node and number.
    configured: BTreeMap<(NodeId, u8), PairState>,
}

#[derive(Clone, Copy, Default)]
struct PairState {
    /// Whether the two CAN-IDs are known to be a pair.
    known: bool,
    /// The data whose inverse is due.
    normal: Option<(Timestamp, Frame)>,
}

/// The longest time between the two frames (safety-relevant object validation time, one byte of milliseconds).
const VALIDATION_TIME: Duration = Duration(255_000_000);

impl SrdoPairs {
    /// Handles a frame; `None` if the frame is not known to be part of an SRDO.
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

    /// Handles a frame of an SRDO with known parameters.
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
