//! The message in a frame: its service and content.

use crate::object;
use crate::wire::case_marker::CaseMarker;
use crate::wire::emcy::Emcy;
use crate::wire::error_control::ErrorControl;
use crate::wire::flying_master::FlyingMaster;
use crate::wire::mpdo::Mpdo;
use crate::wire::nmt::Nmt;
use crate::wire::sdo::BlockSegment;
use crate::wire::srdo::Srdo;
use crate::wire::sync::Sync;
use crate::wire::time::TimeOfDay;
use crate::wire::{Malformed, lmt, lss, sdo};
use canvass_traces::ErrorClass;
use std::fmt;

/// A frame's message, typed by its service. The service depends on the COB-IDs in use and, for SDO block segments and
/// guarding, on earlier frames.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Message {
    /// An NMT command.
    Nmt(Nmt),
    /// Boot-up, heartbeat, or the answer to a guarding request.
    ErrorControl(ErrorControl),
    /// A remote frame that requests the node's state.
    GuardingRequest,
    /// SYNC.
    Sync(Sync),
    /// TIME.
    Time(TimeOfDay),
    /// EMCY.
    Emcy(Emcy),
    /// Process data.
    Pdo(PdoNumber),
    /// A multiplexed PDO, which names its object.
    Mpdo(PdoNumber, Mpdo),
    /// A remote frame that requests a PDO.
    PdoRequest(PdoNumber),
    /// An SDO message from a client to a server.
    SdoRequest(sdo::Request),
    /// An SDO message from a server to a client.
    SdoResponse(sdo::Response),
    /// A segment of a block download (from the client).
    SdoBlockDownload(BlockSegment),
    /// A segment of a block upload (from the server).
    SdoBlockUpload(BlockSegment),
    /// A message from the LSS master.
    LssRequest(lss::Request),
    /// A message from an LSS slave.
    LssResponse(lss::Response),
    /// A message from the LMT master.
    LmtRequest(lmt::Request),
    /// A message from an LMT slave.
    LmtResponse(lmt::Response),
    /// Safety-relevant data.
    Srdo(Srdo),
    /// The global fail-safe command.
    GlobalFailSafe,
    /// A message by which masters agree on the active one.
    FlyingMaster(FlyingMaster),
    /// A marker at the beginning or end of a case in a certification run.
    CaseMarker(CaseMarker),
    /// The controller's report of an error on the bus.
    ErrorFrame(ErrorClass),
    /// The payload is too short for its service.
    Malformed(Service, Malformed),
    /// Not a message of classical CANopen: CAN FD, CAN XL or 29-bit identifier.
    Foreign,
    /// A remote frame on a CAN-ID for which CANopen defines none.
    UnexpectedRemote,
    /// A CAN-ID that no known service uses.
    Unknown,
}

/// A PDO by its direction, seen from the device that owns it, and its number from 1.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum PdoNumber {
    /// The device sends it; its parameters are at 1800h and 1A00h plus the number less 1.
    Transmit(u16),
    /// The device receives it; its parameters are at 1400h and 1600h plus the number less 1.
    Receive(u16),
}

/// The services, by the names of the JSON output.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Service {
    /// NMT commands.
    Nmt,
    /// Boot-up messages.
    BootUp,
    /// Heartbeats.
    Heartbeat,
    /// Node guarding: requests and answers.
    Guarding,
    /// SYNC.
    Sync,
    /// TIME.
    Time,
    /// EMCY.
    Emcy,
    /// PDOs and requests for them.
    Pdo,
    /// SDO requests and responses.
    Sdo,
    /// LSS.
    Lss,
    /// LMT (CiA DS-205).
    Lmt,
    /// Safety-relevant data (CiA 304).
    Srdo,
    /// Flying master (CiA 302).
    FlyingMaster,
    /// Error frames.
    ErrorFrame,
    /// Anything else.
    Unknown,
}

impl Service {
    /// All services.
    pub const ALL: [Self; 15] = [
        Self::Nmt,
        Self::BootUp,
        Self::Heartbeat,
        Self::Guarding,
        Self::Sync,
        Self::Time,
        Self::Emcy,
        Self::Pdo,
        Self::Sdo,
        Self::Lss,
        Self::Lmt,
        Self::Srdo,
        Self::FlyingMaster,
        Self::ErrorFrame,
        Self::Unknown,
    ];

    /// The name in JSON and filters.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nmt => "nmt",
            Self::BootUp => "boot-up",
            Self::Heartbeat => "heartbeat",
            Self::Guarding => "guarding",
            Self::Sync => "sync",
            Self::Time => "time",
            Self::Emcy => "emcy",
            Self::Pdo => "pdo",
            Self::Sdo => "sdo",
            Self::Lss => "lss",
            Self::Lmt => "lmt",
            Self::Srdo => "srdo",
            Self::FlyingMaster => "flying-master",
            Self::ErrorFrame => "error-frame",
            Self::Unknown => "unknown",
        }
    }
}

impl PdoNumber {
    /// The number, from 1.
    pub const fn number(self) -> u16 {
        match self {
            Self::Transmit(n) | Self::Receive(n) => n,
        }
    }

    /// The index of the communication parameters.
    pub const fn communication_index(self) -> u16 {
        match self {
            Self::Transmit(n) => object::TPDO_COMMUNICATION_PARAMETER + n - 1,
            Self::Receive(n) => object::RPDO_COMMUNICATION_PARAMETER + n - 1,
        }
    }

    /// The PDO whose communication parameters have this index.
    pub const fn of_communication_index(index: u16) -> Option<Self> {
        match index {
            0x1400..=0x15FF | 0x1800..=0x19FF => Self::of_mapping_index(index + 0x200),
            _ => None,
        }
    }

    /// The PDO whose mapping parameters have this index.
    pub(crate) const fn of_mapping_index(index: u16) -> Option<Self> {
        match index {
            0x1600..=0x17FF => Some(Self::Receive(index - object::RPDO_MAPPING_PARAMETER + 1)),
            0x1A00..=0x1BFF => Some(Self::Transmit(index - object::TPDO_MAPPING_PARAMETER + 1)),
            _ => None,
        }
    }

    /// The index of the mapping parameters.
    pub const fn mapping_index(self) -> u16 {
        self.communication_index() + 0x200
    }
}

impl fmt::Display for Service {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Writes `TPDO 1`, `RPDO 2`.
impl fmt::Display for PdoNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Transmit(n) => write!(f, "TPDO {n}"),
            Self::Receive(n) => write!(f, "RPDO {n}"),
        }
    }
}
