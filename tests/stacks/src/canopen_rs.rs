//! `canopen-rs` as a device: its node, and the application that its documentation requires.
//!
//! The crate leaves to the application: timers (heartbeat, event timer), reactions to a reset, guarding requests, SYNC
//! reception, events of PDOs, non-volatile memory. This application follows the documentation and does nothing more:
//! decisions of the crate stay as they are.

mod objects;

use crate::Stack;
use canopen_rs::lss::{LSS_MASTER_COB_ID, LssState, UNCONFIGURED_NODE_ID};
use canopen_rs::nmt::NMT_COMMAND_COB_ID;
use canopen_rs::node::TxFrame;
use canopen_rs::sync::SYNC_COB_ID;
use canopen_rs::{Address, NmtState, Node, NodeId, ObjectDictionary, Value};
use canvass_traces::{CanId, Duration, Frame, Timestamp};
use objects::{CAPACITY, IDENTITY, dictionary};
use std::collections::VecDeque;

/// The device description of the stack's object dictionary.
pub const EDS: &str = include_str!("../canopen-rs.eds");

/// The node-ID as delivered.
pub const NODE: u8 = 9;

/// The LSS request "store configuration".
const STORE_CONFIGURATION: u8 = 0x17;

/// NMT reset communication: the application's objects stay.
const RESET_COMMUNICATION: u8 = 0x82;

/// A device with the stack `canopen-rs`.
pub struct CanopenRs {
    /// The node-ID in non-volatile memory; 255: none.
    stored_node: u8,
    node: Node<CAPACITY>,
    outbox: VecDeque<Frame>,
    /// Whether a reset has restarted the CAN controller, which empties its mailboxes.
    emptied: bool,
    heartbeat: Option<Heartbeat>,
    /// The last frame of each PDO: a PDO of type 254 or 255 is sent when its values change.
    sent: [Option<TxFrame>; TPDOS],
}

const TPDOS: usize = 2;

struct Heartbeat {
    period: Duration,
    due: Timestamp,
}

impl CanopenRs {
    /// The device as delivered, with node-ID [`NODE`].
    pub fn new() -> Self {
        Self::with_stored_node(NODE)
    }

    /// The device as delivered without a node-ID: LSS gives it one.
    pub fn unconfigured() -> Self {
        Self::with_stored_node(UNCONFIGURED_NODE_ID)
    }

    fn with_stored_node(stored_node: u8) -> Self {
        let node = Node::new(placeholder(), ObjectDictionary::new());
        Self { stored_node, node, outbox: VecDeque::new(), emptied: false, heartbeat: None, sent: [None; TPDOS] }
    }

    /// Makes the node with this node-ID; if the node-ID is not valid, with LSS alone.
    fn initialise(&mut self, now: Timestamp, node_id: u8, kept: Option<&ObjectDictionary<CAPACITY>>) {
        let id = NodeId::new(node_id).ok();
        let mut objects = dictionary(id.unwrap_or_else(placeholder));
        if let Some(kept) = kept {
            objects::keep_application(&mut objects, kept);
        }
        self.node = Node::new(id.unwrap_or_else(placeholder), objects);
        self.outbox.clear();
        self.emptied = true;
        self.heartbeat = None;
        self.sent = [None; TPDOS];
        match id {
            Some(_) => {
                self.node.enable_lss(IDENTITY);
                self.node.configure_pdos_from_od();
                let boot_up = self.node.boot();
                self.send(&boot_up);
                self.set_heartbeat(now);
            }
            None => self.node.enable_lss_unconfigured(IDENTITY),
        }
    }

    fn send(&mut self, frame: &TxFrame) {
        self.outbox.extend(CanId::standard(u32::from(frame.cob_id)).and_then(|id| Frame::new(id, frame.data())));
    }

    /// Starts the heartbeat timer, which runs from the time at which the period was set, or from the boot-up message.
    fn set_heartbeat(&mut self, now: Timestamp) {
        let period = match self.node.od().read(Address::new(0x1017, 0)) {
            Ok(Value::Unsigned16(milliseconds)) => Duration::from_millis(u64::from(milliseconds)),
            _ => Duration::from_millis(0),
        };
        self.heartbeat = (period.nanos() > 0).then(|| Heartbeat { period, due: now + period });
    }

    /// Handles a data frame with an 11-bit CAN-ID.
    fn receive(&mut self, now: Timestamp, cob_id: u16, data: &[u8]) {
        let was_unconfigured = self.is_unconfigured();
        let before = self.node.state();
        if let Some(response) = self.node.on_frame(cob_id, data) {
            self.send(&response);
        }
        if cob_id == LSS_MASTER_COB_ID {
            self.after_lss(now, data, was_unconfigured);
        } else if cob_id == SYNC_COB_ID {
            let frames = self.node.sync_tpdos();
            frames.iter().for_each(|frame| self.send(frame));
        } else if cob_id == NMT_COMMAND_COB_ID {
            self.after_nmt(now, data, before);
        }
        self.after_write(now);
        self.send_changed(false);
    }

    fn is_unconfigured(&self) -> bool {
        self.node.lss().is_some_and(|lss| lss.node_id() == UNCONFIGURED_NODE_ID)
    }

    /// Completes an NMT command. The stack is initialising after both resets; the application distinguishes them by the
    /// command.
    fn after_nmt(&mut self, now: Timestamp, data: &[u8], before: NmtState) {
        if self.is_unconfigured() {
            return;
        }
        match self.node.state() {
            NmtState::Initialising if data.first() == Some(&RESET_COMMUNICATION) => self.reset_communication(now),
            NmtState::Initialising => self.initialise(now, self.stored_node, None),
            NmtState::Operational if before != NmtState::Operational => self.send_changed(true),
            _ => {}
        }
    }

    /// Resets the communication: the pending node-ID comes into force, the communication objects become as delivered,
    /// and the other objects stay.
    fn reset_communication(&mut self, now: Timestamp) {
        let pending = self.node.lss().map_or(self.node.node_id().raw(), |lss| lss.pending_node_id());
        let kept = std::mem::replace(&mut self.node, Node::new(placeholder(), ObjectDictionary::new()));
        self.initialise(now, pending, Some(kept.od()));
    }

    /// Completes an LSS request: the application stores the node-ID, and starts an unconfigured node that got its
    /// node-ID.
    fn after_lss(&mut self, now: Timestamp, data: &[u8], was_unconfigured: bool) {
        let Some(lss) = self.node.lss() else { return };
        let (state, pending) = (lss.state(), lss.pending_node_id());
        if data.first() == Some(&STORE_CONFIGURATION) && state == LssState::Configuration {
            self.stored_node = pending;
        }
        if was_unconfigured && state == LssState::Waiting && pending != UNCONFIGURED_NODE_ID {
            self.initialise(now, pending, None);
        }
    }

    /// Reacts to an object written by SDO.
    fn after_write(&mut self, now: Timestamp) {
        let Some(written) = self.node.take_written_object() else { return };
        match written.index {
            0x1400..=0x1BFF => self.node.configure_pdos_from_od(),
            0x1017 => self.set_heartbeat(now),
            // The documentation says: "A master writes 0 to clear". `clear_errors` is the stack's only way to empty the
            // list.
            0x1003 => {
                self.node.clear_errors();
            }
            _ => {}
        }
    }

    /// Sends the event-driven PDOs whose values have changed, or all of them.
    fn send_changed(&mut self, all: bool) {
        if self.node.state() != NmtState::Operational {
            return;
        }
        for (slot, number) in objects::valid_tpdos(self.node.od()).into_iter().enumerate() {
            let frame = self.node.tpdo(slot);
            let is_new = frame.is_some() && frame != self.sent[number];
            self.sent[number] = frame;
            if let (true, true, Some(frame)) = (all || is_new, objects::is_event_driven(self.node.od(), number), frame)
            {
                self.send(&frame);
            }
        }
    }
}

impl Default for CanopenRs {
    fn default() -> Self {
        Self::new()
    }
}

/// A node-ID for a node that has none yet. The documentation says: "Construct the node with any placeholder id".
fn placeholder() -> NodeId {
    NodeId::BROADCAST
}

impl Stack for CanopenRs {
    fn switch_on(&mut self) {
        self.initialise(Timestamp::ZERO, self.stored_node, None);
    }

    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let Some(cob_id) = frame.id().as_standard() else { return };
        if !frame.is_remote() {
            return self.receive(now, cob_id, frame.data());
        }
        // Guarding is for devices that don't send heartbeats.
        let is_guarding = cob_id == 0x700 + u16::from(self.node.node_id().raw());
        if is_guarding && self.heartbeat.is_none() && !self.is_unconfigured() {
            let answer = self.node.node_guard_response();
            self.send(&answer);
        }
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.emptied = false;
        self.outbox.pop_front()
    }

    fn has_emptied_mailboxes(&self) -> bool {
        self.emptied
    }

    fn wake(&self) -> Option<Timestamp> {
        self.heartbeat.as_ref().map(|heartbeat| heartbeat.due)
    }

    fn tick(&mut self, now: Timestamp) {
        let Some(heartbeat) = self.heartbeat.as_mut().filter(|heartbeat| heartbeat.due <= now) else { return };
        heartbeat.due += heartbeat.period;
        let frame = self.node.heartbeat();
        self.send(&frame);
    }
}
