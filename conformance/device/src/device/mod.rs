//! Simulated devices: the state machines of a CANopen device, without I/O and clock.
//!
//! Each service is one file. `service` defines the interface of the services, `services` lists them in the order of
//! calls, `context` holds their shared state; `dispatch` is the loop over them, `lifecycle` the behaviour of the whole
//! device. A service asks the firmware for a fault or liberty at the place where the fault or liberty acts:
//! `context.has(Fault::…)`, `context.takes(Liberty::…)`. Faults in single frames are in `mischief`, faults of the
//! object dictionary in `overlay`.

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
    /// The node-ID that the device uses while none is stored.
    delivered_node: Option<NodeId>,
    /// The bit rate in bit/s; `None` if the device has the bit rate of the bus.
    bit_rate: Option<u32>,
    /// The bit rate that the device uses while none is stored.
    delivered_bit_rate: Option<u32>,
    activation: Option<Activation>,
    routes: Routes,
    overload: Overload,
    mischief: Mischief,
    /// Number of resets since power-on.
    resets: u32,
    /// Whether a faulty firmware hangs until power-off.
    hangs: bool,
    /// Time of the next event.
    wake: Timestamp,
    /// Time of the next event other than an SDO answer; [`Timestamp::ZERO`] if it must be recomputed.
    beside_sdo: Timestamp,
}

/// The node-ID from which a device without node-ID calculates its default COB-IDs.
const PLACEHOLDER: NodeId = NodeId::MAX;

/// The position at rest of the measured quantity, in physical steps.
const REST_POSITION: i64 = 0x4CBA;

impl Device {
    /// A device of a model as delivered, switched on at time 0. `node` is its node-ID; `None` if LSS must assign one.
    /// `seed` determines random response times.
    pub fn new(model: &Model, node: Option<NodeId>, firmware: impl Into<Firmware>, seed: u64) -> Self {
        Self::with_motion(model, node, firmware, seed, &Motion::still(REST_POSITION))
    }

    /// As [`Device::new`], with a motion of the measured quantity.
    pub fn with_motion(
        model: &Model,
        node: Option<NodeId>,
        firmware: impl Into<Firmware>,
        seed: u64,
        motion: &Motion,
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
            lmt: LmtSlave::new(),
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

    /// The current node-ID.
    pub fn node(&self) -> Option<NodeId> {
        self.context.node
    }

    /// The NMT state; a device without node-ID is in boot-up.
    pub const fn state(&self) -> State {
        self.context.phase.state()
    }

    /// Whether the non-volatile memory is being written, so that power-off would lose data.
    pub fn is_storing(&self) -> bool {
        self.context.store.timeout() < Timestamp::MAX
    }

    /// Sets or clears a hardware error with this EMCY code. The model's sheet lists EMCY codes with their error
    /// register and manufacturer-specific bytes.
    pub fn set_error(&mut self, now: Timestamp, code: EmcyCode, present: bool) {
        let model = &self.context.objects.model;
        let listed = model.sheet().emergencies.iter().find(|emergency| emergency.code() == code);
        let (register, bytes) = listed.map_or((0, [0; 5]), |listed| (listed.register(), listed.manufacturer()));
        self.context.report(Condition::Hardware { code, register, bytes }, present);
        self.follow_up(now);
        self.deliver(now, Event::Changed);
        self.settle(now);
    }

    /// Sets the motion of the measured quantity from now on. The motion includes the position at time 0.
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
