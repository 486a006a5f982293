//! The addresses of buses, as typed on the command line.
//!
//! ```text
//! can0                              a SocketCAN interface
//! socketcan:can0                    the same interface
//! slcan:/dev/ttyACM0[@BITRATE]      a serial CAN adapter
//! slcan:tcp://HOST:PORT[@BITRATE]   a serial CAN adapter that is reached over TCP
//! slcan:listen://HOST:PORT          this end is the adapter, for a program that connects
//! slcan:listen://PORT               as above, for a program on this machine only
//! pcan:PCAN_USBBUS1@BITRATE         an adapter of PEAK, through PEAK's library
//! pcan:CHANNEL@BITRATE+listen-only  an adapter of PEAK that neither sends nor acknowledges
//! python:INTERFACE:CHANNEL[@BITRATE]   a bus of python-can, such as python:kvaser:0@250k
//! socketcand://HOST[:PORT]/can0     an interface of a machine that runs socketcand
//! cannelloni:tcp://HOST[:PORT]      a machine that runs cannelloni as a server
//! cannelloni:udp://HOST[:PORT][+LOCALPORT]   the same by datagrams
//! udp://GROUP[:PORT]                python-can's udp_multicast
//! sim:MODEL[@BITRATE][+FAULT...]    a simulated bus with a simulated device
//! sim:MODEL[:NODE][@BITRATE][~MOTION][~~LIBERTY...][+FAULT...][+MODEL...]    the full form, also
//!                                   with several devices
//! ```
//!
//! `MODEL` may be a device description too: `sim:my.eds`.
//!
//! A bit rate is a number in bit/s, or in kbit/s with `k`, or in Mbit/s with `M`: `125000`, `250k`, `1M`.

mod simulated;

pub use simulated::{Attached, DeviceName, GivenNode, SimulatedDevice};

use crate::Device;
use crate::models::Model;
use canvass_analyzer::NodeId;
use canvass_bus::network::{Carrier, NetworkAddress};
use canvass_bus::pcan::Opening;
use canvass_bus::{Bus, BusError, SimulatedBus};
use canvass_traces::Timestamp;
use std::fmt;
use std::str::FromStr;

/// The address of a bus.
#[derive(Clone, Debug)]
pub enum BusAddress {
    /// A network interface of Linux.
    SocketCan {
        /// The name of the interface, such as `can0`.
        interface: String,
    },
    /// A serial adapter that speaks SLCAN.
    SlCan {
        /// The path of the adapter's port.
        port: String,
        /// The bit rate in bit/s, if the address gives one.
        bit_rate: Option<u32>,
    },
    /// A bus of python-can.
    Python {
        /// python-can's name of the interface, such as `kvaser`.
        interface: String,
        /// The channel.
        channel: String,
        /// The bit rate in bit/s, if the address gives one.
        bit_rate: Option<u32>,
    },
    /// A bus over a network.
    Network(NetworkAddress),
    /// An adapter of PEAK.
    Pcan(Opening),
    /// A simulated bus with these devices: at least one.
    Simulated(Vec<SimulatedDevice>),
}

/// An open bus, with the devices known on it.
pub struct Opened {
    pub bus: Box<dyn Bus + Send>,
    /// The model of the first simulated device.
    pub model: Option<&'static Model>,
    /// All simulated devices, in the order of the address.
    pub devices: Vec<Attached>,
}

impl Opened {
    /// The node-ID of the first simulated device.
    pub fn node(&self) -> Option<NodeId> {
        self.devices.first().and_then(|device| device.node)
    }
}

impl fmt::Debug for Opened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Opened").field("model", &self.model.map(Model::id)).finish_non_exhaustive()
    }
}

/// Opens the bus at an address.
///
/// # Errors
/// [`BusError`] if the text is no address of a bus, or if the bus can't be opened.
pub fn open(address: &str) -> Result<Opened, BusError> {
    open_seeded(address, 0)
}

/// Opens the bus at an address, like [`open`]. `seed` determines the random choices of a simulated device.
///
/// # Errors
/// The errors of [`open`].
pub fn open_seeded(address: &str, seed: u64) -> Result<Opened, BusError> {
    open_seeded_at(address, seed, None)
}

/// Opens the bus at an address, like [`open_seeded`]. A single simulated device gets the node-ID `node` if the address
/// gives none.
///
/// # Errors
/// The errors of [`open`].
pub fn open_seeded_at(address: &str, seed: u64, node: Option<NodeId>) -> Result<Opened, BusError> {
    match address.parse()? {
        #[cfg(target_os = "linux")]
        BusAddress::SocketCan { interface } => {
            let bus = Box::new(canvass_bus::socketcan::SocketCan::open(&interface)?);
            Ok(Opened { bus, model: None, devices: Vec::new() })
        }
        #[cfg(not(target_os = "linux"))]
        BusAddress::SocketCan { .. } => {
            Err(BusError::Unavailable { address: address.to_owned(), interface: "SocketCAN" })
        }
        BusAddress::SlCan { port, bit_rate } => {
            let bus = canvass_bus::slcan::open(&port, bit_rate)?;
            Ok(Opened { bus, model: None, devices: Vec::new() })
        }
        BusAddress::Python { interface, channel, bit_rate } => {
            let bus = Box::new(canvass_bus::slcan::python::open(&interface, &channel, bit_rate)?);
            Ok(Opened { bus, model: None, devices: Vec::new() })
        }
        #[cfg(target_family = "wasm")]
        BusAddress::Network(_) => {
            Err(BusError::Unavailable { address: address.to_owned(), interface: "a bus over a network" })
        }
        #[cfg(not(target_family = "wasm"))]
        BusAddress::Network(address) => {
            let bus = Box::new(canvass_bus::network::NetworkBus::open(&address)?);
            Ok(Opened { bus, model: None, devices: Vec::new() })
        }
        #[cfg(any(windows, target_os = "linux"))]
        BusAddress::Pcan(opening) => {
            let bus = Box::new(canvass_bus::pcan::Pcan::open(opening)?);
            Ok(Opened { bus, model: None, devices: Vec::new() })
        }
        #[cfg(not(any(windows, target_os = "linux")))]
        BusAddress::Pcan(_) => Err(BusError::Unavailable { address: address.to_owned(), interface: "PCAN-Basic" }),
        BusAddress::Simulated(mut devices) => {
            if let ([only], Some(node)) = (&mut devices[..], node) {
                only.node.get_or_insert(GivenNode::Id(node));
            }
            let (bus, devices) = simulate(&devices, seed)?;
            let model = devices.first().map(|device| device.model);
            Ok(Opened { bus: Box::new(bus), model, devices })
        }
    }
}

/// Makes the simulated bus itself, for callers that switch its devices off and on or copy the bus.
///
/// # Errors
/// [`BusError::Address`] if a device description or a motion can't be read.
pub fn simulate(named: &[SimulatedDevice], seed: u64) -> Result<(SimulatedBus, Vec<Attached>), BusError> {
    let (bit_rate, devices) = devices(named, seed)?;
    let mut bus = SimulatedBus::new(bit_rate);
    let attach = |(device, attached): (Device, Attached)| {
        bus.attach(Box::new(device));
        attached
    };
    let attached = devices.into_iter().map(attach).collect();
    Ok((bus, attached))
}

/// Makes the devices of a simulated bus, for callers that connect them themselves; and the bit rate of the bus.
///
/// # Errors
/// [`BusError::Address`] if a device description or a motion can't be read.
pub fn devices(named: &[SimulatedDevice], seed: u64) -> Result<(u32, Vec<(Device, Attached)>), BusError> {
    let models = named.iter().map(SimulatedDevice::model).collect::<Result<Vec<_>, _>>()?;
    let known: Vec<_> = named.iter().zip(models).collect();
    let own_rate = |(device, model): &(&SimulatedDevice, &'static Model)| {
        device.bit_rate.unwrap_or_else(|| model.default_bit_rate())
    };
    let bit_rate = known.first().map_or(0, own_rate);
    let mut devices = Vec::with_capacity(known.len());
    for (n, ((device, model), node)) in (0..).zip(known.iter().zip(simulated::assign(&known))) {
        // Each device has its own random sequence.
        let mut simulated = Device::new(model, node, device.firmware, seed.wrapping_add(n));
        if let Some(motion) = device.motion()? {
            simulated.set_motion(Timestamp::ZERO, motion);
        }
        if let Some(other) = device.bit_rate.filter(|&rate| rate != bit_rate) {
            simulated.set_bit_rate(other);
        }
        devices.push((simulated, Attached { model, node, firmware: device.firmware }));
    }
    Ok((bit_rate, devices))
}

impl FromStr for BusAddress {
    type Err = BusError;

    fn from_str(address: &str) -> Result<Self, BusError> {
        let parsed = match address.split_once(':') {
            Some(("sim", rest)) => simulated::parse(rest).map(BusAddress::Simulated),
            Some(("slcan", rest)) => slcan(rest),
            Some(("pcan", rest)) => pcan(rest),
            Some(("python", rest)) => python(rest),
            Some(("socketcan", interface)) => socketcan(interface),
            Some(("socketcand", rest)) => network(rest, |text| Carrier::socketcand(behind_slashes(text))),
            Some(("cannelloni", rest)) => network(rest, Carrier::cannelloni),
            Some(("udp", rest)) => network(rest, |text| Carrier::multicast(behind_slashes(text))),
            None => socketcan(address),
            Some((kind, _)) => Err(format!(
                "expected socketcan:INTERFACE, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE, \
                 python:INTERFACE:CHANNEL[@BITRATE], socketcand://HOST/INTERFACE, cannelloni:tcp://HOST, \
                 cannelloni:udp://HOST, udp://GROUP or sim:MODEL[@BITRATE][+FAULT...], found \"{kind}:\""
            )),
        };
        parsed.map_err(|reason| BusError::Address { address: address.to_owned(), reason })
    }
}

/// `INTERFACE:CHANNEL[@BITRATE]`.
fn python(text: &str) -> Result<BusAddress, String> {
    let (named, bit_rate) = match text.rsplit_once('@') {
        Some((named, rate)) => (named, Some(parse_bit_rate(rate)?)),
        None => (text, None),
    };
    let parts = named.split_once(':').filter(|(interface, channel)| !interface.is_empty() && !channel.is_empty());
    let (interface, channel) =
        parts.ok_or_else(|| format!("expected python:INTERFACE:CHANNEL[@BITRATE], found \"python:{text}\""))?;
    Ok(BusAddress::Python { interface: interface.to_owned(), channel: channel.to_owned(), bit_rate })
}

/// An address over a network, with `@BITRATE` behind it or without.
fn network(text: &str, parse: fn(&str) -> Result<Carrier, String>) -> Result<BusAddress, String> {
    let (text, bit_rate) = match text.rsplit_once('@') {
        Some((text, rate)) => (text, Some(parse_bit_rate(rate)?)),
        None => (text, None),
    };
    Ok(BusAddress::Network(NetworkAddress { carrier: parse(text)?, bit_rate }))
}

fn behind_slashes(text: &str) -> &str {
    text.strip_prefix("//").unwrap_or(text)
}

fn socketcan(interface: &str) -> Result<BusAddress, String> {
    // Linux limits names to IFNAMSIZ: 16 bytes with the terminating zero.
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

fn pcan(rest: &str) -> Result<BusAddress, String> {
    const LISTEN_ONLY: &str = "+listen-only";
    let (rest, listen_only) = match rest.split_once('+') {
        None => (rest, false),
        Some((rest, "listen-only")) => (rest, true),
        Some((_, other)) => return Err(format!("expected {LISTEN_ONLY} or nothing, found \"+{other}\"")),
    };
    let Some((channel, rate)) = rest.split_once('@') else {
        return Err(format!("expected a bit rate too, such as pcan:{rest}@250k: the adapter has none of its own"));
    };
    let (channel, bit_rate) = (channel.parse()?, parse_bit_rate(rate)?);
    Ok(BusAddress::Pcan(Opening { channel, bit_rate, listen_only }))
}

/// The highest bit rate of classical CAN.
const HIGHEST_BIT_RATE: u32 = 1_000_000;

/// Parses a bit rate in bit/s, 1000 to 1 000 000, with an optional `k` or `M`.
///
/// # Errors
/// What was expected, and what was found.
pub fn parse_bit_rate(text: &str) -> Result<u32, String> {
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
        assert!(matches!("pcan:PCAN_USBBUS1@250k".parse(), Ok(BusAddress::Pcan(Opening {
            channel, bit_rate: 250_000, listen_only: false })) if channel.to_string() == "PCAN_USBBUS1"));
        assert!(matches!("pcan:usbbus2@1M+listen-only".parse(), Ok(BusAddress::Pcan(Opening {
            channel, bit_rate: 1_000_000, listen_only: true })) if channel.to_string() == "PCAN_USBBUS2"));
        assert!(matches!(
            "socketcand://pi/can0@250k".parse(),
            Ok(BusAddress::Network(NetworkAddress { carrier: Carrier::Socketcand { .. }, bit_rate: Some(250_000) }))
        ));
        assert!(matches!(
            "cannelloni:udp://pi".parse(),
            Ok(BusAddress::Network(NetworkAddress { carrier: Carrier::CannelloniUdp { .. }, bit_rate: None }))
        ));
        assert!(matches!(
            "udp://239.74.163.2@1M".parse(),
            Ok(BusAddress::Network(NetworkAddress { carrier: Carrier::Multicast { .. }, bit_rate: Some(1_000_000) }))
        ));
        assert!(matches!("sim:kuebler-sendix-58x8@1M+boot-up-twice".parse(),
            Ok(BusAddress::Simulated(devices)) if devices[0].bit_rate == Some(1_000_000)));
    }

    #[test]
    fn several_devices_on_one_bus() {
        let mut opened = open("sim:kuebler-sendix-58x8@500k~rpm=10+kuebler-sendix-58x8:5").unwrap();
        let nodes: Vec<u8> = opened.devices.iter().filter_map(|device| device.node).map(NodeId::raw).collect();
        assert_eq!(
            (nodes, opened.node().map(NodeId::raw), opened.bus.bit_rate()),
            (vec![63, 5], Some(63), Some(500_000))
        );
        let second = Timestamp(1_000_000_000);
        let boots = std::iter::from_fn(|| opened.bus.receive(second).unwrap()).map(|record| record.frame.to_string());
        assert_eq!(boots.collect::<Vec<_>>(), ["705#00", "73F#00"]);
    }

    #[test]
    fn a_device_that_is_alone_takes_the_node_id_that_it_is_given() {
        let node = |address: &str| open_seeded_at(address, 0, NodeId::new(5)).unwrap().node().map(NodeId::raw);
        assert_eq!((node("sim:kuebler-sendix-58x8"), node("sim:kuebler-sendix-m58")), (Some(5), Some(5)));
        assert_eq!(node("sim:kuebler-sendix-58x8:63"), Some(63), "the address decides");
        assert_eq!(node("sim:kuebler-sendix-58x8:255"), None);
        assert_eq!(node("sim:kuebler-sendix-58x8+kuebler-sendix-58x8"), Some(63), "it would not tell which of them");
    }

    #[test]
    fn errors_say_what_would_be_right() {
        assert!(reason("sim:nonsense").contains("kuebler-sendix-58x8"), "{}", reason("sim:nonsense"));
        assert!(reason("sim:kuebler-sendix-58x8+nonsense").contains("canvass list faults"));
        assert!(reason("sim:kuebler-sendix-58x8@9").contains("250k"));
        assert!(reason("sim:kuebler-sendix-58x8@2M").contains("1M"));
        assert!(reason("kvaser:1").contains("socketcan:") && reason("kvaser:1").contains("pcan:"));
        assert!(reason("pcan:PCAN_USBBUS1").contains("pcan:PCAN_USBBUS1@250k"));
        assert!(reason("pcan:1@250k").contains("PCAN_USBBUS1") && reason("pcan:PCAN_USBBUS1@9").contains("250k"));
        assert!(reason("pcan:PCAN_USBBUS1@250k+silent").contains("+listen-only"));
        assert!(reason("").contains("can0") && reason("slcan:").contains("slcan:/dev/ttyACM0"));
    }

    #[test]
    fn buses_that_are_not_there() {
        assert!(open("no-such-can0").is_err());
        assert!(open("slcan:/dev/no-such-port").unwrap_err().to_string().contains("/dev/no-such-port"));
        assert!(open("sim:kuebler-sendix-58x8").unwrap().model.is_some());
    }
}
