//! The meaning of a frame as text: one line, for reading down a trace.

mod emcy;
mod escaped;
mod fixed;
mod object;
mod pdo;
mod sdo;
mod signal;
mod transfer;
mod value;

pub use emcy::EmcyText;
pub use signal::{Name, Number, SignalValue};
pub use transfer::TransferText;

use crate::message::{Message, Service};
use crate::network::{Bus, Decoded};
use crate::wire::emcy::Emcy;
use crate::wire::error_control::ErrorControl;
use crate::wire::error_frame::ErrorFrame;
use canvass_traces::{ErrorClass, Record};
use std::fmt;

/// The meaning of a frame as text. Text from the bus is escaped, so that the result never has control characters.
pub struct Meaning<'a> {
    record: &'a Record,
    decoded: &'a Decoded,
    bus: &'a Bus,
}

impl<'a> Meaning<'a> {
    /// The meaning of `record`, directly after it was decoded on `bus`.
    pub const fn new(record: &'a Record, decoded: &'a Decoded, bus: &'a Bus) -> Self {
        Self { record, decoded, bus }
    }

    fn error_control(&self, message: ErrorControl, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.decoded.service {
            Service::BootUp => f.write_str("boot-up"),
            Service::Guarding => write!(f, "guarding: {}, toggle {}", message.state, u8::from(message.toggle)),
            _ => write!(f, "heartbeat: {}", message.state),
        }
    }

    fn emcy(&self, emcy: &Emcy, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.decoded.node {
            Some(node) => write!(f, "EMCY {}", EmcyText::of(emcy, node, self.bus)),
            None => write!(f, "EMCY {emcy}"),
        }
    }

    fn malformed(&self, service: Service, offset: usize, expected: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let len = self.record.frame.len();
        write!(f, "malformed {service}: expected {expected} at byte {offset}, found {len} bytes in all")
    }

    fn error_frame(&self, class: ErrorClass, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error = ErrorFrame::of(&self.record.frame).unwrap_or(ErrorFrame { class, detail: [0; 8] });
        write!(f, "{error}")
    }

    fn foreign(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let frame = &self.record.frame;
        let kind = match () {
            () if frame.is_xl() => "CAN XL",
            () if frame.is_fd() => "CAN FD",
            () => "29-bit identifier",
        };
        write!(f, "{kind}: not classical CANopen")
    }
}

impl fmt::Display for Meaning<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(text) = self.fixed() {
            return f.write_str(text);
        }
        match &self.decoded.message {
            Message::Nmt(nmt) => write!(f, "{nmt}"),
            Message::ErrorControl(message) => self.error_control(*message, f),
            Message::GuardingRequest => f.write_str("guarding request"),
            Message::Sync(sync) => write!(f, "{sync}"),
            Message::Time(time) => write!(f, "TIME {time}"),
            Message::Emcy(emcy) => self.emcy(emcy, f),
            Message::Pdo(number) => self.pdo(*number, f),
            Message::Mpdo(number, mpdo) => self.mpdo(*number, mpdo, f),
            Message::PdoRequest(number) => write!(f, "{number} requested"),
            Message::SdoRequest(request) => self.sdo_request(request, f),
            Message::SdoResponse(response) => self.sdo_response(response, f),
            Message::SdoBlockDownload(segment) | Message::SdoBlockUpload(segment) => self.sdo_block(segment, f),
            Message::LssRequest(request) => write!(f, "LSS {request}"),
            Message::LssResponse(response) => write!(f, "LSS {response}"),
            Message::LmtRequest(request) => write!(f, "LMT {request}"),
            Message::LmtResponse(response) => write!(f, "LMT {response}"),
            Message::Srdo(srdo) => self.srdo(srdo, f),
            Message::GlobalFailSafe => f.write_str("global fail-safe command"),
            Message::FlyingMaster(message) => write!(f, "flying master: {message}"),
            Message::CaseMarker(marker) => write!(f, "CiA test tool: {marker}"),
            Message::ErrorFrame(class) => self.error_frame(*class, f),
            Message::Malformed(service, error) => self.malformed(*service, error.offset, error.expected, f),
            Message::Foreign => self.foreign(f),
            Message::UnexpectedRemote => f.write_str("remote frame"),
            Message::Unknown => f.write_str("no known use of this CAN-ID"),
        }?;
        match &self.decoded.violation {
            Some(violation) => write!(f, " [violation: {violation}]"),
            None => Ok(()),
        }
    }
}
