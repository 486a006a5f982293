//! State that the services of a device share.

use super::PLACEHOLDER;
use super::condition::Condition;
use super::nmt::{Order, Phase, Service};
use super::objects::Objects;
use super::service::Event;
use super::store::Store;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::NodeId;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl};
use canvass_traces::{Frame, Timestamp};
use std::collections::VecDeque;

/// The shared state of the services, and their requests to the device.
#[derive(Clone, Debug)]
pub(super) struct Context {
    pub node: Option<NodeId>,
    pub phase: Phase,
    pub objects: Objects,
    pub store: Store,
    /// The device neither receives nor sends before this time; [`Timestamp::ZERO`] if it is not silent.
    pub silent_until: Timestamp,
    /// Frames ready to be sent.
    pub outbox: VecDeque<Frame>,
    /// Events that were not handled yet.
    pub events: VecDeque<Event>,
    /// Whether COB-IDs have changed.
    pub routes_changed: bool,
    /// Whether the window of synchronous PDOs has closed.
    pub sync_closed: bool,
    /// Whether the next start of a faulty firmware will fail.
    pub breaks_next_start: bool,
    /// Whether the last start of a faulty firmware has failed: the device does not enter operational.
    pub refuses_operational: bool,
    /// Whether the device sends heartbeats; it then does not answer node guarding.
    pub is_heartbeat_active: bool,
}

/// Maximum number of waiting frames: a device that can't send loses all further frames.
const LONGEST_OUTBOX: usize = 256;

impl Context {
    /// The context before the first start of the device.
    pub fn new(node: Option<NodeId>, objects: Objects, store: Store) -> Self {
        Self {
            node,
            phase: Phase::Unconfigured,
            objects,
            store,
            silent_until: Timestamp::ZERO,
            outbox: VecDeque::with_capacity(LONGEST_OUTBOX),
            events: VecDeque::with_capacity(8),
            routes_changed: false,
            sync_closed: false,
            breaks_next_start: false,
            refuses_operational: false,
            is_heartbeat_active: false,
        }
    }

    /// Handles a reset: drops waiting frames and events.
    pub fn clear(&mut self) {
        self.outbox.clear();
        self.objects.written.clear();
        self.objects.wedged = false;
        self.objects.drop_waiting();
        self.silent_until = Timestamp::ZERO;
    }

    /// The faults and liberties of the firmware.
    pub const fn firmware(&self) -> &Firmware {
        &self.objects.firmware
    }

    /// Whether the firmware has this fault.
    pub const fn has(&self, fault: Fault) -> bool {
        self.objects.has(fault)
    }

    /// Whether the firmware takes this liberty.
    pub const fn takes(&self, liberty: Liberty) -> bool {
        self.objects.takes(liberty)
    }

    /// The node-ID from which default COB-IDs are calculated.
    pub(crate) fn node_or_placeholder(&self) -> NodeId {
        self.node.unwrap_or(PLACEHOLDER)
    }

    /// Whether a service works in the current state.
    pub fn serves(&self, service: Service) -> bool {
        self.phase.serves(service, self.firmware())
    }

    /// Sends a frame.
    pub fn send(&mut self, frame: Frame) {
        if self.outbox.len() < LONGEST_OUTBOX {
            self.outbox.push_back(frame);
        }
    }

    /// Sends an error control message.
    pub(crate) fn send_error_control(&mut self, message: ErrorControl) {
        if let Some(node) = self.node {
            self.send(message.to_frame(error_control::CAN_ID_BASE + u16::from(node.raw())));
        }
    }

    /// Queues a request to the device as a whole.
    pub fn order(&mut self, order: Order) {
        self.events.push_back(Event::Order(order));
    }

    /// Sets or clears an error condition, and reacts to its change.
    pub fn report(&mut self, condition: Condition, present: bool) {
        let reacts_to_return = self.firmware().has(Fault::ConsumerReturnLeaves);
        let next = if self.objects.errors.set(condition, present) && (present || reacts_to_return) {
            self.reaction(condition)
        } else {
            None
        };
        if next.unwrap_or(self.phase) == Phase::Stopped {
            self.objects.errors.on_stopped();
        }
        next.into_iter().for_each(|phase| self.order(Order::Enter(phase)));
    }

    /// Reacts to a present condition as [`Context::report`] does, but without an EMCY.
    pub fn react(&mut self, condition: Condition) {
        self.reaction(condition).into_iter().for_each(|phase| self.order(Order::Enter(phase)));
    }

    /// The NMT state after an error, by 1029h. Without 1029h:01 the device leaves operational when the master or a
    /// monitored node is missing.
    fn reaction(&self, condition: Condition) -> Option<Phase> {
        let firmware = self.firmware();
        let sub = condition.behaviour().filter(|_| !firmware.has(Fault::ErrorBehaviourIgnored))?;
        if sub == 2 && firmware.has(Fault::ProfileErrorIgnored) {
            return None;
        }
        let leaves_stopped = self.phase == Phase::Stopped && firmware.has(Fault::ErrorBehaviourLeavesStopped);
        let behaviour = match self.objects.parameters.number(object::ERROR_BEHAVIOR, sub) {
            Some(1) if sub == 2 && firmware.has(Fault::ProfileErrorAlwaysLeaves) => Some(0),
            behaviour => behaviour.or((sub == 1).then_some(0)),
        };
        match behaviour {
            Some(0) if self.phase == Phase::Operational || leaves_stopped => Some(Phase::PreOperational),
            Some(2) if self.phase.is_running() => Some(Phase::Stopped),
            _ => None,
        }
    }
}
