//! The heartbeat consumer (1016h): detects the loss of nodes after their first heartbeat.

use super::condition::Condition;
use super::context::Context;
use super::nmt::{Order, Phase};
use super::parameters::Parameters;
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Frame, Timestamp};

/// The entries of 1016h, with the states of their nodes.
#[derive(Clone, Debug)]
pub(super) struct HeartbeatConsumer {
    watched: Vec<Watched>,
}

#[derive(Clone, Copy, Debug)]
struct Watched {
    node: u8,
    /// The consumer time; zero if the entry is not in use.
    time: Duration,
    /// The time at which the node counts as lost; [`Timestamp::MAX`] until its first heartbeat.
    due: Timestamp,
    lost: bool,
}

impl HeartbeatConsumer {
    /// A consumer without monitored nodes.
    pub const fn new() -> Self {
        Self { watched: Vec::new() }
    }

    /// Restarts with the entries of 1016h.
    fn configure(&mut self, now: Timestamp, parameters: &Parameters, firmware: &Firmware) {
        self.watched.clear();
        let most = if firmware.has(Fault::HeartbeatConsumerFirstOnly) { 1 } else { 127 };
        let entries = (1..=most).map_while(|sub| parameters.number(object::CONSUMER_HEARTBEAT_TIME, sub));
        let at_once = firmware.has(Fault::HeartbeatConsumerStartsAtOnce);
        self.watched.extend(entries.map(|entry| {
            let (node, time) = split(entry);
            let lowest = if firmware.has(Fault::HeartbeatConsumerDeafToNodeOne) { 2 } else { 1 };
            let in_use = (lowest..=127).contains(&node) || firmware.has(Fault::HeartbeatConsumerWatchesEveryone);
            let time = if in_use { Duration::from_millis(time) } else { Duration::ZERO };
            let due = if at_once && time > Duration::ZERO { now + time } else { Timestamp::MAX };
            Watched { node, time, due, lost: false }
        }));
    }

    /// Handles an error control message of a node; returns whether the node was missing.
    fn on_heartbeat(&mut self, now: Timestamp, node: u8, firmware: &Firmware) -> bool {
        let mut back = false;
        let everyone = firmware.has(Fault::HeartbeatConsumerWatchesEveryone);
        let concerns = |watched: &&mut Watched| watched.node == node || everyone && !(1..=127).contains(&watched.node);
        for watched in self.watched.iter_mut().filter(concerns) {
            let in_use = watched.time > Duration::ZERO || firmware.has(Fault::HeartbeatConsumerTimeZero);
            if in_use && (!watched.lost || !firmware.has(Fault::HeartbeatConsumerNotRearmed)) {
                watched.due = now + watched.time;
                back |= std::mem::take(&mut watched.lost);
            }
        }
        back
    }

    /// Marks a node as lost and returns it; `None` if no further node is lost. The caller repeats the call until
    /// `None`.
    fn next_lost(&mut self, now: Timestamp) -> Option<u8> {
        let watched = self.watched.iter_mut().find(|watched| now >= watched.due)?;
        watched.due = Timestamp::MAX;
        watched.lost = true;
        Some(watched.node)
    }
}

/// Whether a written entry of 1016h takes effect at once.
fn acts(at: Multiplexer, context: &Context) -> bool {
    let needs_store = context.objects.model.sheet().network.heartbeat_consumer_needs_store;
    !needs_store || context.store.number(at, &context.objects.parameters).is_some()
}

impl Service for HeartbeatConsumer {
    /// Handles an error control message of another node.
    fn handle(&mut self, now: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        let node = (frame.id().raw() & 0x7F) as u8;
        let hears = context.phase.is_running()
            && (context.phase != Phase::Stopped || !context.has(Fault::HeartbeatConsumerDeafWhenStopped));
        if hears && self.on_heartbeat(now, node, context.firmware()) {
            context.report(Condition::Heartbeat { node }, false);
        }
    }

    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Started if context.has(Fault::HeartbeatConsumerForgetsStored) => self.watched.clear(),
            Event::Started if context.has(Fault::HeartbeatConsumerOutlivesReset) => {}
            Event::Written(at, _)
                if context.has(Fault::HeartbeatConsumerRestartedByWrites)
                    && at.index.0 != object::CONSUMER_HEARTBEAT_TIME =>
            {
                self.configure(now, &context.objects.parameters, context.firmware());
            }
            Event::Started if context.has(Fault::StoredConfigurationIdle) => {}
            Event::Started => self.configure(now, &context.objects.parameters, context.firmware()),
            Event::Written(at, value) if at.index.0 == object::CONSUMER_HEARTBEAT_TIME && acts(at, context) => {
                if split(value).0 > 127 && context.has(Fault::HeartbeatConsumerHangs) {
                    context.order(Order::Hang);
                }
                self.configure(now, &context.objects.parameters, context.firmware());
            }
            _ => {}
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        while let Some(node) = self.next_lost(now) {
            if !context.takes(Liberty::LostHeartbeatUnreported) {
                context.report(Condition::Heartbeat { node }, true);
            } else {
                context.react(Condition::Heartbeat { node });
            }
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.watched.iter().map(|watched| watched.due).min().unwrap_or(Timestamp::MAX)
    }

    fn find_routes(&self, _: &Context, routes: &mut Routes) {
        for node in 1..=0x7F {
            routes.set(error_control::CAN_ID_BASE + node, Route::PeerErrorControl);
        }
    }
}

/// Splits an entry of 1016h into the node-ID (bits 16 to 23) and the time in milliseconds (bits 0 to 15).
const fn split(entry: u64) -> (u8, u64) {
    ((entry >> 16) as u8, entry & 0xFFFF)
}

/// Whether another entry of 1016h monitors a node other than `node`.
fn watches_another(at: Multiplexer, node: u8, parameters: &Parameters) -> bool {
    let others = (1..=127).filter(|&sub| sub != at.sub.0);
    let mut others = others.map_while(|sub| parameters.number(object::CONSUMER_HEARTBEAT_TIME, sub)).map(split);
    others.any(|(other, time)| other != node && time > 0)
}

/// Checks a write to 1016h: each node-ID may be in one entry only, and an entry gets another node-ID only after it was
/// erased.
///
/// # Errors
/// "General parameter incompatibility" otherwise.
pub(super) fn check(
    at: Multiplexer,
    value: u64,
    parameters: &Parameters,
    firmware: &Firmware,
) -> Result<(), AbortCode> {
    let (node, time) = split(value);
    if firmware.has(Fault::ConsumerTimeRefused) {
        return Err(AbortCode::INVALID_VALUE);
    }
    if node == 0 || time == 0 {
        return Ok(());
    }
    let others = (1..=127)
        .filter(|&sub| sub != at.sub.0)
        .map_while(|sub| parameters.number(object::CONSUMER_HEARTBEAT_TIME, sub));
    let is_double = others.map(split).any(|(other, time)| other == node && time > 0);
    if firmware.has(Fault::ConsumerEntriesExclude) && watches_another(at, node, parameters) {
        return Err(AbortCode::PARAMETER_INCOMPATIBLE);
    }
    let (old, old_time) = split(parameters.number_or_zero(object::CONSUMER_HEARTBEAT_TIME, at.sub.0));
    let replaces = old_time > 0 && old != 0 && old != node;
    if (is_double || replaces) && !firmware.has(Fault::HeartbeatConsumerDoubleAccepted) {
        return Err(AbortCode::PARAMETER_INCOMPATIBLE);
    }
    Ok(())
}
