//! `zencan-node` as a device: its node, and the application that its documentation requires.
//!
//! The node lives in statics that its build script makes of `zencan.toml`, so there is only one in a process. A
//! [`Zencan`] has exclusive use of it: another thread that creates one waits.

mod memory;

use crate::Stack;
use canvass_traces::{CanId, Frame, Timestamp};
use memory::{Memory, Occupied, Parts};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zencan_node::common::messages::CanMessage;
use zencan_node::{Callbacks, Node, NodeMbox};

/// The code that `zencan-build` made.
mod node {
    #![allow(missing_docs, unsafe_code, dead_code, static_mut_refs, clippy::all, clippy::pedantic)]
    zencan_node::include_modules!(ZENCAN);
}

/// The device description of the stack's object dictionary.
pub const EDS: &str = include_str!("../zencan.eds");

/// The node-ID as delivered.
pub const NODE: u8 = 10;

/// The value that stands for no node-ID.
const UNCONFIGURED: u8 = 255;

/// The serial number 1018h:04.
const SERIAL: u32 = 0x1234;

/// Period at which the application's task calls `process`, besides the calls that a message causes. The documentation's
/// example has 10 ms; the period is shorter here so that no delay is the application's fault.
const TASK_NS: u64 = 1_000_000;

/// A device with the stack `zencan-node`.
pub struct Zencan {
    memory: Arc<Memory>,
    running: Option<Running>,
    _occupied: Occupied,
}

struct Running {
    node: OwnNode,
    mbox: &'static NodeMbox,
    /// Whether the mailbox has requested a call of `process`.
    notified: Arc<AtomicBool>,
    due: Timestamp,
    /// The last values of the TPDOs' objects: the application has to report their changes.
    sent: Parts,
}

/// The node, which is not `Send` because its callbacks need not be.
struct OwnNode(Node<'static>);

// SAFETY: all other parts of a node are `Send`; its callbacks are those of `memory::callbacks`, whose closures own
// nothing but an `Arc<Memory>`, and `Memory` is `Send` and `Sync`, as `is_shareable` there demands of the compiler.
#[expect(unsafe_code, reason = "see above")]
unsafe impl Send for OwnNode {}

impl Zencan {
    /// The device as delivered, with node-ID [`NODE`].
    pub fn new() -> Self {
        Self::with_stored_node(NODE)
    }

    /// The device as delivered without a node-ID: LSS gives it one.
    pub fn unconfigured() -> Self {
        Self::with_stored_node(UNCONFIGURED)
    }

    fn with_stored_node(stored_node: u8) -> Self {
        let occupied = Occupied::wait();
        Self { memory: Arc::new(Memory::new(stored_node)), running: None, _occupied: occupied }
    }
}

impl Default for Zencan {
    fn default() -> Self {
        Self::new()
    }
}

impl Running {
    fn new(memory: &Arc<Memory>) -> Self {
        memory::as_after_power_on();
        node::OBJECT1018.set_serial(SERIAL);
        let mbox = memory::mailbox();
        let notified = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&notified);
        mbox.set_process_notify_callback(Box::leak(Box::new(move || flag.store(true, Ordering::Relaxed))));
        let callbacks: Callbacks<'static> = memory::callbacks(memory);
        let node = Node::new(memory.node_id(), callbacks, mbox, &node::NODE_STATE, &node::OD_TABLE);
        let mut running =
            Self { node: OwnNode(node), mbox, notified, due: Timestamp::ZERO, sent: memory::tpdo_values() };
        running.process(Timestamp::ZERO);
        running
    }

    fn process(&mut self, now: Timestamp) {
        self.notified.store(false, Ordering::Relaxed);
        self.node.0.process(now.nanos() / 1_000);
        let values = memory::tpdo_values();
        if values != self.sent {
            memory::set_event_flags(&values, &self.sent);
            self.sent = values;
        }
    }
}

impl Stack for Zencan {
    fn switch_on(&mut self) {
        self.running = None;
        self.running = Some(Running::new(&self.memory));
    }

    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let Some(running) = &mut self.running else { return };
        // The mailbox returns messages that it does not consume.
        let _ = running.mbox.store_message(message(frame));
        if running.notified.load(Ordering::Relaxed) {
            running.process(now);
        }
    }

    fn transmit(&mut self) -> Option<Frame> {
        let message = self.running.as_ref()?.mbox.next_transmit_message()?;
        let id = message.id();
        let id = if id.is_extended() { CanId::extended(id.raw()) } else { CanId::standard(id.raw()) };
        Frame::new(id?, message.data())
    }

    fn wake(&self) -> Option<Timestamp> {
        self.running.as_ref().map(|running| running.due)
    }

    fn tick(&mut self, now: Timestamp) {
        let Some(running) = &mut self.running else { return };
        running.due = Timestamp(now.nanos() / TASK_NS * TASK_NS + TASK_NS);
        running.process(now);
    }
}

fn message(frame: &Frame) -> CanMessage {
    use zencan_node::common::messages::CanId as Id;
    let raw = frame.id().raw();
    let id = if frame.id().is_extended() { Id::extended(raw) } else { Id::std((raw & 0x7FF) as u16) };
    if frame.is_remote() { CanMessage::new_rtr(id) } else { CanMessage::new(id, frame.data()) }
}
