//! What is tested, and under which conditions.

use super::nanos;
use crate::quarantine::Quarantine;
use crate::touch::Touch;
use crate::verdict::Deviation;
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice, Manual};
use canvass_device::models::Model;
use canvass_device::{Faults, Firmware};
use canvass_traces::Duration;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The device under test.
#[derive(Clone, Debug)]
pub struct Target {
    /// Its node-ID.
    pub node: NodeId,
    /// What the user calls it: the id of a model or the path of an EDS. Empty if neither was given.
    pub model: String,
    /// What its EDS or model says about it.
    pub description: Option<DeviceDescription>,
    /// What its manual adds; empty where nobody gave it.
    pub manual: Manual,
    /// Where its own documentation announces that it differs from the standard.
    pub deviations: Vec<Deviation>,
    /// Cases whose failures do not count yet.
    pub quarantines: Vec<Quarantine>,
    /// Whether it is simulated from its description and nothing else, so that what is wrong with it is wrong there.
    pub described_alone: bool,
}

/// How to test. A bundle of evidence holds it, but for what only concerns the machine of the tester.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct Options {
    /// What the cases may do beyond what leaves no trace.
    pub allow: BTreeSet<Touch>,
    /// How long to wait for what.
    pub timing: Timing,
    /// How often each case runs; 0 and 1: once.
    pub repeat: u32,
    /// How often a case that fails is run again until it passes.
    pub retries: u32,
    /// Whether the run ends with the first case that fails.
    pub fail_fast: bool,
    /// A command of the user, for `sh`, that switches the supply of the device off and on.
    #[serde(skip)]
    pub power_cycle: Option<String>,
    /// Whether cases that try samples try everything: every index, every restricted CAN-ID.
    pub exhaustive: bool,
    /// How long the whole run may take on the clock of the bus, with all but putting the device back.
    #[serde(rename = "limit_ns", with = "nanos::optional")]
    pub limit: Option<Duration>,
    /// Whether the user says that the zero point of the device is stored: a reset does not lose it.
    // Bundles of earlier programs do not have it.
    #[serde(default)]
    pub zero_point_is_stored: bool,
    /// Where what is changed is written down beforehand, so that the device can be put back if the tester is killed.
    #[serde(skip)]
    pub journal: Option<PathBuf>,
}

/// How long to wait for what. CiA 301 gives no numbers for any of these: all are the tester's.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Timing {
    /// For each response of an SDO server.
    #[serde(rename = "sdo_response_ns", with = "nanos")]
    pub sdo_response: Duration,
    /// For the response to a store or restore command (1010h, 1011h).
    #[serde(rename = "store_ns", with = "nanos")]
    pub store: Duration,
    /// For each response of an LSS or LMT slave.
    #[serde(rename = "lss_ns", with = "nanos")]
    pub lss: Duration,
    /// From a reset command to the boot-up message.
    #[serde(rename = "boot_up_ns", with = "nanos")]
    pub boot_up: Duration,
    /// From an NMT command to the state it leads to.
    #[serde(rename = "reaction_ns", with = "nanos")]
    pub reaction: Duration,
    /// How long nothing must come where nothing may come.
    #[serde(rename = "silence_ns", with = "nanos")]
    pub silence: Duration,
    /// How far the mean of a period may be off, in percent (but see [`Timing::PERIOD_FLOOR`]).
    pub period_tolerance: u32,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            // Most masters give up after 500 ms to 1 s; a server slower than that does not work in the field.
            sdo_response: Duration::from_millis(1_000),
            // EEPROMs are written in 10 ms to 3 s, and some devices are silent meanwhile.
            store: Duration::from_millis(10_000),
            // The answer to "store configuration" comes when all is written, which may take seconds.
            lss: Duration::from_millis(5_000),
            // Sensors with a bootloader and a self-test take up to 2 s, drives 5 s.
            boot_up: Duration::from_millis(10_000),
            // Stacks handle NMT in their main loop, every 1 to 20 ms.
            reaction: Duration::from_millis(50),
            // Twice what a slow server takes to answer.
            silence: Duration::from_millis(200),
            period_tolerance: 5,
        }
    }
}

impl Timing {
    /// A period is never held to less than this, whatever the percentage: timers tick in milliseconds.
    pub const PERIOD_FLOOR: Duration = Duration::from_millis(1);

    /// By how much a mean period may differ.
    pub fn tolerance(&self, period: Duration) -> Duration {
        let share = period.nanos() / 100 * u64::from(self.period_tolerance);
        Duration::from_nanos(share.max(Self::PERIOD_FLOOR.nanos()))
    }
}

impl Target {
    /// A device of which only the node-ID is known.
    pub fn unknown(node: NodeId) -> Self {
        Self {
            node,
            model: String::new(),
            description: None,
            manual: Manual::default(),
            deviations: Vec::new(),
            quarantines: Vec::new(),
            described_alone: false,
        }
    }

    /// A device that the user calls so, and what is known of it.
    pub fn known(node: NodeId, model: String, device: Option<KnownDevice>) -> Self {
        let (description, manual) = match device {
            Some(KnownDevice { description, manual }) => (Some(description), manual),
            None => (None, Manual::default()),
        };
        Self { model, description, manual, ..Self::unknown(node) }
    }

    /// A device of a built-in model: its description, and what its manual says that it does otherwise.
    pub fn of(model: &Model, node: NodeId) -> Self {
        Self::with_faults(model, node, Faults::NONE)
    }

    /// As [`Target::of`], from a maker whose description has those faults; those of the firmware change nothing here.
    pub fn with_faults(model: &Model, node: NodeId, faults: Faults) -> Self {
        Self::with_firmware(model, node, faults.into())
    }

    /// As [`Target::of`], from a maker whose description has what that firmware changes in it.
    pub fn with_firmware(model: &Model, node: NodeId, firmware: Firmware) -> Self {
        Self {
            node,
            model: model.id().to_owned(),
            description: Some(model.description_with(firmware)),
            manual: model.device().manual.clone(),
            deviations: Deviation::of_model(model),
            quarantines: Vec::new(),
            described_alone: model.is_described_alone(),
        }
    }
}
