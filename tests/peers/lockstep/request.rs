//! The requests of the peer.

use serde::Deserialize;

/// One request: `{"do": "wait", "ms": 100}`.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// Lists the models, the words of `--allow`, and the cases with their touches.
    Catalogue,
    /// Creates a bus of its own for the simulated device with this address, switched on at time 0.
    Device { address: String },
    /// Sends a frame and receives until the bus was silent for this time.
    Send { frame: String, silence_us: u64 },
    /// Receives for this time.
    Wait { ms: u64 },
    /// Switches the supply of the device off and on.
    PowerCycle,
    /// Keeps the state of bus, device and journal under this name.
    Keep { name: String },
    /// Returns to a kept state.
    GoBack { name: String },
    /// Runs `canvass test`.
    Run(Wanted),
    /// Runs `canvass restore` with the journal of a killed run.
    Restore,
}

/// A run of the suite.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wanted {
    /// The words of `--allow`.
    pub allow: Vec<String>,
    /// The ids of the cases; empty: all cases.
    pub select: Vec<String>,
    /// The option `--zero-point-stored`.
    pub zero_point_stored: bool,
    /// The option `--power-cycle`: whether the tester can switch the supply of the device.
    pub power_cycle: bool,
    /// Presses Ctrl-C at this frame, counted from 1.
    pub interrupt: Option<u64>,
    /// The numbers of frames, counted from 1, at which the device's state is saved as `kill N`, as if the run ended
    /// there.
    pub kill: Vec<u64>,
}
