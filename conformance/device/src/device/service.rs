//! The interface of a device's services, and the events between them.
//!
//! A service gets the frames that are routed to it and the events of the other services, and is polled at the time that
//! it names. It changes only itself and the shared [`Context`].

use super::context::Context;
use super::nmt::{Order, Phase};
use super::routes::{Route, Routes};
use canvass_analyzer::Multiplexer;
use canvass_traces::{Frame, Timestamp};

/// An event in the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Event {
    /// A reset has begun: transfers and all other work end.
    Initialise,
    /// Initialisation has given all parameters their values.
    Loaded,
    /// Initialisation is complete: the services begin to work with the loaded parameters.
    Started,
    /// The NMT state has changed.
    Entered { before: Phase },
    /// An SDO or PDO has written an object; the number is its new value.
    Written(Multiplexer, u64),
    /// Values of objects may have changed.
    Changed,
    /// SYNC was received or sent.
    Sync { counter: Option<u8> },
    /// The window of synchronous PDOs is over.
    WindowClosed,
    /// The device's silence is over. Services do not make up for work that was due meanwhile.
    Resumed,
    /// Written objects wait for their effects.
    Act,
    /// A request to the device as a whole.
    Order(Order),
}

/// One service of a device.
pub(super) trait Service {
    /// Handles a data frame that is routed to this service.
    fn handle(&mut self, _now: Timestamp, _route: Route, _frame: &Frame, _context: &mut Context) {}

    /// Handles an event of the device.
    fn on_event(&mut self, _now: Timestamp, _event: Event, _context: &mut Context) {}

    /// Does the work that is due at the time of [`Service::timeout`]. The call may also come earlier.
    fn poll(&mut self, _now: Timestamp, _context: &mut Context) {}

    /// Time of the next call of [`Service::poll`].
    fn timeout(&self, _context: &Context) -> Timestamp {
        Timestamp::MAX
    }

    /// Moves frames that may be sent now to the outbox. The device calls this after every event.
    fn transmit(&mut self, _now: Timestamp, _context: &mut Context) {}

    /// Registers the CAN-IDs of the frames that this service handles.
    fn find_routes(&self, _context: &Context, _routes: &mut Routes) {}
}
