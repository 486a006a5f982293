//! The reasons why SocketCAN does not work, with remedies.

use super::link::Link;
use canvass_traces::Duration;
use std::io;

/// Why SocketCAN does not work. The text of each error includes the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SocketCanError {
    /// The kernel has no CAN: `EAFNOSUPPORT` or `EPROTONOSUPPORT`.
    #[error(
        "no CAN in this kernel: modprobe can-raw (as root); if there is no such module, a kernel with CONFIG_CAN and \
         CONFIG_CAN_RAW is needed, or an adapter by slcan:PORT (canvass doctor says more)"
    )]
    NoCan,
    /// No network interface has that name.
    #[error("there is no interface {interface}: {known}")]
    NoInterface {
        /// The name as typed.
        interface: String,
        /// The names of the CAN interfaces, or how to make one.
        known: String,
    },
    /// The network interface is no CAN interface.
    #[error("{interface} is no CAN interface: {known}")]
    NotCan {
        /// The name as typed.
        interface: String,
        /// The names of the CAN interfaces, or how to make one.
        known: String,
    },
    /// The interface is not up.
    #[error("{interface} is down: {command}")]
    Down {
        /// The name of the interface.
        interface: String,
        /// The command that brings the interface up.
        command: String,
    },
    /// The process has no permission for the action.
    #[error("no permission to {action} {interface}: run as root, or give the container the network of its host")]
    Permission {
        /// The failed action.
        action: &'static str,
        interface: String,
    },
    /// The transmit queue stays full.
    #[error("{interface} has sent nothing for {waited}: no node acknowledges, or the bus is full ({state})")]
    QueueFull {
        interface: String,
        /// The time waited.
        waited: Duration,
        /// The kernel's state of the interface.
        state: String,
    },
    /// The kernel refuses the bit rate.
    #[error("can't set {interface} to {bit_rate} bit/s ({source}): {command} (as root)")]
    BitRate {
        interface: String,
        /// The bit rate in bit/s.
        bit_rate: u32,
        /// The command that sets the bit rate.
        command: String,
        /// The kernel's error.
        source: io::Error,
    },
    /// The interface has no controller, and so no bit rate.
    #[error("{interface} is a virtual interface, which has no bit rate: expected one with a CAN controller")]
    NoBitRate { interface: String },
    /// Any other error.
    #[error("can't {action} {interface}: {source}")]
    Io {
        /// The failed action.
        action: &'static str,
        interface: String,
        /// The kernel's error.
        source: io::Error,
    },
}

impl SocketCanError {
    /// The error for a failed system call.
    pub(super) fn of(interface: &str, action: &'static str, source: io::Error) -> Self {
        let interface = interface.to_owned();
        match source.raw_os_error() {
            Some(libc::EAFNOSUPPORT | libc::EPROTONOSUPPORT) => Self::NoCan,
            Some(libc::EPERM | libc::EACCES) => Self::Permission { action, interface },
            Some(libc::ENODEV | libc::ENXIO) => Self::NoInterface { interface, known: known() },
            Some(libc::ENETDOWN) => Self::down(interface),
            _ => Self::Io { action, interface, source },
        }
    }

    /// Whether the error ends when the interface comes back.
    pub(crate) const fn is_interruption(&self) -> bool {
        matches!(self, Self::NoInterface { .. } | Self::Down { .. } | Self::QueueFull { .. })
    }

    fn down(interface: String) -> Self {
        match Link::find(&interface) {
            Ok(Some(link)) => Self::Down { command: link.up_command(&interface), interface },
            _ => Self::NoInterface { interface, known: known() },
        }
    }

    /// Checks that a link can be used.
    pub(super) fn check(interface: &str, link: Option<Link>) -> Result<Link, Self> {
        let interface = interface.to_owned();
        match link {
            None => Err(Self::NoInterface { interface, known: known() }),
            Some(link) if !link.is_can => Err(Self::NotCan { interface, known: known() }),
            Some(link) if !link.is_up => Err(Self::Down { command: link.up_command(&interface), interface }),
            Some(link) => Ok(link),
        }
    }
}

fn known() -> String {
    let names = Link::can_interfaces();
    if names.is_empty() {
        return "there is no CAN interface at all; a virtual one: ip link add dev vcan0 type vcan && ip link set vcan0 up"
            .to_owned();
    }
    format!("the CAN interfaces are {}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::socketcan::ControllerState;

    fn of(code: i32) -> String {
        SocketCanError::of("can0", "open", io::Error::from_raw_os_error(code)).to_string()
    }

    #[test]
    fn every_error_names_its_remedy() {
        assert!(of(libc::EAFNOSUPPORT).contains("modprobe can-raw"), "{}", of(libc::EAFNOSUPPORT));
        assert!(of(libc::EPROTONOSUPPORT).contains("modprobe can-raw"));
        assert!(of(libc::EPERM).contains("root"));
        let check = |link| SocketCanError::check("can0", Some(link)).unwrap_err().to_string();
        let can = Link { is_can: true, state: Some(ControllerState::Stopped), ..Link::default() };
        assert_eq!(check(can.clone()), "can0 is down: ip link set can0 up type can bitrate 250000");
        assert_eq!(check(Link { bit_rate: Some(500_000), ..can }), "can0 is down: ip link set can0 up");
        assert!(check(Link::default()).starts_with("can0 is no CAN interface: "));
        let absent = SocketCanError::check("can7", None).unwrap_err().to_string();
        assert!(absent.starts_with("there is no interface can7: "), "{absent}");
    }
}
