//! What can be asked for.

use serde::Deserialize;

/// One request: `{"do": "wait", "ms": 100}`.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// The models, the words of `--allow`, the cases with what each of them touches.
    Catalogue,
    /// A bus of its own for the simulated device of that address, switched on at time 0.
    Device { address: String },
    /// Sends a frame and receives until the bus was silent for that long.
    Send { frame: String, silence_us: u64 },
    /// Receives for that long.
    Wait { ms: u64 },
    /// Switches the supply of the device off and on.
    PowerCycle,
    /// Keeps the state of bus, device and journal under that name.
    Keep { name: String },
    /// Goes back to a state that was kept.
    GoBack { name: String },
    /// `canvass test`.
    Run(Wanted),
    /// `canvass restore`, by the journal that a killed run has left.
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
    /// `--zero-point-stored`.
    pub zero_point_stored: bool,
    /// `--power-cycle`: whether the tester can switch the supply of the device.
    pub power_cycle: bool,
    /// Presses Ctrl-C at this frame, counted from 1.
    pub interrupt: Option<u64>,
    /// Keeps what a kill at each of these frames would leave, under the name `kill N`.
    pub kill: Vec<u64>,
}
