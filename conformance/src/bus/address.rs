//! The addresses of buses, as they stand on the command line.
//!
//! ```text
//! can0                              a SocketCAN interface
//! socketcan:can0                    the same
//! slcan:/dev/ttyACM0[@BITRATE]      a serial CAN adapter
//! slcan:tcp://HOST:PORT[@BITRATE]   one behind TCP
//! slcan:listen://HOST:PORT          this end is the adapter, for a program that connects
//! sim:MODEL[@BITRATE][+FAULT...]    a simulated bus with one simulated device
//! ```
//!
//! A bit rate is a number in bit/s, or in kbit/s with `k`, or in Mbit/s with `M`: `125000`, `250k`, `1M`.

use super::{Bus, BusError, SimulatedBus};
use crate::device::Device;
use crate::models::Model;
use crate::{Fault, Faults};
use std::fmt;
use std::str::FromStr;

/// Where a bus is.
#[derive(Clone, Debug)]
pub enum BusAddress {
    /// An interface of Linux.
    SocketCan {
        /// Its name, such as `can0`.
        interface: String,
    },
    /// A serial adapter that speaks SLCAN.
    SlCan {
        /// The path of its port.
        port: String,
        /// In bit/s, if it was given.
        bit_rate: Option<u32>,
    },
    /// A simulated bus with one simulated device.
    Simulated {
        /// The device's model.
        model: &'static Model,
        /// In bit/s, if it was given.
        bit_rate: Option<u32>,
        /// What its firmware does wrong.
        faults: Faults,
    },
}

/// A bus that is ready, and what is known of the device on it.
pub struct Opened {
    /// The bus.
    pub bus: Box<dyn Bus>,
    /// The model of a simulated device: its default node-ID and its device description.
    pub model: Option<&'static Model>,
}

impl fmt::Debug for Opened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Opened").field("model", &self.model.map(Model::id)).finish_non_exhaustive()
    }
}

/// Opens the bus at that address.
///
/// # Errors
/// [`BusError`] if the address names no bus, or one that can't be opened.
pub fn open(address: &str) -> Result<Opened, BusError> {
    open_seeded(address, 0)
}

/// As [`open`]; `seed` chooses what is left to chance in a simulated device.
///
/// # Errors
/// As [`open`].
pub fn open_seeded(address: &str, seed: u64) -> Result<Opened, BusError> {
    match address.parse()? {
        #[cfg(target_os = "linux")]
        BusAddress::SocketCan { interface } => {
            Ok(Opened { bus: Box::new(super::socketcan::SocketCan::open(&interface)?), model: None })
        }
        #[cfg(not(target_os = "linux"))]
        BusAddress::SocketCan { .. } => {
            Err(BusError::Unavailable { address: address.to_owned(), interface: "SocketCAN" })
        }
        BusAddress::SlCan { port, bit_rate } => {
            Ok(Opened { bus: Box::new(super::slcan::SlCan::open(&port, bit_rate)?), model: None })
        }
        BusAddress::Simulated { model, bit_rate, faults } => {
            let mut bus = SimulatedBus::new(bit_rate.unwrap_or_else(|| model.default_bit_rate()));
            bus.attach(Box::new(Device::new(model, model.default_node(), faults, seed)));
            Ok(Opened { bus: Box::new(bus), model: Some(model) })
        }
    }
}

impl FromStr for BusAddress {
    type Err = BusError;

    fn from_str(address: &str) -> Result<Self, BusError> {
        let parsed = match address.split_once(':') {
            Some(("sim", rest)) => simulated(rest),
            Some(("slcan", rest)) => slcan(rest),
            Some(("socketcan", interface)) => socketcan(interface),
            None => socketcan(address),
            Some((kind, _)) => Err(format!(
                "expected socketcan:INTERFACE, slcan:PORT[@BITRATE] or sim:MODEL[@BITRATE][+FAULT...], found \"{kind}:\""
            )),
        };
        parsed.map_err(|reason| BusError::Address { address: address.to_owned(), reason })
    }
}

fn socketcan(interface: &str) -> Result<BusAddress, String> {
    // Linux: IFNAMSIZ is 16 with its terminating zero.
    let is_name = |c: char| c.is_ascii_graphic() && c != '/';
    if interface.is_empty() || interface.len() > 15 || !interface.chars().all(is_name) {
        return Err("expected the name of a CAN interface, such as can0".to_owned());
    }
    Ok(BusAddress::SocketCan { interface: interface.to_owned() })
}

fn slcan(rest: &str) -> Result<BusAddress, String> {
    let (port, bit_rate) = match rest.rsplit_once('@') {
        Some((port, rate)) => (port, Some(parse_bit_rate(rate)?)),
        None => (rest, None),
    };
    if port.is_empty() {
        return Err("expected the path of a serial port, such as slcan:/dev/ttyACM0@500k".to_owned());
    }
    Ok(BusAddress::SlCan { port: port.to_owned(), bit_rate })
}

fn simulated(rest: &str) -> Result<BusAddress, String> {
    let mut parts = rest.split('+');
    let head = parts.next().unwrap_or_default();
    let (id, bit_rate) = match head.split_once('@') {
        Some((id, rate)) => (id, Some(parse_bit_rate(rate)?)),
        None => (head, None),
    };
    let model = Model::by_id(id).ok_or_else(|| {
        let known: Vec<&str> = Model::all().iter().map(Model::id).collect();
        format!("expected one of the models {}, found \"{id}\"", known.join(", "))
    })?;
    let faults = parts.map(Fault::from_str).collect::<Result<Faults, _>>().map_err(|error| error.to_string())?;
    Ok(BusAddress::Simulated { model, bit_rate, faults })
}

/// The highest bit rate of classical CAN.
const HIGHEST_BIT_RATE: u32 = 1_000_000;

/// A bit rate in bit/s, 1000 to 1 000 000.
fn parse_bit_rate(text: &str) -> Result<u32, String> {
    let (digits, factor) = match text.strip_suffix(['k', 'K']) {
        Some(digits) => (digits, 1_000),
        None => text.strip_suffix(['M', 'm']).map_or((text, 1), |digits| (digits, 1_000_000)),
    };
    let rate = digits.parse::<u32>().ok().and_then(|number| number.checked_mul(factor));
    rate.filter(|rate| (1_000..=HIGHEST_BIT_RATE).contains(rate))
        .ok_or_else(|| format!("expected a bit rate from 1k to 1M, such as 250k, found \"{text}\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reason(address: &str) -> String {
        address.parse::<BusAddress>().unwrap_err().to_string()
    }

    #[test]
    fn every_kind() {
        assert!(matches!("can0".parse(), Ok(BusAddress::SocketCan { interface }) if interface == "can0"));
        assert!(matches!("socketcan:vcan1".parse(), Ok(BusAddress::SocketCan { interface }) if interface == "vcan1"));
        assert!(matches!("slcan:/dev/ttyACM0@500k".parse(),
            Ok(BusAddress::SlCan { port, bit_rate: Some(500_000) }) if port == "/dev/ttyACM0"));
        assert!(matches!("slcan:COM3".parse(), Ok(BusAddress::SlCan { bit_rate: None, .. })));
        let Ok(BusAddress::Simulated { model, bit_rate, faults }) =
            "sim:kuebler-sendix-58x8@1M+boot-up-twice+vendor-id-zero".parse()
        else {
            panic!("a simulated bus");
        };
        assert_eq!((model.id(), bit_rate), ("kuebler-sendix-58x8", Some(1_000_000)));
        assert_eq!(faults, Faults::from(Fault::BootUpTwice).with(Fault::VendorIdZero));
    }

    #[test]
    fn errors_say_what_would_be_right() {
        assert!(reason("sim:nonsense").contains("kuebler-sendix-58x8"), "{}", reason("sim:nonsense"));
        assert!(reason("sim:kuebler-sendix-58x8+nonsense").contains("canvass list faults"));
        assert!(reason("sim:kuebler-sendix-58x8@9").contains("250k"));
        assert!(reason("sim:kuebler-sendix-58x8@2M").contains("1M"));
        assert!(reason("pcan:1").contains("socketcan:"));
        assert!(reason("").contains("can0") && reason("slcan:").contains("slcan:/dev/ttyACM0"));
    }

    #[test]
    fn buses_that_are_not_there() {
        assert!(open("no-such-can0").is_err());
        assert!(open("slcan:/dev/no-such-port").unwrap_err().to_string().contains("/dev/no-such-port"));
        assert!(open("sim:kuebler-sendix-58x8").unwrap().model.is_some());
    }
}
