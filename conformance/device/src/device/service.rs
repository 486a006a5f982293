//! What the services of a device have in common: one trait, and what they tell each other.
//!
//! A service gets the frames that are routed to it, is polled when its time has come, and hears of what happens in the
//! others. It changes itself and the [`Context`] that all share, nothing else.

use super::context::Context;
use super::nmt::{Order, Phase};
use super::routes::{Route, Routes};
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
