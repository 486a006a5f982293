//! What a device is made of: services behind one trait, and what they tell each other.
//!
//! A service gets the frames that are routed to it, is polled when its time has come, and hears of what happens in the
//! others. It changes itself and the [`Context`] that all share, nothing else.

use super::Device;
use super::clock::TimeService;
use super::context::Context;
use super::emcy::EmcyService;
use super::guarding::NodeGuarding;
use super::heartbeat::HeartbeatProducer;
use super::heartbeat_consumer::HeartbeatConsumer;
use super::lmt_slave::LmtSlave;
use super::lss_slave::LssSlave;
use super::nmt::{NmtSlave, Order, Phase};
use super::own_traffic::OwnTraffic;
use super::routes::{Route, Routes};
use super::rpdo::Rpdos;
use super::sdo_channels::SdoChannels;
use super::shaft::Shaft;
use super::storing::Storing;
use super::sync::SyncObject;
use super::tpdo::Tpdos;
use canvass_analyzer::Multiplexer;
use canvass_traces::{Frame, Timestamp};

/// What happened in the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Event {
    /// A reset: what is under way ends.
    Initialise,
    /// Initialisation has given all parameters their values.
    Loaded,
    /// Initialisation is over: the parameters act.
    Started,
    /// The NMT state is another one than before.
    Entered { before: Phase },
    /// An object was written, by SDO or PDO, with that number.
    Written(Multiplexer, u64),
    /// Values may have changed.
    Changed,
    /// SYNC was received or sent.
    Sync { counter: Option<u8> },
    /// It is too late for synchronous PDOs.
    WindowClosed,
    /// A silence is over: what became due meanwhile is not made up for.
    Resumed,
    /// Objects were written and are to be acted on.
    Act,
    /// The device as a whole has to do something.
    Order(Order),
}

/// One service of a device.
pub(super) trait Service {
    /// A data frame that is routed to this service came.
    fn handle(&mut self, _now: Timestamp, _route: Route, _frame: &Frame, _context: &mut Context) {}

    /// Something happened in the device.
    fn on_event(&mut self, _now: Timestamp, _event: Event, _context: &mut Context) {}

    /// The time that [`Service::timeout`] named may have come.
    fn poll(&mut self, _now: Timestamp, _context: &mut Context) {}

    /// When [`Service::poll`] wants to be called next.
    fn timeout(&self, _context: &Context) -> Timestamp {
        Timestamp::MAX
    }

    /// Puts into the outbox what was to be sent and may be sent now; called after every event.
    fn transmit(&mut self, _now: Timestamp, _context: &mut Context) {}

    /// Names the CAN-IDs of the frames that it wants.
    fn find_routes(&self, _context: &Context, _routes: &mut Routes) {}
}

/// Defines the services of a device, and the loops over them. All calls go to them in the order of the rows.
macro_rules! services {
    ($($name:ident: $type:ty,)*) => {
        /// The services of a device.
        #[derive(Clone, Debug)]
        pub(super) struct Services {
            $(pub $name: $type,)*
        }

        impl Services {
            /// When the next service wants to be polled, but for SDO, of which [`SdoChannels::next`] tells.
            pub fn timeout(&self, context: &Context) -> Timestamp {
                let mut next = Timestamp::MAX;
                $(next = next.min(self.$name.timeout(context));)*
                next
            }

            /// Everything that may be sent goes into the outbox.
            pub fn transmit(&mut self, now: Timestamp, context: &mut Context) {
                $(self.$name.transmit(now, context);)*
            }

            /// The routes of all services: of two that want the same CAN-ID the later one gets it.
            pub fn find_routes(&self, context: &Context, routes: &mut Routes) {
                $(self.$name.find_routes(context, routes);)*
            }
        }

        impl Device {
            /// Tells all services what happened. What follows from it in one happens before the next is told.
            pub(super) fn deliver(&mut self, now: Timestamp, event: Event) {
                $(
                    self.services.$name.on_event(now, event, &mut self.context);
                    self.follow_up(now);
                )*
            }

            /// Polls all services.
            pub(super) fn poll_services(&mut self, now: Timestamp) {
                $(
                    self.services.$name.poll(now, &mut self.context);
                    self.follow_up(now);
                )*
            }
        }
    };
}

// The order matters:
// - what is stored or forgotten with a write comes before anybody acts on it;
// - RPDOs act before TPDOs of the same SYNC take their values, errors are found before changed values are sent;
// - EMCY goes out before SDO answers, so that a client that waits for its answer knows of the error;
// - NMT and the default SDO channel win their CAN-IDs from everything that is configured onto them.
services! {
    storing: Storing,
    heartbeat: HeartbeatProducer,
    time: TimeService,
    sync: SyncObject,
    rpdos: Rpdos,
    shaft: Shaft,
    tpdos: Tpdos,
    consumer: HeartbeatConsumer,
    guarding: NodeGuarding,
    emcy: EmcyService,
    sdo: SdoChannels,
    lmt: LmtSlave,
    lss: LssSlave,
    nmt: NmtSlave,
    own_traffic: OwnTraffic,
}
