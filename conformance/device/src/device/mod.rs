//! Simulated devices: the state machines of a CANopen device, without I/O and without a clock.
//!
//! One file for each service. `service` says what they have in common, `services` which there are and in which order they
//! are called, `context` what they share; `dispatch` is the loop over them, `lifecycle` what the device as a whole does.
//! Where firmwares differ, a service asks whether its own has the fault or takes the liberty: `context.has(Fault::…)`,
//! `context.takes(Liberty::…)`. Faults in single frames are in `mischief`, those of the object dictionary in `overlay`.

mod abort_codes;
mod application;
mod bit_rate;
mod chance;
mod checks;
mod clock;
mod condition;
mod context;
mod dispatch;
mod emcy;
mod errors;
mod guarding;
mod heartbeat;
mod heartbeat_consumer;
mod layer_setting;
mod lifecycle;
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
mod own_traffic;
mod parameters;
mod pdo;
mod routes;
mod rpdo;
mod sdo_channels;
mod sdo_server;
mod service;
mod services;
mod store;
mod storing;
mod sync;
mod time;
mod tpdo;

pub use application::{Application, ApplicationError, ApplicationErrors, Profile, Registered, Surroundings};
pub use memory::{Memory, MemoryError};
pub use motion::Motion;
pub use motion_syntax::{MotionError, MotionSpec};
pub(crate) use parameters::Content;
pub use parameters::Parameters;

use crate::Firmware;
use crate::models::Model;
use application::ErrorWatch;
use bit_rate::Activation;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::error_control::State;
use canvass_traces::Timestamp;
use condition::Condition;
use context::Context;
use emcy::EmcyService;
use guarding::NodeGuarding;
use heartbeat::HeartbeatProducer;
use heartbeat_consumer::HeartbeatConsumer;
use lmt_slave::LmtSlave;
use lss_slave::LssSlave;
use mischief::Mischief;
use nmt::NmtSlave;
use objects::Objects;
use overload::Overload;
use own_traffic::OwnTraffic;
use routes::Routes;
use rpdo::Rpdos;
use sdo_channels::SdoChannels;
use service::Event;
use services::Services;
use store::{Groups, Store};
use storing::Storing;
use sync::SyncObject;
use time::TimeService;
use tpdo::Tpdos;

/// A simulated device.
#[derive(Clone, Debug)]
pub struct Device {
    services: Services,
    context: Context,
    /// The node-ID while none is stored.
    delivered_node: Option<NodeId>,
    /// In bit/s; `None`: that of the bus.
    bit_rate: Option<u32>,
    /// The bit rate while none is stored.
    delivered_bit_rate: Option<u32>,
    activation: Option<Activation>,
    routes: Routes,
    overload: Overload,
    mischief: Mischief,
    /// Resets since power-on.
    resets: u32,
    /// A faulty firmware that does nothing any more until power-off.
    hangs: bool,
    /// When something happens next.
    wake: Timestamp,
    /// When the next thing happens that is no answer to an SDO request; [`Timestamp::ZERO`]: that is not known.
    beside_sdo: Timestamp,
}

/// The node-ID that a device without one takes its defaults from.
const PLACEHOLDER: NodeId = NodeId::MAX;

/// The position at rest of what is measured, in physical steps.
const REST_POSITION: i64 = 0x4CBA;

impl Device {
    /// A device of that model, switched on at time 0, as delivered but for its node-ID; `None`: it has none, and has
    /// to be given one by LSS. `seed` chooses what is left to chance: how response times vary.
    pub fn new(model: &Model, node: Option<NodeId>, firmware: impl Into<Firmware>, seed: u64) -> Self {
        Self::with_motion(model, node, firmware, seed, Motion::still(REST_POSITION))
    }

    /// As [`Device::new`]; what it measures moves.
    pub fn with_motion(
        model: &Model,
        node: Option<NodeId>,
        firmware: impl Into<Firmware>,
        seed: u64,
        motion: Motion,
    ) -> Self {
        let firmware = firmware.into();
        let model = &*model.taking(firmware.liberties);
        let objects = Objects::new(model, node, motion, &firmware);
        let services = Services {
            storing: Storing,
            heartbeat: HeartbeatProducer::new(),
            time: TimeService,
            sync: SyncObject::new(),
            rpdos: Rpdos::new(&objects.parameters),
            application: ErrorWatch::new(),
            tpdos: Tpdos::new(&objects.parameters),
            consumer: HeartbeatConsumer::new(),
            guarding: NodeGuarding::new(),
            emcy: EmcyService,
            sdo: SdoChannels::new(&objects, seed),
            lmt: LmtSlave::new(model.sheet().network.default_bit_rate_kbit),
            lss: LssSlave::new(),
            nmt: NmtSlave::new(),
            own_traffic: OwnTraffic::new(),
        };
        let store = Store::new(model, &objects.parameters);
        let mut device = Self {
            services,
            context: Context::new(node, objects, store),
            delivered_node: node,
            bit_rate: None,
            delivered_bit_rate: None,
            activation: None,
            routes: Routes::new(),
            overload: Overload::new(),
            mischief: Mischief::new(firmware.faults),
            resets: 0,
            hangs: false,
            wake: Timestamp::MAX,
            beside_sdo: Timestamp::ZERO,
        };
        device.initialise(Timestamp::ZERO, Groups::ALL);
        device.settle(Timestamp::ZERO);
        device
    }

    /// The node-ID in use.
    pub fn node(&self) -> Option<NodeId> {
        self.context.node
    }

    /// The NMT state; boot-up also stands for a device that has no node-ID.
    pub const fn state(&self) -> State {
        self.context.phase.state()
    }

    /// Whether the non-volatile memory is being written: power-off would lose that.
    pub fn is_storing(&self) -> bool {
        self.context.store.timeout() < Timestamp::MAX
    }

    /// The bit rate that the device would use, in kbit/s: LMT sets it. The simulated bus has one of its own.
    pub const fn bit_rate_kbit(&self) -> u32 {
        self.services.lmt.bit_rate_kbit()
    }

    /// Something in the hardware breaks, or works again: the error with that EMCY code. Error register and
    /// manufacturer-specific bytes are those of the model's sheet, where it lists the code.
    pub fn set_error(&mut self, now: Timestamp, code: EmcyCode, present: bool) {
        let model = &self.context.objects.model;
        let listed = model.sheet().emergencies.iter().find(|emergency| emergency.code() == code);
        let (register, bytes) = listed.map_or((0, [0; 5]), |listed| (listed.register(), listed.manufacturer()));
        self.context.report(Condition::Hardware { code, register, bytes }, present);
        self.follow_up(now);
        self.deliver(now, Event::Changed);
        self.settle(now);
    }

    /// Lets what is measured move so from now on; the position at time 0 is part of the motion.
    pub fn set_motion(&mut self, now: Timestamp, motion: Motion) {
        if let Some(application) = &mut self.context.objects.application {
            application.set_motion(motion);
        }
        self.services.application.watch(now, &self.context);
        self.services.tpdos.configure(now, &self.context);
        self.deliver(now, Event::Changed);
        self.settle(now);
    }
}
