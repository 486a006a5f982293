//! The rows that a decoded frame gives to each table.

use super::ScanError;
use super::emit::Emitter;
use crate::devices::Devices;
use crate::table::events::Events;
use crate::table::messages::Messages;
use crate::table::signals::{SignalRow, Signals};
use canvass_analyzer::network::{Network, Steady};
pub use canvass_tables::decoded_frame::DecodedFrame;
use canvass_tables::event_collector::EventCollector;
use std::ops::ControlFlow;

/// A network with the devices of these rules.
///
/// # Errors
/// If a description can't be read.
pub fn network(devices: &Devices) -> Result<Network, ScanError> {
    let mut network = Network::new();
    let mut offered = None;
    devices.tell(|node, known| network.describe(node, known), |candidates| offered = Some(candidates))?;
    network.offer(offered.unwrap_or_default());
    Ok(network)
}

/// A table whose rows are made of decoded frames.
pub trait OfFrames {
    /// Outputs the rows of a frame; `Break` if no more rows are wanted.
    ///
    /// # Errors
    /// As [`Emitter::row`].
    fn frame(&mut self, frame: DecodedFrame<'_>) -> Result<ControlFlow<()>, ScanError>;

    /// Whether there may be frames that give no rows.
    fn may_refuse(&self) -> bool;

    /// Whether neither this frame, which is the latest, nor any frame like it gives rows.
    fn refuses(&mut self, frame: DecodedFrame<'_>, steady: Steady) -> bool;

    /// Reports `frames` skipped frames before the next frame; `Break` if no more rows are wanted.
    fn skipped(&mut self, frames: usize) -> ControlFlow<()>;
}

impl OfFrames for Emitter<'_, Messages> {
    fn frame(&mut self, frame: DecodedFrame<'_>) -> Result<ControlFlow<()>, ScanError> {
        message(frame, self)
    }

    fn may_refuse(&self) -> bool {
        self.may_refuse_alike()
    }

    fn refuses(&mut self, frame: DecodedFrame<'_>, steady: Steady) -> bool {
        self.refuses_alike(&frame, steady)
    }

    fn skipped(&mut self, frames: usize) -> ControlFlow<()> {
        Self::skipped(self, frames)
    }
}

impl OfFrames for Emitter<'_, Signals> {
    fn frame(&mut self, frame: DecodedFrame<'_>) -> Result<ControlFlow<()>, ScanError> {
        signals(frame, self)
    }

    fn may_refuse(&self) -> bool {
        true
    }

    /// Frames that are alike have the same signals.
    fn refuses(&mut self, frame: DecodedFrame<'_>, steady: Steady) -> bool {
        frame.meaning().signals().all(|signal| self.refuses_alike(&SignalRow { frame, signal: &signal }, steady))
    }

    fn skipped(&mut self, frames: usize) -> ControlFlow<()> {
        Self::skipped(self, frames)
    }
}

/// The events of frames.
pub struct EventsOfFrames<'a> {
    /// The collector of the events.
    pub collector: EventCollector,
    /// The emitter of the events.
    pub emitter: Emitter<'a, Events>,
}

impl OfFrames for EventsOfFrames<'_> {
    fn frame(&mut self, frame: DecodedFrame<'_>) -> Result<ControlFlow<()>, ScanError> {
        if frame.bus.events().is_empty() {
            let _ = self.collector.frame(frame, |row| self.emitter.row(row))?;
            return Ok(self.emitter.look());
        }
        self.collector.frame(frame, |row| self.emitter.row(row))
    }

    fn may_refuse(&self) -> bool {
        true
    }

    /// A frame that changes no state causes no event.
    fn refuses(&mut self, _: DecodedFrame<'_>, _: Steady) -> bool {
        true
    }

    fn skipped(&mut self, frames: usize) -> ControlFlow<()> {
        self.emitter.skipped(frames)
    }
}

/// Outputs a frame to `messages`.
#[inline]
pub fn message(frame: DecodedFrame<'_>, emitter: &mut Emitter<'_, Messages>) -> Result<ControlFlow<()>, ScanError> {
    emitter.row(&frame)
}

/// Outputs the values of a frame to `signals`.
#[inline]
pub fn signals(frame: DecodedFrame<'_>, emitter: &mut Emitter<'_, Signals>) -> Result<ControlFlow<()>, ScanError> {
    for signal in frame.meaning().signals() {
        if emitter.row(&SignalRow { frame, signal: &signal })?.is_break() {
            return Ok(ControlFlow::Break(()));
        }
    }
    Ok(emitter.look())
}
