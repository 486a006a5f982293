//! The kernel's data about CAN interfaces, from rtnetlink. `/sys/class/net` gives the data that the crate does not
//! read.

use socketcan::nl::{CanInterface, CanState, Mtu};
use std::fmt;
use std::fs;
use std::io;
use std::path::Path;
use std::str::FromStr;

/// The type of CAN interfaces in `/sys/class/net/*/type`, `ARPHRD_CAN`.
const CAN: u32 = libc::ARPHRD_CAN as u32;

/// A network interface, with its CAN properties.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Link {
    /// The index of the interface, by which sockets are bound to it.
    pub index: u32,
    /// Whether the interface is a CAN interface.
    pub is_can: bool,
    /// Whether the interface is up.
    pub is_up: bool,
    /// Whether the interface supports CAN FD.
    pub is_fd: bool,
    /// Capacity of the transmit queue, in frames.
    pub transmit_queue: u32,
    /// The bit rate in bit/s; `None` for a virtual interface, or if the bit rate was never set.
    pub bit_rate: Option<u32>,
    /// The state of the controller; `None` for an interface without controller, such as `vcan` and `vxcan`.
    pub state: Option<ControllerState>,
    /// The controller's counters of transmit and receive errors.
    pub error_counters: Option<(u16, u16)>,
    /// The delay in milliseconds after which the kernel restarts a controller in bus-off; `None` if a person must
    /// restart it.
    pub restart_ms: Option<u32>,
    /// Number of frames that the controller, its driver or the kernel has lost before any socket received them, since
    /// the interface exists.
    pub lost: u64,
}

/// The state of a CAN controller.
pub type ControllerState = CanState;

/// The name of the state.
const fn word(state: ControllerState) -> &'static str {
    match state {
        CanState::ErrorActive => "error-active",
        CanState::ErrorWarning => "error-warning",
        CanState::ErrorPassive => "error-passive",
        CanState::BusOff => "bus-off",
        CanState::Stopped => "stopped",
        CanState::Sleeping => "sleeping",
    }
}

impl Link {
    /// The interface of that name; `None` if there is none.
    ///
    /// # Errors
    /// The kernel's error.
    pub fn find(interface: &str) -> io::Result<Option<Self>> {
        if interface.is_empty() || interface.contains('/') || interface.starts_with('.') {
            return Ok(None);
        }
        let open = match CanInterface::open(interface) {
            Ok(open) => open,
            Err(error) => return unless_absent(io_error(error)),
        };
        // Other kinds of interfaces use these attributes differently.
        if figure(interface, "type") != Some(CAN) {
            return Ok(figure(interface, "ifindex").map(|index| Self { index, ..Self::default() }));
        }
        let details = match open.details() {
            Ok(details) => details,
            Err(error) => return unless_absent(io_error(error)),
        };
        Ok(Some(Self {
            index: details.index,
            is_can: true,
            is_up: details.is_up,
            is_fd: details.mtu == Some(Mtu::Fd),
            transmit_queue: figure(interface, "tx_queue_len").unwrap_or(0),
            bit_rate: details.can.bit_timing.map(|timing| timing.bitrate).filter(|&rate| rate > 0),
            state: details.can.state,
            error_counters: details.can.berr_counter.map(|counter| (counter.txerr, counter.rxerr)),
            restart_ms: details.can.restart_ms,
            lost: Self::lost(interface),
        }))
    }

    /// Number of frames lost before any socket received them. A driver counts a frame for which its controller had no
    /// room under one of two names.
    pub(super) fn lost(interface: &str) -> u64 {
        lost(|name| figure(interface, &format!("statistics/{name}")).unwrap_or(0))
    }

    /// The names of all CAN interfaces.
    pub fn can_interfaces() -> Vec<String> {
        let entries = fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
        let mut names: Vec<String> = entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| figure(name, "type") == Some(CAN))
            .collect();
        names.sort();
        names
    }

    /// Whether frames can be sent and received on the interface.
    pub(super) fn is_usable(&self) -> bool {
        self.is_can && self.is_up && !matches!(self.state, Some(ControllerState::BusOff | ControllerState::Stopped))
    }

    /// The command that brings the interface up.
    pub fn up_command(&self, interface: &str) -> String {
        match (self.state, self.bit_rate) {
            (Some(_), None) => format!("ip link set {interface} up type can bitrate 250000"),
            _ => format!("ip link set {interface} up"),
        }
    }
}

/// Turns the error of a missing interface into `None`.
fn unless_absent(error: io::Error) -> io::Result<Option<Link>> {
    if error.raw_os_error() == Some(libc::ENODEV) { Ok(None) } else { Err(error) }
}

/// The error of a query to the kernel, with its error number.
pub(super) fn io_error(error: socketcan::Error) -> io::Error {
    match error {
        socketcan::Error::Io(error) => error,
        socketcan::Error::Nl(error) => match error.errno() {
            Some(code) => io::Error::from_raw_os_error(code),
            None => io::Error::other(error),
        },
        other => io::Error::other(other),
    }
}

/// Reads a number from a file of the kernel about an interface.
fn figure<T: FromStr>(interface: &str, name: &str) -> Option<T> {
    fs::read_to_string(Path::new("/sys/class/net").join(interface).join(name)).ok()?.trim().parse().ok()
}

fn lost(figure: impl Fn(&str) -> u64) -> u64 {
    figure("rx_dropped") + figure("rx_over_errors").max(figure("rx_fifo_errors")) + figure("rx_missed_errors")
}

/// The properties in words: `controller, up, 250 kbit/s, error-active`.
impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.state.is_some() { "controller" } else { "virtual" })?;
        f.write_str(if self.is_up { ", up" } else { ", down" })?;
        if let Some(rate) = self.bit_rate {
            write!(f, ", {} kbit/s", f64::from(rate) / 1e3)?;
        }
        if let Some(state) = self.state {
            write!(f, ", {}", word(state))?;
        }
        if let Some((transmit, receive)) = self.error_counters {
            write!(f, ", error counters {transmit} (transmit) and {receive} (receive)")?;
        }
        if self.state == Some(ControllerState::BusOff) {
            match self.restart_ms {
                Some(ms) if ms > 0 => write!(f, ", restarts after {ms} ms")?,
                _ => f.write_str(", not restarted by itself")?,
            }
        }
        let format = if self.is_fd { "CAN FD" } else { "classical" };
        write!(f, ", {format}, transmit queue of {} frames", self.transmit_queue)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_controller_in_bus_off() {
        let link = Link {
            index: 7,
            is_can: true,
            is_up: true,
            transmit_queue: 10,
            bit_rate: Some(250_000),
            state: Some(ControllerState::BusOff),
            error_counters: Some((248, 0)),
            ..Link::default()
        };
        assert_eq!(
            link.to_string(),
            "controller, up, 250 kbit/s, bus-off, error counters 248 (transmit) and 0 (receive), not restarted by \
             itself, classical, transmit queue of 10 frames"
        );
    }

    #[test]
    fn what_was_lost_is_summed_but_a_full_controller_counts_once() {
        let counted = lost(|name| match name {
            "rx_dropped" => 5,
            "rx_over_errors" | "rx_fifo_errors" => 70,
            "rx_missed_errors" => 900,
            _ => 1 << 40,
        });
        assert_eq!(counted, 975);
    }

    #[test]
    fn this_kernel_knows_its_loopback() {
        let link = Link::find("lo").unwrap().unwrap();
        assert!(!link.is_can && link.index > 0);
        for absent in ["no-such-link", "", "..", "lo/../lo"] {
            assert_eq!(Link::find(absent).unwrap(), None, "{absent}");
        }
    }
}
