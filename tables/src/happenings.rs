//! The events that frames cause, in the order in which a capture shows them.

use crate::events::{EventRow, What};
use canvass_analyzer::network::{Bus, Decoded, Network};
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

/// The state between the events of a capture.
#[derive(Default)]
pub struct Happenings {
    /// The time of the last frame.
    last: Option<Timestamp>,
    /// The latest comment of the capture, which is output before the next event.
    comment: String,
}

impl Happenings {
    /// Passes the events of a frame to `emit`, until it breaks or fails.
    ///
    /// # Errors
    /// The errors of `emit`.
    pub fn frame<E>(
        &mut self,
        frame: Understood<'_>,
        mut emit: impl FnMut(&EventRow<'_>) -> Result<ControlFlow<()>, E>,
    ) -> Result<ControlFlow<()>, E> {
        let Understood { capture, record, channels, decoded, bus } = frame;
        if let Some(latest) = record.comment() {
            self.comment.clear();
            self.comment.push_str(latest);
        }
        self.last = Some(record.timestamp);
        let channel = channels.name(record.channel);
        let scene = &Scene { time: record.timestamp, channel, bus, frame: Some((record, decoded)) };
        for event in bus.events() {
            if !self.comment.is_empty() {
                let row = EventRow { capture, scene, what: What::Comment(&self.comment) };
                if emit(&row)?.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
                self.comment.clear();
            }
            let what = What::Event(event, scene.transfer(event));
            // The end of a transfer on an unknown channel has no details.
            if matches!(what, What::Event(event, None) if scene.kind(event) == "sdo") {
                continue;
            }
            if emit(&EventRow { capture, scene, what })?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Passes the transfers that had not ended at the end of the capture to `emit`, until it breaks or fails; `skipped`
    /// is the time of the last frame if that frame was skipped.
    ///
    /// # Errors
    /// The errors of `emit`.
    pub fn finish<E>(
        &self,
        capture: &str,
        channels: &Channels,
        network: &Network,
        skipped: Option<Timestamp>,
        mut emit: impl FnMut(&EventRow<'_>) -> Result<ControlFlow<()>, E>,
    ) -> Result<(), E> {
        let Some(time) = skipped.or(self.last) else { return Ok(()) };
        for (id, channel) in (0_u16..).zip(channels.names()) {
            let Some(bus) = network.bus(ChannelId(id)) else { continue };
            let scene = &Scene { time, channel, bus, frame: None };
            for (server, transfer) in bus.open_transfers() {
                if emit(&EventRow { capture, scene, what: What::Open(server, transfer) })?.is_break() {
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}
