//! Frames that some devices send without a master's request: requests of their own SDO client, and application
//! frames.

use super::context::Context;
use super::nmt::Phase;
use super::service::{Event, Service};
use crate::Liberty;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{CanId, Duration, Frame, Timestamp};

/// Interval between the requests of the device's own SDO client.
const ASKED: Duration = Duration::from_millis(500);
/// The possible servers of the client: the client asks the first node-ID that is not the device's own.
const SERVERS: [u16; 2] = [127, 126];
const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);

/// Interval between bursts.
const BURSTS: Duration = Duration::from_millis(250);
/// Number of frames in a burst.
const BURST: u8 = 20;
/// A CAN-ID without predefined use.
const BURST_ID: u32 = 0x6D0;

/// Sends frames that no master requested.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnTraffic {
    request: Timestamp,
    burst: Timestamp,
}

impl OwnTraffic {
    /// The state of a device that sends no such frames.
    pub const fn new() -> Self {
        Self { request: Timestamp::MAX, burst: Timestamp::MAX }
    }

    fn ask(node: NodeId) -> Frame {
        let server = SERVERS.into_iter().find(|&server| server != u16::from(node.raw())).unwrap_or_default();
        Request::upload(DEVICE_TYPE).to_frame(sdo::REQUEST_BASE + server)
    }
}

impl Service for OwnTraffic {
    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Initialise => *self = Self::new(),
            Event::Started => {
                let firmware = context.firmware();
                self.request = if firmware.takes(Liberty::OwnSdoClient) { now + ASKED } else { Timestamp::MAX };
                self.burst = if firmware.takes(Liberty::OwnTraffic) { now + BURSTS } else { Timestamp::MAX };
            }
            _ => {}
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        let may_send = matches!(context.phase, Phase::PreOperational | Phase::Operational);
        let Some(node) = context.node else { return };
        if now >= self.request {
            self.request = now + ASKED;
            if may_send {
                context.send(Self::ask(node));
            }
        }
        if now >= self.burst {
            self.burst = now + BURSTS;
            let numbers = if may_send { 0..BURST } else { 0..0 };
            numbers.for_each(|number| context.send(Frame::full(CanId::standard_masked(BURST_ID), [number; 8])));
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.request.min(self.burst)
    }
}
