//! Collects the events of a capture: those that its frames cause, its comments, and the SDO transfers that stay open.

use crate::decoded_frame::DecodedFrame;
use crate::events::{EventRow, What};
use canvass_analyzer::network::Network;
use canvass_reports::events::Scene;
use canvass_traces::{ChannelId, Channels, Timestamp};
use std::ops::ControlFlow;

/// Collects the events of a capture. It keeps the latest comment until the next event.
#[derive(Default)]
pub struct EventCollector {
    /// The time of the last frame.
    last: Option<Timestamp>,
    /// The latest comment of the capture, which is output before the next event.
    comment: String,
}

impl EventCollector {
    /// Passes each event of a frame to `emit`, until it returns `Break` or an error.
    ///
    /// # Errors
    /// The errors of `emit`.
    pub fn frame<E>(
        &mut self,
        frame: DecodedFrame<'_>,
        mut emit: impl FnMut(&EventRow<'_>) -> Result<ControlFlow<()>, E>,
    ) -> Result<ControlFlow<()>, E> {
        let DecodedFrame { capture, record, channels, decoded, bus } = frame;
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

    /// Passes each SDO transfer that was still open at the end of the capture to `emit`. `skipped` is the time of the last
    /// frame, if that frame was skipped.
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
