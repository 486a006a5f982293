//! The services of a device, and the order of their calls.

use super::Device;
use super::application::ErrorWatch;
use super::context::Context;
use super::emcy::EmcyService;
use super::guarding::NodeGuarding;
use super::heartbeat::HeartbeatProducer;
use super::heartbeat_consumer::HeartbeatConsumer;
use super::lmt_slave::LmtSlave;
use super::lss_slave::LssSlave;
use super::nmt::NmtSlave;
use super::own_traffic::OwnTraffic;
use super::routes::Routes;
use super::rpdo::Rpdos;
use super::sdo_channels::SdoChannels;
use super::service::{Event, Service};
use super::storing::Storing;
use super::sync::SyncObject;
use super::time::TimeService;
use super::tpdo::Tpdos;
use canvass_traces::Timestamp;

/// Defines the services of a device, and the loops over them in the order of the rows.
macro_rules! services {
    ($($name:ident: $type:ty,)*) => {
        /// The services of a device.
        #[derive(Clone, Debug)]
        pub(super) struct Services {
            $(pub $name: $type,)*
        }

        impl Services {
            /// Time of the next poll of any service except SDO; [`SdoChannels::next`] gives the time of SDO.
            pub fn timeout(&self, context: &Context) -> Timestamp {
                let mut next = Timestamp::MAX;
                $(next = next.min(self.$name.timeout(context));)*
                next
            }

            /// Moves all frames that may be sent to the outbox.
            pub fn transmit(&mut self, now: Timestamp, context: &mut Context) {
                $(self.$name.transmit(now, context);)*
            }

            /// Registers the routes of all services. If two services claim the same CAN-ID, [`Routes`] decides.
            pub(crate) fn find_routes(&self, context: &Context, routes: &mut Routes) {
                $(self.$name.find_routes(context, routes);)*
            }
        }

        impl Device {
            /// Delivers an event to all services. The consequences in one service happen before the next service gets
            /// the event.
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
// - `storing` comes first, so that stored and erased values are settled before a service acts on a write;
// - RPDOs act before TPDOs of the same SYNC take their values, and errors are found before changed values are sent;
// - EMCY goes out before SDO answers, so that a client that waits for its answer knows of the error;
// - NMT and the default SDO channel get the frames of their CAN-IDs, whatever else is configured to the same CAN-ID.
services! {
    storing: Storing,
    heartbeat: HeartbeatProducer,
    time: TimeService,
    sync: SyncObject,
    rpdos: Rpdos,
    application: ErrorWatch,
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
