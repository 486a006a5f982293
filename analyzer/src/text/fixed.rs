//! Fixed texts of frames: most frames of a bus have one, and need no formatting.

use super::Meaning;
use crate::message::{Message, PdoNumber, Service};
use crate::wire::error_control::{ErrorControl, State};
use crate::wire::sync::Sync;

impl Meaning<'_> {
    /// The text of the frame, if it is a fixed one.
    pub fn fixed(&self) -> Option<&'static str> {
        if self.decoded.violation.is_some() {
            return None;
        }
        match self.decoded.message {
            Message::ErrorControl(message) => error_control(self.decoded.service, message),
            Message::GuardingRequest => Some("guarding request"),
            Message::Sync(Sync { counter: None }) => Some("SYNC"),
            Message::Pdo(number) => self.pdo_without_mapping(number),
            Message::GlobalFailSafe => Some("global fail-safe command"),
            Message::UnexpectedRemote => Some("remote frame"),
            Message::Unknown => Some("no known use of this CAN-ID"),
            _ => None,
        }
    }

    /// The text of a predefined PDO with unknown mapping.
    fn pdo_without_mapping(&self, number: PdoNumber) -> Option<&'static str> {
        let node = self.decoded.node.and_then(|node| self.bus.node(node));
        if node.is_some_and(|node| node.known_layout(number).is_some()) {
            return None;
        }
        let texts = match number {
            PdoNumber::Transmit(_) => &TRANSMIT,
            PdoNumber::Receive(_) => &RECEIVE,
        };
        let of_number = texts.get(usize::from(number.number()).checked_sub(1)?)?;
        of_number.get(self.record.frame.data().len()).copied()
    }
}

const fn error_control(service: Service, message: ErrorControl) -> Option<&'static str> {
    match (service, message.state) {
        (Service::BootUp, _) => Some("boot-up"),
        (Service::Heartbeat, State::OPERATIONAL) => Some("heartbeat: operational"),
        (Service::Heartbeat, State::PRE_OPERATIONAL) => Some("heartbeat: pre-operational"),
        (Service::Heartbeat, State::STOPPED) => Some("heartbeat: stopped"),
        _ => None,
    }
}

/// The texts of one PDO, by its length.
macro_rules! by_length {
    ($pdo:literal) => {
        [
            concat!($pdo, ", no data"),
            concat!($pdo, ", 1 byte, mapping not known"),
            concat!($pdo, ", 2 bytes, mapping not known"),
            concat!($pdo, ", 3 bytes, mapping not known"),
            concat!($pdo, ", 4 bytes, mapping not known"),
            concat!($pdo, ", 5 bytes, mapping not known"),
            concat!($pdo, ", 6 bytes, mapping not known"),
            concat!($pdo, ", 7 bytes, mapping not known"),
            concat!($pdo, ", 8 bytes, mapping not known"),
        ]
    };
}

const TRANSMIT: [[&str; 9]; 4] =
    [by_length!("TPDO 1"), by_length!("TPDO 2"), by_length!("TPDO 3"), by_length!("TPDO 4")];
const RECEIVE: [[&str; 9]; 4] =
    [by_length!("RPDO 1"), by_length!("RPDO 2"), by_length!("RPDO 3"), by_length!("RPDO 4")];
