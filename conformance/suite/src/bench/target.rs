//! The device under test, and the conditions of its test.

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
    /// The node-ID of the device.
    pub node: NodeId,
    /// The user's name for the device: the id of a model or the path of an EDS. Empty if neither was given.
    pub model: String,
    /// The description of the device: its EDS, or the description of its model.
    pub description: Option<DeviceDescription>,
    /// Facts from the manual of the device; empty if there is no manual.
    pub manual: Manual,
    /// Differences from the standard that the device's own documentation announces.
    pub deviations: Vec<Deviation>,
    /// Cases whose failures do not count yet.
    pub quarantines: Vec<Quarantine>,
    /// Whether the device is simulated from its description alone. Each failure then shows an error in the description.
    pub described_alone: bool,
}

/// The options of a test. A bundle of evidence contains them, except those that only concern the tester's machine.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct Options {
    /// The actions that the user allows, beyond the actions without lasting effects.
    pub allow: BTreeSet<Touch>,
    /// The maximum waits.
    pub timing: Timing,
    /// Number of runs of each case; 0 and 1 mean one.
    pub repeat: u32,
    /// Maximum number of repetitions of a case that fails, until it passes.
    pub retries: u32,
    /// Whether the run ends after the first case that fails.
    pub fail_fast: bool,
    /// A command of the user, for `sh`, that switches the supply of the device off and on.
    #[serde(skip)]
    pub power_cycle: Option<String>,
    /// Whether cases that normally try samples try everything: every index, every restricted CAN-ID.
    pub exhaustive: bool,
    /// Maximum duration of the whole run on the clock of the bus, including everything except putting the device back.
    #[serde(rename = "limit_ns", with = "nanos::optional")]
    pub limit: Option<Duration>,
    /// Whether the user states that the zero point of the device is stored, so that a reset does not lose it.
    // Bundles of earlier programs lack this option.
    #[serde(default)]
    pub zero_point_is_stored: bool,
    /// The file in which changes are recorded before they are made, so that the device can be put back if the tester is
    /// killed.
    #[serde(skip)]
    pub journal: Option<PathBuf>,
}

/// The maximum waits. CiA 301 gives no numbers for any of them: all are chosen by the tester.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Timing {
    /// Wait for each response of an SDO server.
    #[serde(rename = "sdo_response_ns", with = "nanos")]
    pub sdo_response: Duration,
    /// Wait for the response to a store or restore command (1010h, 1011h).
    #[serde(rename = "store_ns", with = "nanos")]
    pub store: Duration,
    /// Wait for each response of an LSS or LMT slave.
    #[serde(rename = "lss_ns", with = "nanos")]
    pub lss: Duration,
    /// Maximum time from a reset command to the boot-up message.
    #[serde(rename = "boot_up_ns", with = "nanos")]
    pub boot_up: Duration,
    /// Maximum time from an NMT command to the commanded state.
    #[serde(rename = "reaction_ns", with = "nanos")]
    pub reaction: Duration,
    /// Time without a frame that counts as silence.
    #[serde(rename = "silence_ns", with = "nanos")]
    pub silence: Duration,
    /// Maximum difference of the mean of a period, in percent (but see [`Timing::PERIOD_FLOOR`]).
    pub period_tolerance: u32,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            // Most masters give up after 500 ms to 1 s; a server slower than that does not work in the field.
            sdo_response: Duration::from_millis(1_000),
            // EEPROMs are written in 10 ms to 3 s, and some devices are silent meanwhile.
            store: Duration::from_millis(10_000),
            // The response to "store configuration" comes when all is written, which may take seconds.
            lss: Duration::from_millis(5_000),
            // Sensors with a bootloader and a self-test take up to 2 s, drives 5 s.
            boot_up: Duration::from_millis(10_000),
            // Stacks handle NMT in their main loop, every 1 to 20 ms.
            reaction: Duration::from_millis(50),
            // Twice the response time of a slow server.
            silence: Duration::from_millis(200),
            period_tolerance: 5,
        }
    }
}

impl Timing {
    /// Minimum tolerance of a period, whatever the percentage: timers tick in milliseconds.
    pub const PERIOD_FLOOR: Duration = Duration::from_millis(1);

    /// Maximum difference of a mean period.
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

    /// A device with the user's name for it, and its description if there is one.
    pub fn known(node: NodeId, model: String, device: Option<KnownDevice>) -> Self {
        let (description, manual) = match device {
            Some(KnownDevice { description, manual }) => (Some(description), manual),
            None => (None, Manual::default()),
        };
        Self { model, description, manual, ..Self::unknown(node) }
    }

    /// A device of a built-in model: its description, and the differences that its manual announces.
    pub fn of(model: &Model, node: NodeId) -> Self {
        Self::with_faults(model, node, Faults::NONE)
    }

    /// The device of [`Target::of`], with those of the faults that change its description. Faults of the firmware
    /// change nothing here.
    pub(crate) fn with_faults(model: &Model, node: NodeId, faults: Faults) -> Self {
        Self::with_firmware(model, node, faults.into())
    }

    /// The device of [`Target::of`], with the changes that this firmware makes in its description.
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
