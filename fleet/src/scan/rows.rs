//! The rows that a decoded frame gives to each table.

use super::ScanError;
use super::emit::Emitter;
use crate::capture::Reading;
use crate::devices::Devices;
use crate::table::events::{EventRow, Events, What};
use crate::table::messages::{MessageRow, Messages};
use crate::table::signals::{SignalRow, Signals};
use canvass_analyzer::Meaning;
use canvass_analyzer::network::{Bus, Decoded, Network, Steady};
use canvass_reports::events::Scene;
use canvass_traces::{ChannelId, Channels, Record, Timestamp};
use std::ops::ControlFlow;

/// A decoded frame with its bus.
#[derive(Clone, Copy)]
pub struct Understood<'a> {
    /// The capture's name.
    pub capture: &'a str,
    /// The frame.
    pub record: &'a Record,
    /// The channels of the capture, with their names.
    pub channels: &'a Channels,
    /// The decoded meaning of the frame.
    pub decoded: &'a Decoded,
    /// The state of the bus after this frame.
    pub bus: &'a Bus,
}

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
    fn frame(&mut self, frame: Understood<'_>) -> Result<ControlFlow<()>, ScanError>;

    /// Whether there may be frames that give no rows.
    fn may_refuse(&self) -> bool;

    /// Whether neither this frame, which is the latest, nor any frame like it gives rows.
    fn refuses(&mut self, frame: Understood<'_>, steady: Steady) -> bool;

    /// Reports `frames` skipped frames before the next frame; `Break` if no more rows are wanted.
    fn skipped(&mut self, frames: usize) -> ControlFlow<()>;
}

impl OfFrames for Emitter<'_, Messages> {
    fn frame(&mut self, frame: Understood<'_>) -> Result<ControlFlow<()>, ScanError> {
        message(frame, self)
    }

    fn may_refuse(&self) -> bool {
        self.may_refuse_alike()
    }

    fn refuses(&mut self, frame: Understood<'_>, steady: Steady) -> bool {
        let Understood { capture, record, channels, decoded, bus } = frame;
        self.refuses_alike(&MessageRow { capture, record, channels, decoded, bus }, steady)
    }

    fn skipped(&mut self, frames: usize) -> ControlFlow<()> {
        Self::skipped(self, frames)
    }
}

impl OfFrames for Emitter<'_, Signals> {
    fn frame(&mut self, frame: Understood<'_>) -> Result<ControlFlow<()>, ScanError> {
        signals(frame, self)
    }

    fn may_refuse(&self) -> bool {
        true
    }

    /// Frames that are alike have the same signals.
    fn refuses(&mut self, frame: Understood<'_>, steady: Steady) -> bool {
        let Understood { capture, record, channels, decoded, bus } = frame;
        Meaning::new(record, decoded, bus).signals().all(|signal| {
            self.refuses_alike(&SignalRow { capture, record, channels, decoded, signal: &signal }, steady)
        })
    }

    fn skipped(&mut self, frames: usize) -> ControlFlow<()> {
        Self::skipped(self, frames)
    }
}

/// The events of frames.
pub struct EventsOfFrames<'a> {
    /// The state between events.
    pub happenings: Happenings,
    /// The emitter of the events.
    pub emitter: Emitter<'a, Events>,
}

impl OfFrames for EventsOfFrames<'_> {
    fn frame(&mut self, frame: Understood<'_>) -> Result<ControlFlow<()>, ScanError> {
        self.happenings.frame(frame, &mut self.emitter)
    }

    fn may_refuse(&self) -> bool {
        true
    }

    /// A frame that changes no state causes no event.
    fn refuses(&mut self, _: Understood<'_>, _: Steady) -> bool {
        true
    }

    fn skipped(&mut self, frames: usize) -> ControlFlow<()> {
        self.emitter.skipped(frames)
    }
}

/// Outputs a frame to `messages`.
#[inline]
pub fn message(frame: Understood<'_>, emitter: &mut Emitter<'_, Messages>) -> Result<ControlFlow<()>, ScanError> {
    let Understood { capture, record, channels, decoded, bus } = frame;
    emitter.row(&MessageRow { capture, record, channels, decoded, bus })
}

/// Outputs the values of a frame to `signals`.
#[inline]
pub fn signals(frame: Understood<'_>, emitter: &mut Emitter<'_, Signals>) -> Result<ControlFlow<()>, ScanError> {
    let Understood { capture, record, channels, decoded, bus } = frame;
    for signal in Meaning::new(record, decoded, bus).signals() {
        let row = SignalRow { capture, record, channels, decoded, signal: &signal };
        if emitter.row(&row)?.is_break() {
            return Ok(ControlFlow::Break(()));
        }
    }
    Ok(emitter.look())
}

/// Outputs the events of frames to `events`.
#[derive(Default)]
pub struct Happenings {
    /// The time of the last frame.
    last: Option<Timestamp>,
    /// The latest comment of the capture, which is output before the next event.
    comment: String,
}

impl Happenings {
    /// Outputs the events of a frame.
    pub fn frame(
        &mut self,
        frame: Understood<'_>,
        emitter: &mut Emitter<'_, Events>,
    ) -> Result<ControlFlow<()>, ScanError> {
        let Understood { capture, record, channels, decoded, bus } = frame;
        if let Some(latest) = record.comment() {
            self.comment.clear();
            self.comment.push_str(latest);
        }
        self.last = Some(record.timestamp);
        if bus.events().is_empty() {
            return Ok(emitter.look());
        }
        let channel = channels.name(record.channel);
        let scene = &Scene { time: record.timestamp, channel, bus, frame: Some((record, decoded)) };
        for event in bus.events() {
            if !self.comment.is_empty() {
                let row = EventRow { capture, scene, what: What::Comment(&self.comment) };
                if emitter.row(&row)?.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
                self.comment.clear();
            }
            let what = What::Event(event, scene.transfer(event));
            // The end of a transfer on an unknown channel has no details.
            if matches!(what, What::Event(event, None) if scene.kind(event) == "sdo") {
                continue;
            }
            if emitter.row(&EventRow { capture, scene, what })?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Outputs the transfers that had not ended at the end of the capture; `skipped` is the time of the last frame if
    /// that frame was skipped.
    pub fn finish(
        &self,
        capture: &str,
        reading: &Reading,
        network: &Network,
        skipped: Option<Timestamp>,
        emitter: &mut Emitter<'_, Events>,
    ) -> Result<(), ScanError> {
        let Some(time) = skipped.or(self.last) else { return Ok(()) };
        for (id, channel) in (0_u16..).zip(reading.merge().channels().names()) {
            let Some(bus) = network.bus(ChannelId(id)) else { continue };
            let scene = &Scene { time, channel, bus, frame: None };
            for (server, transfer) in bus.open_transfers() {
                if emitter.row(&EventRow { capture, scene, what: What::Open(server, transfer) })?.is_break() {
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}
