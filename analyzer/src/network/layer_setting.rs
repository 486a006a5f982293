//! What the dialogues of LSS and LMT set: node-IDs and bit rates that devices will use.

use super::event::{Event, Exchange};
use crate::NodeId;
use crate::wire::{lmt, lss};
use canvass_traces::{Duration, Timestamp};

/// The layer setting of one bus, as far as it has come.
#[derive(Clone, Default)]
pub struct LayerSetting {
    /// When the master asked last, and whether an answer is due.
    asked: Option<(Timestamp, bool)>,
    node_id: Setting<u8>,
    bit_rate: Setting<Option<u32>>,
    /// The node-ID that the slave in configuration has told.
    told: Option<NodeId>,
    /// The LSS address of the slave that was switched to configuration.
    address: [Option<u32>; 4],
}

/// A value that the master has asked for, until the slave has confirmed it, and then until it takes effect.
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
    pub fn lss_request(&mut self, now: Timestamp, request: lss::Request, events: &mut Vec<Event>) {
        use lss::Request as R;
        let due = match request {
            R::ConfigureNodeId { .. } | R::ConfigureBitTiming { .. } | R::StoreConfiguration => true,
            R::Inquire { .. } | R::InquireNodeId => true,
            R::SwitchSelective { part, .. } => part == lss::Part::SerialNumber,
            _ => false,
        };
        self.ask(now, due, events);
        match request {
            R::SwitchGlobal { .. } => self.leave(),
            R::SwitchSelective { part, value } => {
                if part == lss::Part::VendorId {
                    self.leave();
                }
                self.address[part as usize] = Some(value);
            }
            R::ConfigureNodeId { node_id } => self.node_id.asked = Some(node_id),
            R::ConfigureBitTiming { table, index } => {
                let known = lss::BIT_RATES.get(usize::from(index)).filter(|_| table == 0);
                self.bit_rate.asked = Some(known.copied().flatten());
            }
            R::ActivateBitTiming { delay } => self.activate(delay, events),
            _ => {}
        }
    }

    /// A message of an LSS slave.
    pub fn lss_response(&mut self, now: Timestamp, response: lss::Response, events: &mut Vec<Event>) {
        self.answer(now, events);
        match response {
            lss::Response::Configured { command: lss::ConfigureCommand::NodeId, error, .. } => {
                self.node_id.answered(error == 0);
            }
            lss::Response::Configured { command: lss::ConfigureCommand::BitTiming, error, .. } => {
                self.bit_rate.answered(error == 0);
            }
            lss::Response::NodeId(raw) => self.told = NodeId::new(raw),
            _ => {}
        }
    }

    /// A message of the LMT master.
    pub fn lmt_request(&mut self, now: Timestamp, request: lmt::Request, events: &mut Vec<Event>) {
        use lmt::Request as R;
        let due = matches!(
            request,
            R::ConfigureNmtAddress { .. } | R::ConfigureBitTiming { .. } | R::StoreConfiguration | R::Inquire { .. }
        );
        self.ask(now, due, events);
        match request {
            R::SwitchGlobal { .. } | R::SwitchSelective { .. } => self.leave(),
            R::ConfigureNmtAddress { node_id } => self.node_id.asked = Some(node_id),
            R::ConfigureBitTiming { table, index } => {
                let known = lmt::BIT_RATES.get(usize::from(index)).filter(|_| table == 0);
                self.bit_rate.asked = Some(known.copied());
            }
            R::ActivateBitTiming { delay } => self.activate(delay, events),
            _ => {}
        }
    }

    /// A message of an LMT slave.
    pub fn lmt_response(&mut self, now: Timestamp, response: lmt::Response, events: &mut Vec<Event>) {
        self.answer(now, events);
        match response {
            lmt::Response::Configured { command: lmt::ConfigureCommand::NmtAddress, error, .. } => {
                self.node_id.answered(error == 0);
            }
            lmt::Response::Configured { command: lmt::ConfigureCommand::BitTiming, error, .. } => {
                self.bit_rate.answered(error == 0);
            }
            _ => {}
        }
    }

    /// A node has started: where layer setting gave it this node-ID, what is known of it before, once.
    pub fn started(&mut self, node: NodeId) -> Option<Before> {
        if self.node_id.confirmed != Some(node.raw()) {
            return None;
        }
        self.node_id.confirmed = None;
        Some(Before { told: self.told.take(), address: std::mem::take(&mut self.address) })
    }

    fn ask(&mut self, now: Timestamp, due: bool, events: &mut Vec<Event>) {
        let unanswered = matches!(self.asked.replace((now, due)), Some((_, true)));
        events.push(Event::LayerSetting(Exchange::Request { unanswered }));
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

    /// Another slave may be in configuration from here on. What was confirmed stays: it takes effect at the next start.
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

/// What a dialogue has told of a device before it got its node-ID.
pub struct Before {
    /// The node-ID that it told.
    pub told: Option<NodeId>,
    /// The LSS address by which it was switched to configuration: the four numbers of 1018h.
    pub address: [Option<u32>; 4],
}
