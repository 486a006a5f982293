//! The sorts of messages: what the wire layer lists, by service, side and name.

use canvass_analyzer::message::Message;
use canvass_analyzer::wire::error_control::{ErrorControl, GUARDING};
use canvass_analyzer::wire::flying_master::FlyingMaster;
use canvass_analyzer::wire::nmt::{Command, Nmt};
use canvass_analyzer::wire::sdo::{BlockSegment, Request, Response};
use canvass_analyzer::wire::sync::Sync;
use canvass_analyzer::wire::time::TimeOfDay;
use canvass_analyzer::wire::{Field, Fields, Layout, emcy, lmt, lss, pdo};

/// A sort of message.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Sort {
    /// The service and its side: `sdo-request`.
    pub group: &'static str,
    name: &'static str,
    /// The fields of the message.
    pub fields: &'static [Field],
}

/// When a PDO is sent.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Trigger {
    /// At every n-th SYNC: types 1 to 240.
    Cyclic(u8),
    /// At the SYNC after an event: type 0.
    Acyclic,
    /// By the event timer: types 254 and 255.
    Timer,
    /// By events only: types 254 and 255.
    Event,
    /// On a remote frame: type 253.
    Remote,
    /// Sampled at SYNC, sent on a remote frame: type 252.
    RemoteSync,
}

impl Trigger {
    const ALL: [Self; 7] =
        [Self::Cyclic(1), Self::Cyclic(4), Self::Acyclic, Self::Timer, Self::Event, Self::Remote, Self::RemoteSync];

    /// The transmission type.
    pub const fn transmission_type(self) -> u8 {
        match self {
            Self::Cyclic(count) => count,
            Self::Acyclic => 0,
            Self::Timer => 254,
            Self::Event => 255,
            Self::Remote => 253,
            Self::RemoteSync => 252,
        }
    }

    /// Whether SYNC triggers the PDO.
    pub const fn is_synchronous(self) -> bool {
        matches!(self, Self::Cyclic(_) | Self::Acyclic)
    }

    const fn rpdo(self) -> &'static str {
        match self {
            Self::Cyclic(_) => "RPDO cyclic synchronous",
            Self::Acyclic => "RPDO acyclic synchronous",
            Self::Timer => "RPDO event timer",
            Self::Event | Self::Remote | Self::RemoteSync => "RPDO event",
        }
    }

    const fn tpdo(self) -> &'static str {
        match self {
            Self::Cyclic(1) => "TPDO at every SYNC",
            Self::Cyclic(_) => "TPDO at every n-th SYNC",
            Self::Acyclic => "TPDO acyclic synchronous",
            Self::Timer => "TPDO event timer",
            Self::Event => "TPDO event",
            Self::Remote => "TPDO remote",
            Self::RemoteSync => "TPDO remote synchronous",
        }
    }
}

const fn layout(group: &'static str, layout: &'static Layout) -> Sort {
    Sort { group, name: layout.name, fields: layout.fields }
}

const fn named(group: &'static str, name: &'static str) -> Sort {
    Sort { group, name, fields: &[] }
}

const fn pdo(name: &'static str) -> Sort {
    Sort { group: "pdo", name, fields: pdo::PDO.fields }
}

impl Sort {
    /// The remote frame of node guarding.
    pub const GUARDING_REQUEST: Self = named("error-control", "guarding request");
    /// The remote frame that asks for a PDO.
    pub const PDO_REQUEST: Self = named("pdo", "PDO request");
    /// A multiplexed PDO.
    pub const MPDO: Self = pdo("MPDO");
    /// A frame of an SRDO.
    pub const SRDO: Self = named("srdo", "SRDO");
    /// The global fail-safe command.
    pub const GLOBAL_FAIL_SAFE: Self = named("srdo", "global fail-safe");
    /// An error frame.
    pub const ERROR_FRAME: Self = named("error-frame", "error frame");
    /// All that one node sends: its supply, its wire.
    pub const ALL_OF_A_NODE: Self = named("node", "everything");

    /// The answer to a guarding request.
    pub const fn guarding() -> Self {
        layout("error-control", &GUARDING)
    }

    /// A segment of a block upload.
    pub const fn block_upload() -> Self {
        layout("sdo-upload", BlockSegment::LAYOUTS[0])
    }

    /// A segment of a block download.
    pub const fn block_download() -> Self {
        layout("sdo-download", BlockSegment::LAYOUTS[0])
    }

    /// An NMT command; `None` for a reserved command specifier.
    pub fn nmt(command: Command) -> Option<Self> {
        Some(Self { name: command.name()?, ..layout("nmt", Nmt::LAYOUTS[0]) })
    }

    /// A TPDO with this trigger.
    pub const fn tpdo(trigger: Trigger) -> Self {
        pdo(trigger.tpdo())
    }

    /// An RPDO that its producer sends with this trigger.
    pub const fn rpdo(trigger: Trigger) -> Self {
        pdo(trigger.rpdo())
    }

    /// A boot-up message or a heartbeat.
    pub fn error_control(message: ErrorControl) -> Self {
        layout("error-control", message.layout())
    }

    /// A SYNC message.
    pub const fn sync() -> Self {
        layout("sync", Sync::LAYOUTS[0])
    }

    /// A TIME message.
    pub const fn time() -> Self {
        layout("time", TimeOfDay::LAYOUTS[0])
    }

    /// An EMCY message.
    pub const fn emcy() -> Self {
        layout("emcy", emcy::Emcy::LAYOUTS[0])
    }

    /// A request to an SDO server.
    pub fn sdo_request(request: &Request) -> Self {
        layout("sdo-request", request.layout())
    }

    /// A response of an SDO server.
    pub fn sdo_response(response: &Response) -> Self {
        layout("sdo-response", response.layout())
    }

    /// A message of a flying master.
    pub const fn flying_master(message: FlyingMaster) -> Self {
        named(
            "flying-master",
            match message {
                FlyingMaster::ActiveMaster { .. } => "active master",
                FlyingMaster::NegotiationRequest => "negotiation request",
                FlyingMaster::ActiveMasterRequest => "active master request",
                FlyingMaster::MasterDetected => "master detected",
                FlyingMaster::MasterDetectionRequest => "master detection request",
                FlyingMaster::ForceNegotiation => "force negotiation",
            },
        )
    }

    /// The sort of a layout of LSS or LMT.
    pub const fn layer_setting(group: &'static str, of: &'static Layout) -> Self {
        layout(group, of)
    }

    /// `sdo-request/initiate-upload`.
    pub fn id(&self) -> String {
        format!("{}/{}", self.group, self.name.to_lowercase().replace(' ', "-"))
    }

    /// Every sort: the messages of the wire layer, PDOs by their triggers, and a node as a whole.
    pub fn all() -> Vec<Self> {
        let known = |group, layouts: &[&'static Layout]| {
            let known = layouts.iter().filter(|of| of.name != "unknown");
            known.map(|of| layout(group, of)).collect::<Vec<_>>()
        };
        let mut all = [
            known("sdo-request", Request::LAYOUTS),
            known("sdo-response", Response::LAYOUTS),
            known("error-control", ErrorControl::LAYOUTS),
            known("lss-request", lss::Request::LAYOUTS),
            known("lss-response", lss::Response::LAYOUTS),
            known("lmt-request", lmt::Request::LAYOUTS),
            known("lmt-response", lmt::Response::LAYOUTS),
            Command::ALL.into_iter().filter_map(Self::nmt).collect(),
            Trigger::ALL.into_iter().map(Self::tpdo).collect(),
        ]
        .concat();
        all.extend([Self::block_upload(), Self::block_download(), Self::sync(), Self::time(), Self::emcy()]);
        all.extend([Trigger::Cyclic(1), Trigger::Acyclic, Trigger::Timer, Trigger::Event].map(Self::rpdo));
        all.extend([Self::GUARDING_REQUEST, Self::PDO_REQUEST, Self::MPDO]);
        all.extend([Self::SRDO, Self::GLOBAL_FAIL_SAFE, Self::ERROR_FRAME, Self::ALL_OF_A_NODE]);
        all.extend(FLYING_MASTERS.map(Self::flying_master));
        all
    }

    /// The sort of a decoded message. A PDO's trigger is not in the message: its sort is only `pdo`. `None` for frames
    /// that are no message of a service, and for markers of a test tool.
    pub fn of_message(message: &Message) -> Option<Self> {
        Some(match message {
            Message::Nmt(nmt) => return Self::nmt(nmt.command),
            Message::ErrorControl(message) => Self::error_control(*message),
            Message::GuardingRequest => Self::GUARDING_REQUEST,
            Message::Sync(_) => Self::sync(),
            Message::Time(_) => Self::time(),
            Message::Emcy(_) => Self::emcy(),
            Message::Pdo(_) => pdo("PDO"),
            Message::Mpdo(..) => Self::MPDO,
            Message::PdoRequest(_) => Self::PDO_REQUEST,
            Message::SdoRequest(request) => Self::sdo_request(request),
            Message::SdoResponse(response) => Self::sdo_response(response),
            Message::SdoBlockDownload(_) => Self::block_download(),
            Message::SdoBlockUpload(_) => Self::block_upload(),
            Message::LssRequest(request) => layout("lss-request", request.layout()),
            Message::LssResponse(response) => layout("lss-response", response.layout()),
            Message::LmtRequest(request) => layout("lmt-request", request.layout()),
            Message::LmtResponse(response) => layout("lmt-response", response.layout()),
            Message::Srdo(_) => Self::SRDO,
            Message::GlobalFailSafe => Self::GLOBAL_FAIL_SAFE,
            Message::FlyingMaster(message) => Self::flying_master(*message),
            Message::ErrorFrame(_) => Self::ERROR_FRAME,
            Message::CaseMarker(_)
            | Message::Malformed(..)
            | Message::Foreign
            | Message::UnexpectedRemote
            | Message::Unknown => return None,
        })
    }
}

/// A message of each kind of the flying master.
pub const FLYING_MASTERS: [FlyingMaster; 6] = [
    FlyingMaster::ActiveMaster { priority: 0, node: 127 },
    FlyingMaster::NegotiationRequest,
    FlyingMaster::ActiveMasterRequest,
    FlyingMaster::MasterDetected,
    FlyingMaster::MasterDetectionRequest,
    FlyingMaster::ForceNegotiation,
];
