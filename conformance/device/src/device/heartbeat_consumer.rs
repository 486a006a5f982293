//! The heartbeat consumer (1016h): misses the nodes that it has heard once.

use super::parameters::Parameters;
use crate::Firmware;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Timestamp};

/// What is awaited of other nodes, one for each sub-index of 1016h.
#[derive(Clone, Debug)]
pub(super) struct HeartbeatConsumer {
    watched: Vec<Watched>,
}

#[derive(Clone, Copy, Debug)]
struct Watched {
    node: u8,
    /// Zero: the entry is not in use.
    time: Duration,
    /// [`Timestamp::MAX`] until the first heartbeat.
    due: Timestamp,
    lost: bool,
}

impl HeartbeatConsumer {
    /// Nobody is watched.
    pub const fn new() -> Self {
        Self { watched: Vec::new() }
    }

    /// Begins anew with the entries of 1016h.
    pub fn configure(&mut self, now: Timestamp, parameters: &Parameters, firmware: &Firmware) {
        self.watched.clear();
        let most = if firmware.consumes_from_first_only() { 1 } else { 127 };
        let entries = (1..=most).map_while(|sub| parameters.number(0x1016, sub));
        let at_once = firmware.consumes_before_first_heartbeat();
        self.watched.extend(entries.map(|entry| {
            let (node, time) = split(entry);
            let in_use = (1..=127).contains(&node) || firmware.consumes_from_everyone();
            let time = if in_use { Duration::from_millis(time) } else { Duration::ZERO };
            let due = if at_once && time > Duration::ZERO { now + time } else { Timestamp::MAX };
            Watched { node, time, due, lost: false }
        }));
    }

    /// An error control message of that node came; whether the node was missing.
    pub fn on_heartbeat(&mut self, now: Timestamp, node: u8, firmware: &Firmware) -> bool {
        let mut back = false;
        let everyone = firmware.consumes_from_everyone();
        let concerns = |watched: &&mut Watched| watched.node == node || everyone && !(1..=127).contains(&watched.node);
        for watched in self.watched.iter_mut().filter(concerns) {
            if watched.time > Duration::ZERO && (!watched.lost || firmware.rearms_consumer()) {
                watched.due = now + watched.time;
                back |= std::mem::take(&mut watched.lost);
            }
        }
        back
    }

    /// When the next node is missed.
    pub fn timeout(&self) -> Timestamp {
        self.watched.iter().map(|watched| watched.due).min().unwrap_or(Timestamp::MAX)
    }

    /// A node that is missed from now on, if there is one: called until there is none.
    pub fn poll(&mut self, now: Timestamp) -> Option<u8> {
        let watched = self.watched.iter_mut().find(|watched| now >= watched.due)?;
        watched.due = Timestamp::MAX;
        watched.lost = true;
        Some(watched.node)
    }
}

/// The node-ID (bits 16 to 23) and the time in milliseconds (bits 0 to 15).
const fn split(entry: u64) -> (u8, u64) {
    ((entry >> 16) as u8, entry & 0xFFFF)
}

/// The conditions of a write to 1016h: one entry for each node; another node only after the entry was erased.
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
    if node == 0 || time == 0 {
        return Ok(());
    }
    let others = (1..=127).filter(|&sub| sub != at.sub.0).map_while(|sub| parameters.number(0x1016, sub));
    let is_double = others.map(split).any(|(other, time)| other == node && time > 0);
    let (old, old_time) = split(parameters.number_or_zero(0x1016, at.sub.0));
    let replaces = old_time > 0 && old != 0 && old != node;
    if (is_double || replaces) && firmware.checks_consumer_entries() {
        return Err(AbortCode::PARAMETER_INCOMPATIBLE);
    }
    Ok(())
}
