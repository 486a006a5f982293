//! Simulated devices: the state machines of a CANopen device, without I/O and without a clock.
//!
//! One file for each service. This one only puts them together; which frame goes to which service is in `dispatch`,
//! which service works in which state in `nmt` and `lifecycle`, what a written object changes in `reactions`.

mod bit_rate;
mod checks;
mod clock;
mod dispatch;
mod emcy;
mod encoder;
mod firmware;
mod guarding;
mod heartbeat;
mod heartbeat_consumer;
mod lifecycle;
mod limit_switches;
mod links;
mod lmt_slave;
mod lss_slave;
mod memory;
mod mischief;
mod motion;
mod motion_syntax;
mod nmt;
mod objects;
mod overlay;
mod overload;
mod parameters;
mod pdo;
mod reactions;
mod routes;
mod rpdo;
mod sdo_server;
mod second_sdo;
mod store;
mod sync;
mod tpdo;

pub use memory::{Memory, MemoryError};
pub use motion::Motion;
pub use motion_syntax::{MotionError, MotionSpec};

use crate::Firmware;
use crate::models::Model;
use bit_rate::Activation;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::error_control::State;
use canvass_traces::{Frame, Timestamp};
use emcy::Condition;
use guarding::NodeGuarding;
use heartbeat::HeartbeatProducer;
use heartbeat_consumer::HeartbeatConsumer;
use lmt_slave::LmtSlave;
use lss_slave::LssSlave;
use mischief::Mischief;
use nmt::Phase;
use objects::Objects;
use overload::Overload;
use routes::Routes;
use rpdo::Rpdo;
use sdo_server::SdoServer;
use second_sdo::SecondSdo;
use std::collections::VecDeque;
use store::{Groups, Store};
use sync::SyncObject;
use tpdo::Tpdo;

/// A simulated device.
#[derive(Clone, Debug)]
pub struct Device {
    node: Option<NodeId>,
    /// The node-ID while none is stored.
    delivered_node: Option<NodeId>,
    /// In bit/s; `None`: that of the bus.
    bit_rate: Option<u32>,
    /// The bit rate while none is stored.
    delivered_bit_rate: Option<u32>,
    activation: Option<Activation>,
    phase: Phase,
    firmware: Firmware,
    objects: Objects,
    store: Store,
    sdo: SdoServer,
    second_sdos: Vec<SecondSdo>,
    heartbeat: HeartbeatProducer,
    consumer: HeartbeatConsumer,
    guarding: NodeGuarding,
    sync: SyncObject,
    tpdos: Vec<Tpdo>,
    rpdos: Vec<Rpdo>,
    lss: LssSlave,
    /// When it is seen next whether the shaft is too fast.
    shaft_due: Timestamp,
    lmt: LmtSlave,
    /// Until then the device neither hears nor sends anything; [`Timestamp::ZERO`]: it works.
    silent_until: Timestamp,
    routes: Routes,
    overload: Overload,
    mischief: Mischief,
    /// When the last NMT command came.
    last_command: Option<Timestamp>,
    /// Resets since power-on.
    resets: u32,
    /// A faulty firmware that does nothing any more until power-off.
    hangs: bool,
    /// What is ready to be sent.
    outbox: VecDeque<Frame>,
    /// When something happens next.
    wake: Timestamp,
    /// When the next thing happens that is no answer to an SDO request; [`Timestamp::ZERO`]: that is not known.
    beside_sdo: Timestamp,
}

/// More frames than that don't wait: a device that can't get rid of its frames loses them.
const LONGEST_OUTBOX: usize = 256;

/// The node-ID that a device without one takes its defaults from.
const PLACEHOLDER: NodeId = NodeId::MAX;

/// The position of a shaft that nobody turns, in physical steps.
const REST_POSITION: i64 = 0x4CBA;

impl Device {
    /// A device of that model, switched on at time 0, as delivered but for its node-ID; `None`: it has none, and has
    /// to be given one by LSS. `seed` chooses what is left to chance: how response times vary.
    pub fn new(model: &Model, node: Option<NodeId>, firmware: impl Into<Firmware>, seed: u64) -> Self {
        Self::with_motion(model, node, firmware, seed, Motion::still(REST_POSITION))
    }

    /// As [`Device::new`], with a shaft that moves.
    pub fn with_motion(
        model: &Model,
        node: Option<NodeId>,
        firmware: impl Into<Firmware>,
        seed: u64,
        motion: Motion,
    ) -> Self {
        let firmware = firmware.into();
        let sheet = model.sheet();
        let objects = Objects::new(model, node, motion, &firmware);
        let blocks = sheet.network.sdo_block_transfer;
        let mut device = Self {
            node,
            delivered_node: node,
            bit_rate: None,
            delivered_bit_rate: None,
            activation: None,
            phase: Phase::Unconfigured,
            firmware,
            store: Store::new(model, &objects.parameters),
            sdo: SdoServer::new(sheet.timing, blocks, seed),
            second_sdos: SecondSdo::all(&objects, sheet.timing, blocks, seed),
            heartbeat: HeartbeatProducer::new(),
            consumer: HeartbeatConsumer::new(),
            guarding: NodeGuarding::new(),
            sync: SyncObject::new(&firmware),
            tpdos: Tpdo::all(&objects.parameters),
            rpdos: Rpdo::all(&objects.parameters, &firmware),
            lss: LssSlave::new(),
            shaft_due: Timestamp::MAX,
            lmt: LmtSlave::new(sheet.network.default_bit_rate_kbit),
            silent_until: Timestamp::ZERO,
            routes: Routes::new(),
            mischief: Mischief::new(firmware.faults),
            overload: Overload::new(),
            last_command: None,
            resets: 0,
            hangs: false,
            outbox: VecDeque::with_capacity(LONGEST_OUTBOX),
            wake: Timestamp::MAX,
            beside_sdo: Timestamp::ZERO,
            objects,
        };
        device.initialise(Timestamp::ZERO, Groups::ALL);
        device.settle(Timestamp::ZERO);
        device
    }

    /// The node-ID in use.
    pub fn node(&self) -> Option<NodeId> {
        self.node
    }

    /// The NMT state; boot-up also stands for a device that has no node-ID.
    pub const fn state(&self) -> State {
        self.phase.state()
    }

    /// Whether the non-volatile memory is being written: power-off would lose that.
    pub fn is_storing(&self) -> bool {
        self.store.timeout() < Timestamp::MAX
    }

    /// The bit rate that the device would use, in kbit/s: LMT sets it. The simulated bus has one of its own.
    pub const fn bit_rate_kbit(&self) -> u32 {
        self.lmt.bit_rate_kbit()
    }

    /// Something in the hardware breaks, or works again: the error with that EMCY code. Error register and
    /// manufacturer-specific bytes are those of the model's sheet, where it lists the code.
    pub fn set_error(&mut self, now: Timestamp, code: EmcyCode, present: bool) {
        let listed = self.objects.model.sheet().emergencies.iter().find(|emergency| emergency.code() == code);
        let (register, bytes) = listed.map_or((0, [0; 5]), |listed| (listed.register(), listed.manufacturer()));
        self.report(now, Condition::Hardware { code, register, bytes }, present);
        self.after_change(now);
        self.settle(now);
    }

    /// Lets the shaft move so from now on; the position at time 0 is part of the motion.
    pub fn set_motion(&mut self, now: Timestamp, motion: Motion) {
        if let Some(encoder) = &mut self.objects.encoder {
            encoder.set_motion(motion);
        }
        self.watch_shaft(now);
        self.configure_tpdos(now);
        self.after_change(now);
        self.settle(now);
    }
}

fn push(outbox: &mut VecDeque<Frame>, frame: Frame) {
    if outbox.len() < LONGEST_OUTBOX {
        outbox.push_back(frame);
    }
}
