//! `canvass restore`: restores a device after an interrupted run.

use crate::devices::named;
use crate::live::{CLIENT, open_device_bus};
use crate::put_back::{put_back, read};
use crate::status::{Failure, Status};
use crate::timing::{self, Timeout};
use canvass_bus::{Endurance, PatientBus};
use canvass_suite::bench::Timing;
use std::path::PathBuf;
use std::sync::Arc;

/// Restore a device that an interrupted run of `canvass test` has left changed
///
/// A run that was killed, or whose machine lost power, leaves its journal: the changed objects with their former
/// values. canvass removes the journal when all are restored. Exit status 1 if some could not be restored.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE] or pcan:CHANNEL@BITRATE
    bus: String,
    /// The journal of the interrupted run
    #[arg(long, value_name = "FILE")]
    journal: PathBuf,
    /// The device: a built-in model, or an EDS or DCF file (default: the device that the journal names)
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    /// Timeouts, such as sdo=500ms: sdo, store, lss, boot-up, reaction, silence, client (for a client of
    /// slcan:listen:// to connect, default 10s), reconnect (for an interrupted bus to come back, default 2min)
    #[arg(long, value_name = "WHAT=SPAN", value_delimiter = ',')]
    timeout: Vec<Timeout>,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let interrupted = read(&self.journal)?;
        let client = self.timeout.iter().rev().find_map(|timeout| timeout.of_client()).unwrap_or(CLIENT);
        let mut timing = Timing::default();
        self.timeout.iter().for_each(|timeout| timeout.set(&mut timing));
        let mut opened = open_device_bus(&self.bus, 0, client)?;
        let device = self.device.as_deref().map_or(&*interrupted.device, named);
        let endurance = Endurance { patience: timing::reconnect(&self.timeout), ends: None, cancelled: Arc::default() };
        let mut bus = PatientBus::new(opened.bus.as_mut(), endurance);
        put_back(&mut bus, device, timing, &interrupted, &self.journal)
    }
}
