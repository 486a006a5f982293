//! What was found out about the device, and need not be found out again.

use super::promptness::Promptness;
use super::state::Heartbeats;
use crate::verdict::Reason;
use canvass_analyzer::Multiplexer;
use canvass_traces::Duration;
use std::collections::{BTreeMap, BTreeSet};

/// Whether the device has what a case needs; if not, why not.
pub type Met = Result<(), String>;

/// What asking for a need led to. Kept for the run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Found {
    /// The device has it, or says why not.
    Known(Met),
    /// The device answered neither as one that has it nor as one that does not: that case reports the breach.
    Broken { why: Reason, reported_in: &'static str },
}

/// What was found out about the device.
#[derive(Clone, Debug, Default)]
pub(crate) struct Knowledge {
    needs: BTreeMap<&'static str, Found>,
    pub(super) starts_by_itself: Option<bool>,
    /// It has shown that it is operational.
    pub(super) was_operational: bool,
    /// The case after which it could not be operational any more.
    pub(super) kept_out_since: Option<&'static str>,
    /// It shows its state in no way.
    pub(super) shows_no_state: bool,
    /// Resets were followed by answers, and not by a boot-up message.
    pub(super) starts_silently: bool,
    /// Each of its starts has two boot-up messages.
    pub(super) boots_twice: Option<bool>,
    pub(super) heartbeats: Option<Heartbeats>,
    /// Which objects let themselves be written with the value that they have.
    pub(super) willing: BTreeMap<Multiplexer, bool>,
    /// Objects that have taken another value than they had.
    pub(super) takes: BTreeSet<Multiplexer>,
    /// The longest that the device took to answer a request that it served at once.
    pub(super) slowest_answer: Duration,
    /// 1000h as it was read first.
    pub(super) device_type: Option<Vec<u8>>,
    /// How many transfers came to their right end, or to an abort in the right form.
    pub(super) served: u64,
    /// Other nodes were looked for.
    pub(super) others_known: bool,
    /// The case in which the device left the bus, if it did not come back.
    pub(super) gone: Option<&'static str>,
    pub(super) promptness: Promptness,
}

impl Knowledge {
    /// What is known of the need of that id.
    pub(crate) fn known(&self, need: &'static str) -> Option<&Found> {
        self.needs.get(need)
    }

    /// How many SDO transfers came to their right end, or to an abort in the right form, since the start of the run.
    pub(crate) const fn served(&self) -> u64 {
        self.served
    }

    /// Keeps what was found out about the need of that id.
    pub(crate) fn learned(&mut self, need: &'static str, found: Found) {
        self.needs.insert(need, found);
    }

    /// Whether the device is known to have left the bus.
    pub(crate) const fn has_gone(&self) -> bool {
        self.gone.is_some()
    }

    /// What holds of the firmware in every run.
    pub(crate) fn of_firmware(self) -> Self {
        Self { gone: None, promptness: Promptness::default(), ..self }
    }

    /// The device was operational in this run, and nothing has shown since that it can't be any more; or it shows no state.
    pub(crate) const fn may_be_operational(&self) -> bool {
        self.shows_no_state || self.was_operational && self.kept_out_since.is_none()
    }

    /// How long the device usually takes to answer.
    pub(crate) fn usual_answer(&self) -> Duration {
        self.promptness.usual()
    }
}
