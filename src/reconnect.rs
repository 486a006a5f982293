//! `--reconnect-timeout`: how long to wait for an interrupted bus.

use crate::interrupt::Interrupt;
use crate::live::parse_span;
use crate::status::Status;
use canvass_bus::{Bus, Endurance, Interruptions};
use canvass_traces::Duration;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Default: some gateways take a minute and a half to restart.
pub const RECONNECT: Duration = Duration::from_secs(120);

/// The option `--reconnect-timeout`.
#[derive(Clone, Copy, clap::Args)]
pub struct ReconnectArg {
    /// Maximum time to wait for the bus after an interruption, such as an unplugged adapter, a lost connection or an
    /// interface that is down
    #[arg(long, default_value = "2min", value_name = "SPAN", value_parser = parse_span)]
    reconnect_timeout: Duration,
}

impl ReconnectArg {
    /// The endurance that waits for this time, or until the user ends the wait.
    pub fn endurance(self, interrupt: &Interrupt) -> Endurance {
        self.until(None, interrupt.flag())
    }

    /// The endurance that waits until this moment, or until the user ends the wait.
    pub const fn until(self, ends: Option<Instant>, cancelled: Arc<AtomicBool>) -> Endurance {
        Endurance { patience: self.reconnect_timeout, ends, cancelled }
    }
}

/// Number and duration of the interruptions of a bus; `None` if there were none.
pub fn interruptions(bus: &dyn Bus) -> Option<Interruptions> {
    bus.health().interruptions(bus.now())
}

/// The exit status of a command that only listens, which would otherwise be `status`. A bus that did not come back is
/// an error, except on `slcan:listen://`: its client may disconnect at any time.
pub fn status_of_listener(address: &str, interruptions: Option<&Interruptions>, status: Status) -> Status {
    let is_lost = interruptions.is_some_and(|interruptions| !interruptions.is_over);
    let may_leave = address.starts_with("slcan:listen://");
    if is_lost && !may_leave && status == Status::Good { Status::Unreachable } else { status }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bus_that_is_not_back_is_an_error() {
        let of = |address, is_over, status| {
            let interruptions = Interruptions { count: 1, lasted: Duration::from_secs(1), last: None, is_over };
            status_of_listener(address, Some(&interruptions), status)
        };
        assert_eq!(of("can0", false, Status::Good), Status::Unreachable);
        assert_eq!(of("can0", true, Status::Good), Status::Good);
        assert_eq!(of("can0", false, Status::Findings), Status::Findings);
        assert_eq!(of("slcan:listen://2000", false, Status::Good), Status::Good);
        assert_eq!(status_of_listener("can0", None, Status::Good), Status::Good);
    }
}
