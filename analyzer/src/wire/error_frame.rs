//! Error frames: reports of the recording machine's CAN controller about errors (`linux/can/error.h`).
//!
//! ```text
//! identifier: class bits
//! byte 0: bit of lost arbitration       byte 1: state of the controller
//! byte 2: protocol violation, type      byte 3: protocol violation, location
//! byte 4: state of the transceiver      byte 5: reserved
//! byte 6: transmit error counter        byte 7: receive error counter
//! ```
//!
//! Error frames were never on the bus. Tools other than those of Linux may leave all bytes of an error frame 0.

use canvass_traces::{ErrorClass, Frame};
use std::fmt;

/// An error frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct ErrorFrame {
    /// The class bits.
    pub class: ErrorClass,
    /// The detail, filled up with zeros.
    pub detail: [u8; 8],
}

/// The bits of byte 1, the state of the controller.
pub(crate) const CONTROLLER: [(u8, &str); 7] = [
    (0x01, "receive overflow"),
    (0x02, "transmit overflow"),
    (0x04, "receive warning level"),
    (0x08, "transmit warning level"),
    (0x10, "receive error passive"),
    (0x20, "transmit error passive"),
    (0x40, "error active again"),
];

/// The bits of byte 2, the type of a protocol violation.
pub(crate) const VIOLATION: [(u8, &str); 8] = [
    (0x01, "single bit error"),
    (0x02, "form error"),
    (0x04, "bit stuffing error"),
    (0x08, "unable to send a dominant bit"),
    (0x10, "unable to send a recessive bit"),
    (0x20, "bus overload"),
    (0x40, "active error announcement"),
    (0x80, "on transmission"),
];

/// The values of byte 3, where in the frame a protocol violation was.
pub(crate) const LOCATION: [(u8, &str); 19] = [
    (0x02, "identifier bits 28 to 21"),
    (0x03, "start of frame"),
    (0x04, "substitute RTR"),
    (0x05, "identifier extension"),
    (0x06, "identifier bits 20 to 18"),
    (0x07, "identifier bits 17 to 13"),
    (0x08, "CRC sequence"),
    (0x09, "reserved bit 0"),
    (0x0A, "data"),
    (0x0B, "data length code"),
    (0x0C, "RTR"),
    (0x0D, "reserved bit 1"),
    (0x0E, "identifier bits 4 to 0"),
    (0x0F, "identifier bits 12 to 5"),
    (0x12, "intermission"),
    (0x18, "CRC delimiter"),
    (0x19, "acknowledge slot"),
    (0x1A, "end of frame"),
    (0x1B, "acknowledge delimiter"),
];

/// The values of byte 4 for each of the two wires: CAN_H in the lower half, CAN_L in the upper.
const WIRE: [(u8, &str); 4] = [(4, "no wire"), (5, "short to battery"), (6, "short to supply"), (7, "short to ground")];

impl ErrorFrame {
    const LOST_ARBITRATION: u32 = 0x002;
    const CONTROLLER: u32 = 0x004;
    const PROTOCOL: u32 = 0x008;
    const TRANSCEIVER: u32 = 0x010;
    const COUNTERS: u32 = 0x200;

    /// The error that a frame reports; `None` if it is not an error frame.
    pub fn of(frame: &Frame) -> Option<Self> {
        frame.error_class().map(|class| Self { class, detail: frame.bytes() })
    }

    /// The controller's state, by its bits.
    pub fn controller(&self) -> impl Iterator<Item = &'static str> {
        names(&CONTROLLER, self.detail[1])
    }

    /// The type of a protocol violation, by its bits.
    pub fn violation(&self) -> impl Iterator<Item = &'static str> {
        names(&VIOLATION, self.detail[2])
    }

    /// The position of a protocol violation in the frame; `None` if unknown.
    pub fn location(&self) -> Option<&'static str> {
        LOCATION.iter().find(|row| row.0 == self.detail[3]).map(|row| row.1)
    }

    /// The transmit and receive error counters, if the frame has them. Kernels before 6.0 set them in reports of the
    /// controller's state without the announcing class bit.
    pub fn counters(&self) -> Option<(u8, u8)> {
        let [.., transmit, receive] = self.detail;
        let announced = self.has(Self::COUNTERS);
        let unannounced = self.has(Self::CONTROLLER) && (transmit, receive) != (0, 0);
        (announced || unannounced).then_some((transmit, receive))
    }

    const fn has(&self, class: u32) -> bool {
        self.class.0 & class != 0
    }

    /// The details of a class.
    fn detail(&self, class: u32, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match class {
            Self::LOST_ARBITRATION if self.detail[0] != 0 => write!(f, " in bit {}", self.detail[0]),
            Self::CONTROLLER => list(self.controller(), f),
            Self::PROTOCOL => {
                list(self.violation(), f)?;
                self.location().map_or(Ok(()), |location| write!(f, " at {location}"))
            }
            Self::TRANSCEIVER => self.transceiver(f),
            _ => Ok(()),
        }
    }

    fn transceiver(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = self.detail[4];
        let wire = |value: u8| WIRE.iter().find(|row| row.0 == value).map(|row| row.1);
        let high = wire(state & 0x0F).map(|name| format!("CAN_H {name}"));
        let low = match state >> 4 {
            8 => Some("CAN_L short to CAN_H".to_owned()),
            value => wire(value).map(|name| format!("CAN_L {name}")),
        };
        list([high, low].into_iter().flatten(), f)
    }
}

fn names(table: &'static [(u8, &'static str)], bits: u8) -> impl Iterator<Item = &'static str> {
    table.iter().filter(move |row| bits & row.0 != 0).map(|row| row.1)
}

/// A list ` (a, b)`, or nothing.
fn list(names: impl Iterator<Item = impl fmt::Display>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let mut empty = true;
    for name in names {
        write!(f, "{}{name}", if empty { " (" } else { ", " })?;
        empty = false;
    }
    if empty { Ok(()) } else { f.write_str(")") }
}

/// Writes `error frame: controller problem (transmit error passive), bus off, transmit errors 136, receive errors 0`.
impl fmt::Display for ErrorFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("error frame")?;
        let mut separator = ": ";
        for (class, name) in ErrorClass::NAMES {
            // The counters come at the end, with or without their class bit.
            if self.has(class) && class != Self::COUNTERS {
                write!(f, "{separator}{name}")?;
                self.detail(class, f)?;
                separator = ", ";
            }
        }
        match self.counters() {
            Some((transmit, receive)) => {
                write!(f, "{separator}transmit errors {transmit}, receive errors {receive}")
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(class: u32, detail: [u8; 8]) -> String {
        ErrorFrame { class: ErrorClass(class), detail }.to_string()
    }

    /// The texts give the same details as `candump -e`, in other words.
    #[test]
    fn classes_with_their_details() {
        assert_eq!(
            text(0x204, [0, 0x08, 0, 0, 0, 0, 0x60, 0]),
            "error frame: controller problem (transmit warning level), transmit errors 96, receive errors 0"
        );
        assert_eq!(
            text(0x004, [0, 0x30, 0, 0, 0, 0, 0x88, 0x80]),
            "error frame: controller problem (receive error passive, transmit error passive), \
             transmit errors 136, receive errors 128"
        );
        assert_eq!(
            text(0x088, [0, 0, 0x84, 0x0A, 0, 0, 0, 0]),
            "error frame: protocol violation (bit stuffing error, on transmission) at data, bus error"
        );
        assert_eq!(text(0x040, [0; 8]), "error frame: bus off");
        assert_eq!(text(0x100, [0; 8]), "error frame: controller restarted");
        assert_eq!(text(0x002, [11, 0, 0, 0, 0, 0, 0, 0]), "error frame: lost arbitration in bit 11");
        assert_eq!(text(0x002, [0; 8]), "error frame: lost arbitration");
        assert_eq!(
            text(0x010, [0, 0, 0, 0, 0x74, 0, 0, 0]),
            "error frame: transceiver status (CAN_H no wire, CAN_L short to ground)"
        );
        assert_eq!(text(0x010, [0, 0, 0, 0, 0x80, 0, 0, 0]), "error frame: transceiver status (CAN_L short to CAN_H)");
        assert_eq!(
            text(0x028, [0, 0, 0, 0x19, 0, 0, 0, 0]),
            "error frame: protocol violation at acknowledge slot, no acknowledgement"
        );
        assert_eq!(text(0, [0xFF; 8]), "error frame");
    }

    #[test]
    fn only_error_frames() {
        let data = Frame::new(canvass_traces::CanId::standard_masked(0x080), &[1, 2]).unwrap();
        assert_eq!(ErrorFrame::of(&data), None);
        let error = Frame::error(ErrorClass(0x004), &[0, 1]).unwrap();
        let read = ErrorFrame::of(&error).unwrap();
        assert_eq!((read.class, read.detail), (ErrorClass(4), [0, 1, 0, 0, 0, 0, 0, 0]));
        assert_eq!(read.counters(), None);
        assert!(LOCATION.is_sorted_by_key(|row| row.0));
    }
}
