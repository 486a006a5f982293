//! What the kernel says of its CAN interfaces: rtnetlink (`linux/rtnetlink.h`, `linux/can/netlink.h`).

use super::netlink::{
    HEADER, IFF_UP, LINK_HEADER, NLM_F_REQUEST, RTM_GETLINK, RTM_NEWLINK, attribute, attributes, kind, malformed,
    message, u16_at, u32_at, u64_at,
};
use super::sys;
use std::fmt;
use std::io;

const IFLA_IFNAME: u16 = 3;
const IFLA_MTU: u16 = 4;
const IFLA_TXQLEN: u16 = 13;
pub(super) const IFLA_LINKINFO: u16 = 18;
const IFLA_STATS64: u16 = 23;
pub(super) const IFLA_INFO_KIND: u16 = 1;
pub(super) const IFLA_INFO_DATA: u16 = 2;
pub(super) const IFLA_CAN_BITTIMING: u16 = 1;
const IFLA_CAN_STATE: u16 = 4;
const IFLA_CAN_RESTART_MS: u16 = 6;
const IFLA_CAN_BERR_COUNTER: u16 = 8;
const ARPHRD_CAN: u16 = 280;
/// The kind of interfaces that have a controller, and so a bit rate.
pub(super) const CONTROLLER: &str = "can";

/// A network interface, as far as CAN is concerned.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Link {
    /// The number by which sockets are bound to it.
    pub index: u32,
    /// Whether it is a CAN interface.
    pub is_can: bool,
    /// `can` for hardware, `vcan`, `vxcan`, ...; empty if the driver has none.
    pub kind: String,
    /// Whether it is up.
    pub is_up: bool,
    /// 16 for classical CAN, 72 for CAN FD.
    pub mtu: u32,
    /// How many frames the transmit queue holds.
    pub transmit_queue: u32,
    /// In bit/s; `None` for interfaces without wires and for those that were never given one.
    pub bit_rate: Option<u32>,
    /// Of the controller; `None` for interfaces without one.
    pub state: Option<ControllerState>,
    /// The controller's counters of transmit and receive errors.
    pub error_counters: Option<(u16, u16)>,
    /// After how many milliseconds in bus-off the controller is restarted; `None`: only by hand.
    pub restart_ms: Option<u32>,
    /// How many frames the controller, its driver or the kernel has lost before any socket saw them, since the interface
    /// is there.
    pub lost: u64,
}

/// The state of a CAN controller, as `enum can_state` numbers it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ControllerState {
    /// Error counters below 96.
    ErrorActive,
    /// An error counter of 96 or more.
    ErrorWarning,
    /// An error counter of 128 or more.
    ErrorPassive,
    /// The transmit error counter was above 255: the controller takes no part any more.
    BusOff,
    /// Down.
    Stopped,
    /// Asleep.
    Sleeping,
}

impl ControllerState {
    const ALL: [Self; 6] =
        [Self::ErrorActive, Self::ErrorWarning, Self::ErrorPassive, Self::BusOff, Self::Stopped, Self::Sleeping];
}

impl fmt::Display for ControllerState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ErrorActive => "error-active",
            Self::ErrorWarning => "error-warning",
            Self::ErrorPassive => "error-passive",
            Self::BusOff => "bus-off",
            Self::Stopped => "stopped",
            Self::Sleeping => "sleeping",
        })
    }
}

impl Link {
    /// The interface of that name; `None` if there is none.
    ///
    /// # Errors
    /// What the kernel reports.
    pub fn find(interface: &str) -> io::Result<Option<Self>> {
        read(&sys::ask_routing(&request(interface))?)
    }

    /// The names of all CAN interfaces.
    pub fn can_interfaces() -> Vec<String> {
        let entries = std::fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
        let is_can = |path: std::path::PathBuf| {
            std::fs::read_to_string(path.join("type")).is_ok_and(|text| text.trim() == ARPHRD_CAN.to_string())
        };
        let mut names: Vec<String> = entries
            .filter(|entry| is_can(entry.path()))
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// The command that brings it up.
    pub fn up_command(&self, interface: &str) -> String {
        match (&*self.kind, self.bit_rate) {
            (CONTROLLER, None) => format!("ip link set {interface} up type can bitrate 250000"),
            _ => format!("ip link set {interface} up"),
        }
    }
}

/// `hardware, up, 250 kbit/s, error-active`.
impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.kind.is_empty() { "CAN" } else { &self.kind })?;
        f.write_str(if self.is_up { ", up" } else { ", down" })?;
        if let Some(rate) = self.bit_rate {
            write!(f, ", {} kbit/s", f64::from(rate) / 1e3)?;
        }
        if let Some(state) = self.state {
            write!(f, ", {state}")?;
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
        write!(
            f,
            ", {}, transmit queue of {} frames",
            if self.mtu >= 72 { "CAN FD" } else { "classical" },
            self.transmit_queue
        )
    }
}

/// Asks for one link by its name.
fn request(interface: &str) -> Vec<u8> {
    let name = [interface.as_bytes(), &[0]].concat();
    message(RTM_GETLINK, NLM_F_REQUEST, 0, (0, 0), &attribute(IFLA_IFNAME, &name))
}

/// The first link of an answer.
fn read(answer: &[u8]) -> io::Result<Option<Link>> {
    match kind(answer) {
        Ok(RTM_NEWLINK) => {}
        Ok(_) => return Err(malformed()),
        Err(error) if error.raw_os_error() == Some(libc::ENODEV) => return Ok(None),
        Err(error) => return Err(error),
    }
    let hardware = u16_at(answer, HEADER + 2).ok_or_else(malformed)?;
    let flags = u32_at(answer, HEADER + 8).ok_or_else(malformed)?;
    let mut link = Link {
        index: u32_at(answer, HEADER + 4).ok_or_else(malformed)?,
        is_can: hardware == ARPHRD_CAN,
        is_up: flags & IFF_UP != 0,
        ..Link::default()
    };
    let length = (u32_at(answer, 0).unwrap_or(0) as usize).min(answer.len());
    for (kind, data) in attributes(answer.get(HEADER + LINK_HEADER..length).unwrap_or_default()) {
        match kind {
            IFLA_MTU => link.mtu = u32_at(data, 0).unwrap_or(0),
            IFLA_TXQLEN => link.transmit_queue = u32_at(data, 0).unwrap_or(0),
            IFLA_LINKINFO => link.read_info(data),
            IFLA_STATS64 => link.lost = lost(data),
            _ => {}
        }
    }
    Ok(Some(link))
}

/// Of `struct rtnl_link_stats64`. Drivers count a frame that their controller had no room for under one of two names.
fn lost(statistics: &[u8]) -> u64 {
    let number = |place: usize| u64_at(statistics, place * size_of::<u64>()).unwrap_or(0);
    let (rx_dropped, rx_over_errors, rx_fifo_errors, rx_missed_errors) = (6, 11, 14, 15);
    number(rx_dropped) + number(rx_over_errors).max(number(rx_fifo_errors)) + number(rx_missed_errors)
}

impl Link {
    fn read_info(&mut self, info: &[u8]) {
        for (kind, data) in attributes(info) {
            match kind {
                IFLA_INFO_KIND => {
                    self.kind = String::from_utf8_lossy(data).trim_end_matches('\0').to_owned();
                }
                // Other kinds of interfaces number their attributes otherwise.
                IFLA_INFO_DATA if self.kind == CONTROLLER => self.read_controller(data),
                _ => {}
            }
        }
    }

    fn read_controller(&mut self, info: &[u8]) {
        for (kind, data) in attributes(info) {
            match kind {
                IFLA_CAN_BITTIMING => self.bit_rate = u32_at(data, 0).filter(|&rate| rate > 0),
                IFLA_CAN_STATE => {
                    self.state = u32_at(data, 0).and_then(|n| ControllerState::ALL.get(n as usize).copied());
                }
                IFLA_CAN_RESTART_MS => self.restart_ms = u32_at(data, 0),
                IFLA_CAN_BERR_COUNTER => self.error_counters = u16_at(data, 0).zip(u16_at(data, 2)),
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn answer(hardware: u16, flags: u32, attributes: &[u8]) -> Vec<u8> {
        let mut bytes = ((HEADER + LINK_HEADER + attributes.len()) as u32).to_ne_bytes().to_vec();
        bytes.extend_from_slice(&RTM_NEWLINK.to_ne_bytes());
        bytes.extend_from_slice(&[0; 10 + 2]);
        bytes.extend_from_slice(&hardware.to_ne_bytes());
        bytes.extend_from_slice(&7_u32.to_ne_bytes());
        bytes.extend_from_slice(&flags.to_ne_bytes());
        bytes.extend_from_slice(&[0; 4]);
        bytes.extend_from_slice(attributes);
        bytes
    }

    #[test]
    fn a_controller_in_bus_off() {
        let number = |n: u32| n.to_ne_bytes();
        let controller = [
            attribute(IFLA_CAN_BITTIMING, &number(250_000)),
            attribute(IFLA_CAN_STATE, &number(3)),
            attribute(IFLA_CAN_BERR_COUNTER, &[248_u16.to_ne_bytes(), 0_u16.to_ne_bytes()].concat()),
        ];
        let info = [attribute(IFLA_INFO_KIND, b"can\0"), attribute(0x8000 | IFLA_INFO_DATA, &controller.concat())];
        let attributes = [
            attribute(IFLA_MTU, &number(16)),
            attribute(IFLA_TXQLEN, &number(10)),
            attribute(IFLA_LINKINFO, &info.concat()),
        ];
        let link = read(&answer(ARPHRD_CAN, IFF_UP, &attributes.concat())).unwrap().unwrap();
        assert_eq!((link.index, link.is_can, link.bit_rate), (7, true, Some(250_000)));
        assert_eq!(
            link.to_string(),
            "can, up, 250 kbit/s, bus-off, error counters 248 (transmit) and 0 (receive), not restarted by itself, \
             classical, transmit queue of 10 frames"
        );
    }

    #[test]
    fn what_was_lost_is_summed_but_a_full_controller_counts_once() {
        // struct rtnl_link_stats64 of linux/if_link.h.
        let numbers: [u64; 25] = std::array::from_fn(|place| match place {
            6 => 5,
            11 | 14 => 70,
            15 => 900,
            _ => 1 << 40,
        });
        let statistics: Vec<u8> = numbers.iter().flat_map(|number| number.to_ne_bytes()).collect();
        let link = read(&answer(ARPHRD_CAN, IFF_UP, &attribute(IFLA_STATS64, &statistics))).unwrap().unwrap();
        assert_eq!(link.lost, 975);
    }

    #[test]
    fn no_such_device_is_no_error() {
        let mut bytes = vec![0; HEADER + 20];
        bytes[4..6].copy_from_slice(&2_u16.to_ne_bytes());
        bytes[HEADER..HEADER + 4].copy_from_slice(&(-libc::ENODEV).to_ne_bytes());
        assert_eq!(read(&bytes).unwrap(), None);
        bytes[HEADER..HEADER + 4].copy_from_slice(&(-libc::EPERM).to_ne_bytes());
        assert_eq!(read(&bytes).unwrap_err().kind(), io::ErrorKind::PermissionDenied);
    }

    #[test]
    fn this_kernel_knows_its_loopback() {
        let link = Link::find("lo").unwrap().unwrap();
        assert!(!link.is_can && link.index > 0);
        assert_eq!(Link::find("no-such-link").unwrap(), None);
    }

    proptest! {
        /// Whatever comes, nothing panics and nothing hangs.
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = read(&bytes);
            prop_assert!(attributes(&bytes).count() <= bytes.len());
        }
    }
}
