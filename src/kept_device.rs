//! A simulated device whose non-volatile memory is a file.

use crate::whole_file::write_whole;
use anyhow::{Context, Result};
use canvass_analyzer::NodeId;
use canvass_bus::Machine;
use canvass_device::{Device, Memory};
use canvass_traces::small_file::{self, OF_PROGRAM};
use canvass_traces::{Frame, Timestamp};
use std::path::{Path, PathBuf};

/// The device; whenever the device stores parameters, canvass writes the file.
pub struct KeptDevice {
    device: Device,
    file: Option<PathBuf>,
    /// The content of the file.
    kept: Memory,
    /// The first error of writing, kept until it is reported.
    trouble: Option<anyhow::Error>,
}

impl KeptDevice {
    /// Switches the device on with the memory in the file, if the file exists.
    pub fn new(mut device: Device, file: Option<&Path>) -> Result<Self> {
        if let Some(file) = file.filter(|file| file.exists()) {
            let text =
                small_file::read_text(file, OF_PROGRAM).with_context(|| format!("can't read {}", file.display()))?;
            let unfit = || format!("{} is no memory of this device", file.display());
            let memory: Memory = text.parse().with_context(unfit)?;
            device.insert_memory(Timestamp::ZERO, &memory).with_context(unfit)?;
        }
        let kept = device.memory();
        Ok(Self { device, file: file.map(Path::to_owned), kept, trouble: None })
    }

    /// The current node-ID.
    pub fn node(&self) -> Option<NodeId> {
        self.device.node()
    }

    /// Writes the memory to the file, if the memory has changed or the file is missing. If an earlier write failed,
    /// returns its error instead.
    pub fn keep(&mut self) -> Result<()> {
        if let Some(trouble) = self.trouble.take() {
            return Err(trouble);
        }
        let Some(file) = &self.file else { return Ok(()) };
        let memory = self.device.memory();
        if memory != self.kept || !file.exists() {
            // The file is replaced when it is complete: a program killed while writing leaves the old content.
            write_whole(file, memory.to_string().as_bytes())?;
            self.kept = memory;
        }
        Ok(())
    }

    /// Writes the memory if a store was completed.
    fn keep_if_stored(&mut self, was_storing: bool) {
        if was_storing && !self.device.is_storing() && self.file.is_some() {
            self.trouble = self.keep().err();
        }
    }
}

impl Machine for KeptDevice {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        self.device.handle(now, frame);
    }

    fn ignores(&self, frame: &Frame) -> bool {
        self.device.ignores(frame)
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        self.device.poll_transmit(now)
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        self.device.poll_timeout()
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        let was_storing = self.device.is_storing();
        self.device.handle_timeout(now);
        self.keep_if_stored(was_storing);
    }

    fn bit_rate(&self) -> Option<u32> {
        self.device.bit_rate()
    }

    fn power_cycle(&mut self, now: Timestamp) {
        Machine::power_cycle(&mut self.device, now);
    }

    fn withdraws(&self, pending: &Frame) -> bool {
        self.device.withdraws(pending)
    }
}
