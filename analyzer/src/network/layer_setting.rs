//! Settings by LSS and LMT: node-IDs and bit rates that devices will use.

use super::event::{Event, Exchange};
use crate::NodeId;
use crate::wire::layer_setting::{ConfigureCommand, Dialect, Request, Response};
use crate::wire::{lmt, lss};
use canvass_traces::{Duration, Timestamp};

/// The state of layer setting on one bus.
#[derive(Clone, Default)]
pub struct LayerSetting {
    /// Time of the master's last request, and whether an answer is due.
    asked: Option<(Timestamp, bool)>,
    node_id: Setting<u8>,
    bit_rate: Setting<Option<u32>>,
    /// The node-ID that the slave in configuration has reported.
    told: Option<NodeId>,
    /// The LSS address of the slave that was switched to configuration.
    address: [Option<u32>; 4],
}

/// A value requested by the master, then confirmed by the slave, until it takes effect.
#[derive(Clone, Default)]
struct Setting<T> {
    asked: Option<T>,
    confirmed: Option<T>,
}

impl<T> Setting<T> {
    fn answered(&mut self, success: bool) {
        let asked = self.asked.take();
        if success {
            self.confirmed = asked;
        }
    }
}

impl LayerSetting {
    /// A message of the LSS master.
    pub(crate) fn lss_request(&mut self, now: Timestamp, request: lss::Request, events: &mut Vec<Event>) {
        self.request(now, request, events);
        if let lss::Request::SwitchSelective { part, value } = request {
            if part == lss::Part::VendorId {
                self.leave();
            }
            self.address[part as usize] = Some(value);
        }
    }

    /// A message of the LMT master.
    pub(crate) fn lmt_request(&mut self, now: Timestamp, request: lmt::Request, events: &mut Vec<Event>) {
        self.request(now, request, events);
        if let lmt::Request::SwitchSelective { .. } = request {
            self.leave();
        }
    }

    /// Handles the requests that both dialects share.
    fn request<D: Dialect>(&mut self, now: Timestamp, request: Request<D>, events: &mut Vec<Event>) {
        let unanswered = matches!(self.asked.replace((now, request.wants_answer())), Some((_, true)));
        events.push(Event::LayerSetting(Exchange::Request { unanswered }));
        match request {
            Request::SwitchGlobal { .. } => self.leave(),
            Request::ConfigureNodeId { node_id } => self.node_id.asked = Some(node_id),
            Request::ConfigureBitTiming { table, index } => {
                self.bit_rate.asked = Some(D::bit_rate(index).filter(|_| table == 0));
            }
            Request::ActivateBitTiming { delay } => self.activate(delay, events),
            _ => {}
        }
    }

    /// A message of a slave.
    pub fn response<D: Dialect>(&mut self, now: Timestamp, response: Response<D>, events: &mut Vec<Event>) {
        self.answer(now, events);
        match response {
            Response::Configured { command: ConfigureCommand::NodeId, error, .. } => self.node_id.answered(error == 0),
            Response::Configured { command: ConfigureCommand::BitTiming, error, .. } => {
                self.bit_rate.answered(error == 0);
            }
            Response::NodeId(raw) => self.told = NodeId::new(raw),
            _ => {}
        }
    }

    /// Handles the start of a node. If layer setting assigned this node-ID, the first start returns the facts about the
    /// device from the dialogue.
    pub fn started(&mut self, node: NodeId) -> Option<Before> {
        if self.node_id.confirmed != Some(node.raw()) {
            return None;
        }
        self.node_id.confirmed = None;
        Some(Before { told: self.told.take(), address: std::mem::take(&mut self.address) })
    }

    fn answer(&mut self, now: Timestamp, events: &mut Vec<Event>) {
        let exchange = match &mut self.asked {
            Some((asked, due)) => {
                // Several slaves may answer one request.
                *due = false;
                Exchange::Response(now - *asked)
            }
            None => Exchange::Unasked,
        };
        events.push(Event::LayerSetting(exchange));
    }

    /// Leaves configuration: from now on another slave may be in it. Confirmed values stay, as they take effect at the
    /// next start.
    fn leave(&mut self) {
        self.node_id.asked = None;
        self.bit_rate.asked = None;
        if self.node_id.confirmed.is_none() {
            self.told = None;
            self.address = [None; 4];
        }
    }

    fn activate(&mut self, delay: u16, events: &mut Vec<Event>) {
        let bit_rate = self.bit_rate.confirmed.take().flatten();
        events.push(Event::BitRateChanged { node: None, bit_rate, delay: Duration::from_millis(u64::from(delay)) });
    }
}

/// Facts about a device from a dialogue before the device got its node-ID.
pub struct Before {
    /// The node-ID that the device reported.
    pub told: Option<NodeId>,
    /// The LSS address by which the device was switched to configuration: the four numbers of 1018h.
    pub address: [Option<u32>; 4],
}
