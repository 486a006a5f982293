//! The devices of a simulated bus, as an address names them.
//!
//! ```text
//! sim:DEVICE[+FAULT...][+DEVICE[+FAULT...]...]
//! DEVICE = MODEL|FILE[:NODE][@BITRATE][~MOTION][~~LIBERTY...]
//! ```
//!
//! `~~` adds a liberty to the device before it: a behaviour that the standard leaves free. `~~` may also follow a
//! fault. `+` adds a fault to the device before it, or one more device if the name of a model or of a device
//! description (`.eds`, `.dcf`, `.xdd`, `.xdc`) follows. The bit rate of the first device is that of the bus; another
//! device with a different bit rate does not understand the frames on the bus. `NODE` is 1 to 127, or 255 for a device
//! that waits for LSS to assign its node-ID. Without `NODE`, a device has the node-ID of its model or, if an earlier
//! device has that node-ID, the next free node-ID.

use super::parse_bit_rate;
use crate::models::{self, Model};
use crate::{Fault, Firmware, Liberties, Liberty, Motion, MotionSpec, UnknownLiberty};
use canvass_analyzer::NodeId;
use canvass_bus::BusError;
use canvass_traces::small_file::{self, OF_HAND};
use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;
use std::sync::{LazyLock, Mutex, PoisonError};

/// A device of a simulated bus, as the user typed it.
#[derive(Clone, Debug)]
pub struct SimulatedDevice {
    /// The model or description of the device.
    pub device: DeviceName,
    /// The node-ID, if the address gives one.
    pub node: Option<GivenNode>,
    /// The bit rate in bit/s, if the address gives one.
    pub bit_rate: Option<u32>,
    /// The motion of the measured quantity, if the address gives one.
    pub motion: Option<MotionSpec>,
    /// The faults and liberties of the firmware.
    pub firmware: Firmware,
}

/// A built-in model or a file.
#[derive(Clone, Debug)]
pub enum DeviceName {
    /// A built-in model.
    Model(&'static Model),
    /// The path of a device description.
    File(String),
}

/// The node-ID in an address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum GivenNode {
    /// A node-ID from 1 to 127.
    Id(NodeId),
    /// No node-ID: LSS must assign it.
    Unconfigured,
}

/// A device on a simulated bus.
#[derive(Clone, Copy, Debug)]
pub struct Attached {
    /// The model of the device.
    pub model: &'static Model,
    /// The node-ID; `None` while the device has none.
    pub node: Option<NodeId>,
    /// The faults and liberties of the firmware, including those of its description.
    pub firmware: Firmware,
}

/// Extensions of device descriptions.
const DESCRIPTIONS: [&str; 4] = [".eds", ".dcf", ".xdd", ".xdc"];

/// Parses the devices after `sim:` in an address; at least one.
///
/// # Errors
/// The error, and the expected form.
pub(super) fn parse(text: &str) -> Result<Vec<SimulatedDevice>, String> {
    let mut devices: Vec<SimulatedDevice> = Vec::new();
    let mut rest = Some(text);
    while let Some(text) = rest {
        let piece = text.split('+').next().unwrap_or(text);
        if let Some((name, after)) = name(text, piece) {
            let (options, next) = split_once(after, '+');
            devices.push(device(name, options)?);
            rest = next;
            continue;
        }
        let Some(device) = devices.last_mut() else { return Err(no_model(head(piece))) };
        let (id, liberties) = liberties(piece)?;
        let fault = Fault::from_str(id)
            .map_err(|error| if id.contains([':', '@', '~']) { no_model(head(id)) } else { error.to_string() })?;
        device.firmware.faults = device.firmware.faults.with(fault);
        device.firmware.liberties = liberties.iter().fold(device.firmware.liberties, |all, &one| all.with(one));
        rest = split_once(text, '+').1;
    }
    let given: Vec<NodeId> = devices.iter().filter_map(SimulatedDevice::given_id).collect();
    match given.iter().enumerate().find(|(n, node)| given.iter().take(*n).any(|other| other == *node)) {
        Some((_, node)) => Err(format!("expected one device for each node-ID, found two with node-ID {node}")),
        None => Ok(devices),
    }
}

/// Splits the text at the first `~~` into the device and its liberties.
fn liberties(text: &str) -> Result<(&str, Vec<Liberty>), String> {
    let mut pieces = text.split("~~");
    let head = pieces.next().unwrap_or_default();
    let found = pieces.map(|id| id.parse().map_err(|error: UnknownLiberty| error.to_string()));
    Ok((head, found.collect::<Result<_, _>>()?))
}

fn head(piece: &str) -> &str {
    piece.split([':', '@', '~']).next().unwrap_or(piece)
}

fn split_once(text: &str, at: char) -> (&str, Option<&str>) {
    text.split_once(at).map_or((text, None), |(before, after)| (before, Some(after)))
}

/// The device at the beginning of the text, and the rest; `None` for a fault.
fn name<'a>(text: &'a str, piece: &str) -> Option<(DeviceName, &'a str)> {
    let id = head(piece);
    if let Some(model) = Model::by_id(id) {
        return text.get(id.len()..).map(|after| (DeviceName::Model(model), after));
    }
    if Fault::from_str(piece.split("~~").next().unwrap_or(piece)).is_ok() {
        return None;
    }
    // A path may contain separators: it ends at the first extension that a separator follows.
    let lower = text.to_ascii_lowercase();
    let ends = DESCRIPTIONS.iter().flat_map(|ending| lower.match_indices(ending).map(|(at, _)| at + ending.len()));
    let end = ends
        .filter(|&end| text.get(end..).is_some_and(|rest| rest.is_empty() || rest.starts_with([':', '@', '~', '+'])))
        .min()?;
    Some((DeviceName::File(text.get(..end)?.to_owned()), text.get(end..)?))
}

fn no_model(found: &str) -> String {
    let models = match models::built_in() {
        Ok(models) => models,
        Err(unreadable) => return unreadable.to_string(),
    };
    let known: Vec<&str> = models.iter().map(Model::id).collect();
    format!("expected a device description (.eds) or one of the models {}, found \"{found}\"", known.join(", "))
}

/// Parses `:NODE` and `@BITRATE` in any order, `~MOTION`, `~~LIBERTY`.
fn device(device: DeviceName, options: &str) -> Result<SimulatedDevice, String> {
    let (options, liberties) = liberties(options)?;
    let firmware = liberties.into_iter().collect::<Liberties>().into();
    let mut named = SimulatedDevice { device, node: None, bit_rate: None, motion: None, firmware };
    // The motion comes last, because the name of its file may contain any character.
    let (options, motion) = split_once(options, '~');
    if let Some(motion) = motion {
        named.motion = Some(motion.parse().map_err(|error: crate::MotionError| error.to_string())?);
    }
    let mut rest = options;
    while let Some(kind) = rest.chars().next() {
        let after = rest.get(kind.len_utf8()..).unwrap_or_default();
        let end = after.find([':', '@']).unwrap_or(after.len());
        let (value, next) = (after.get(..end).unwrap_or_default(), after.get(end..).unwrap_or_default());
        match kind {
            ':' => named.node = Some(node(value)?),
            '@' => named.bit_rate = Some(parse_bit_rate(value)?),
            _ => return Err(format!("expected :NODE, @BITRATE, ~MOTION, ~~LIBERTY or +FAULT, found \"{rest}\"")),
        }
        rest = next;
    }
    Ok(named)
}

fn node(text: &str) -> Result<GivenNode, String> {
    match text.parse::<u8>() {
        Ok(255) => Ok(GivenNode::Unconfigured),
        Ok(raw) => NodeId::new(raw).map(GivenNode::Id).ok_or(()),
        Err(_) => Err(()),
    }
    .map_err(|()| format!("expected a node-ID from 1 to 127, or 255 for a device without one, found \"{text}\""))
}

impl SimulatedDevice {
    /// The given node-ID; `None` also for a device that waits for LSS.
    pub fn given_id(&self) -> Option<NodeId> {
        match self.node {
            Some(GivenNode::Id(node)) => Some(node),
            _ => None,
        }
    }

    /// The model; a description is read from its file.
    ///
    /// # Errors
    /// [`BusError::Address`] if the file can't be read.
    pub fn model(&self) -> Result<&'static Model, BusError> {
        match &self.device {
            DeviceName::Model(model) => Ok(model),
            DeviceName::File(path) => described(path).map_err(|reason| unreadable(path, &reason)),
        }
    }

    /// The motion, if given; its points are read from their file.
    ///
    /// # Errors
    /// [`BusError::Address`] if the file can't be read.
    pub fn motion(&self) -> Result<Option<Motion>, BusError> {
        Ok(match &self.motion {
            None => None,
            Some(MotionSpec::Known(motion)) => Some(motion.clone()),
            Some(MotionSpec::File(path)) => {
                let text = small_file::read_text(Path::new(path), OF_HAND);
                let text = text.map_err(|error| unreadable(path, &error.to_string()))?;
                Some(MotionSpec::from_csv(&text).map_err(|error| unreadable(path, &error.to_string()))?)
            }
        })
    }
}

fn unreadable(path: &str, reason: &str) -> BusError {
    BusError::Address { address: path.to_owned(), reason: reason.to_owned() }
}

/// The node-IDs of the devices: the given node-ID, else the model's or, if that is taken, the next free node-ID.
pub(super) fn assign(devices: &[(&SimulatedDevice, &'static Model)]) -> Vec<Option<NodeId>> {
    let mut taken: Vec<NodeId> = devices.iter().filter_map(|(device, _)| device.given_id()).collect();
    let assign = |(device, model): &(&SimulatedDevice, &'static Model)| match device.node {
        Some(GivenNode::Id(node)) => Some(node),
        Some(GivenNode::Unconfigured) => None,
        None => {
            let own = model.default_node()?;
            let after = (own.raw()..=127).chain(1..own.raw()).filter_map(NodeId::new);
            let free = after.into_iter().find(|node| !taken.contains(node))?;
            taken.push(free);
            Some(free)
        }
    };
    devices.iter().map(assign).collect()
}

/// Models of files live as long as the program, like the built-in models; each content is kept once.
static DESCRIBED: LazyLock<Mutex<Described>> = LazyLock::new(Mutex::default);

/// Models by path and content.
type Described = BTreeMap<(String, Vec<u8>), &'static Model>;

fn described(path: &str) -> Result<&'static Model, String> {
    let bytes = small_file::read(Path::new(path), OF_HAND).map_err(|error| error.to_string())?;
    let mut known = DESCRIBED.lock().unwrap_or_else(PoisonError::into_inner);
    let key = (path.to_owned(), bytes);
    if let Some(model) = known.get(&key) {
        return Ok(model);
    }
    let model: &'static Model = Box::leak(Box::new(Model::generic(path, &key.1).map_err(|error| error.to_string())?));
    known.insert(key, model);
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faults;

    const MODEL: &str = "kuebler-sendix-58x8";

    fn one(text: &str) -> SimulatedDevice {
        let devices = parse(&text.replace("MODEL", MODEL)).unwrap();
        assert_eq!(devices.len(), 1, "{text}");
        devices.into_iter().next().unwrap()
    }

    fn reason(text: &str) -> String {
        parse(&text.replace("MODEL", MODEL)).unwrap_err()
    }

    #[test]
    fn one_device_with_all_options() {
        let device = one("MODEL:5@1M~rpm=100+boot-up-twice+vendor-id-zero");
        assert_eq!((device.node, device.bit_rate), (Some(GivenNode::Id(NodeId::new(5).unwrap())), Some(1_000_000)));
        assert_eq!(device.motion, Some(MotionSpec::Known(Motion::constant(0, 100_000))));
        assert_eq!(device.firmware.faults, Faults::from(Fault::BootUpTwice).with(Fault::VendorIdZero));
        assert_eq!(one("MODEL@125000:255").node, Some(GivenNode::Unconfigured));
        assert_eq!(one("MODEL~sine=2,0.5").bit_rate, None);
    }

    #[test]
    fn several_devices() {
        let devices = parse(&format!("{MODEL}@250k+boot-up-twice+{MODEL}:9+a+b.eds+emcy-repeated")).unwrap();
        assert_eq!(devices.len(), 3);
        assert_eq!(devices[0].firmware.faults, Fault::BootUpTwice.into());
        assert_eq!(devices[1].firmware.faults, Faults::NONE);
        assert!(matches!(&devices[2].device, DeviceName::File(path) if path == "a+b.eds"));
        assert_eq!(devices[2].firmware.faults, Fault::EmcyRepeated.into());
    }

    #[test]
    fn liberties_stand_behind_what_they_belong_to() {
        let taken = |device: &SimulatedDevice| device.firmware.liberties.iter().collect::<Vec<_>>();
        let device = one("MODEL:5~rpm=100~~no-emcy~~self-start+boot-up-twice~~no-lss");
        assert_eq!(taken(&device), [Liberty::SelfStart, Liberty::NoEmcy, Liberty::NoLss]);
        assert_eq!((device.motion, device.firmware.faults), (one("MODEL~rpm=100").motion, Fault::BootUpTwice.into()));
        let devices = parse(&"MODEL~~no-emcy+MODEL+my.eds~~no-lss".replace("MODEL", MODEL)).unwrap();
        let each: Vec<_> = devices.iter().map(taken).collect();
        assert_eq!(each, [vec![Liberty::NoEmcy], vec![], vec![Liberty::NoLss]]);
        for wrong in ["MODEL~~nonsense", "MODEL~~", "MODEL+boot-up-twice~~nonsense"] {
            assert!(reason(wrong).contains("canvass list liberties"), "{wrong}: {}", reason(wrong));
        }
    }

    #[test]
    fn files_are_told_by_their_ending() {
        for (text, path) in
            [("C:\\my~device.EDS:4@1M", "C:\\my~device.EDS"), ("./a.eds.d/b.dcf+boot-up-twice", "./a.eds.d/b.dcf")]
        {
            assert!(matches!(&one(text).device, DeviceName::File(found) if found == path), "{text}");
        }
    }

    #[test]
    fn node_ids_are_assigned() {
        let devices = parse(&"MODEL+MODEL+MODEL:64+MODEL:255".replace("MODEL", MODEL)).unwrap();
        let known: Vec<_> = devices.iter().map(|device| (device, device.model().unwrap())).collect();
        assert_eq!(assign(&known), [NodeId::new(63), NodeId::new(65), NodeId::new(64), None]);
    }

    #[test]
    fn errors_say_what_would_be_right() {
        assert!(reason("nonsense@1M").contains(MODEL) && reason("").contains(MODEL));
        assert!(reason("MODEL+nonsense").contains("canvass list faults"));
        assert!(reason("MODEL+nonsense:5").contains(".eds"));
        assert!(reason("MODEL:0").contains("1 to 127") && reason("MODEL:300").contains("255"));
        assert!(reason("MODEL@2M").contains("1M") && reason("MODEL~spin").contains("rpm=60"));
        assert!(reason("MODEL:5+MODEL:5").contains("two with node-ID 5"));
        assert!(parse("missing.eds").unwrap()[0].model().unwrap_err().to_string().contains("missing.eds"));
    }
}
