//! Facts about the device that the run has found out and need not find out again.

use super::idle::KeptOpen;
use super::promptness::Promptness;
use super::state::Heartbeats;
use crate::verdict::Reason;
use canvass_analyzer::Multiplexer;
use canvass_traces::Duration;
use std::collections::{BTreeMap, BTreeSet};

/// Whether the device has the features that a case needs; if not, the reason.
pub type Met = Result<(), String>;

/// The result of the check of a need, kept for the run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Found {
    /// The device meets the need, or the reason why not.
    Known(Met),
    /// The device answered neither like a device that has the feature nor like a device that lacks it; case
    /// `reported_in` reports the breach.
    Broken { why: Reason, reported_in: &'static str },
}

/// The facts found out about the device.
#[derive(Clone, Debug, Default)]
pub(crate) struct Knowledge {
    needs: BTreeMap<&'static str, Found>,
    pub(super) starts_by_itself: Option<bool>,
    /// Whether the device has shown that it is operational.
    pub(super) was_operational: bool,
    /// The case after which the device could no longer be operational.
    pub(super) kept_out_since: Option<&'static str>,
    /// Whether the device does not show its state at all.
    pub(super) shows_no_state: bool,
    /// Whether resets were followed by answers but by no boot-up message.
    pub(super) starts_silently: bool,
    /// Whether each start of the device has two boot-up messages.
    pub(super) boots_twice: Option<bool>,
    pub(super) heartbeats: Option<Heartbeats>,
    /// For each object, whether it accepts a write of its current value.
    pub(super) willing: BTreeMap<Multiplexer, bool>,
    /// Objects that have accepted a new value.
    pub(super) takes: BTreeSet<Multiplexer>,
    /// The longest time that the device took to answer a request that it served at once.
    pub(super) slowest_answer: Duration,
    /// The first value read from 1000h.
    pub(super) device_type: Option<Vec<u8>>,
    /// Number of transfers that ended correctly, or with an abort in the right form.
    pub(super) served: u64,
    /// Whether the tester has looked for other nodes.
    pub(super) others_known: bool,
    /// The case in which the device left the bus, if it has not come back.
    pub(super) gone: Option<&'static str>,
    /// The first transfer that the server kept open against the client's abort.
    pub(super) kept_open: Option<KeptOpen>,
    pub(super) promptness: Promptness,
}

impl Knowledge {
    /// The result for the need with this id.
    pub(crate) fn known(&self, need: &'static str) -> Option<&Found> {
        self.needs.get(need)
    }

    /// Number of SDO transfers since the start of the run that ended correctly, or with an abort in the right form.
    pub(crate) const fn served(&self) -> u64 {
        self.served
    }

    /// Keeps the result for the need with this id.
    pub(crate) fn learned(&mut self, need: &'static str, found: Found) {
        self.needs.insert(need, found);
    }

    /// Whether the device is known to have left the bus.
    pub(crate) const fn has_gone(&self) -> bool {
        self.gone.is_some()
    }

    /// The facts that hold for the firmware in every run.
    pub(crate) fn of_firmware(self) -> Self {
        Self { gone: None, promptness: Promptness::default(), ..self }
    }

    /// Whether the device may be operational: it was operational in this run and nothing since has shown that it no
    /// longer can be, or it does not show its state.
    pub(crate) const fn may_be_operational(&self) -> bool {
        self.shows_no_state || self.was_operational && self.kept_out_since.is_none()
    }

    /// The time that the device usually takes to answer.
    pub(crate) fn usual_answer(&self) -> Duration {
        self.promptness.usual()
    }
}
