//! A frame with its time in the form of PCAN-Basic: `TPCANMsg` and `TPCANTimestamp`.

use crate::pcan::Status;
use canvass_traces::{CanId, ErrorClass, Frame, Timestamp};

/// A message in the layout of `TPCANMsg`.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Message {
    pub id: u32,
    /// The bits of the message's type, see [`kind`].
    pub kind: u8,
    /// The data length code, 0 to 8.
    pub length: u8,
    pub data: [u8; 8],
}

/// A time stamp in the layout of `TPCANTimestamp`.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Stamp {
    pub millis: u32,
    /// Number of overflows of `millis`.
    pub overflows: u16,
    /// Microseconds, 0 to 999.
    pub micros: u16,
}

/// The bits of a message's type.
pub(super) mod kind {
    pub const REMOTE: u8 = 0x01;
    pub const EXTENDED: u8 = 0x02;
    /// This channel itself sent the frame.
    pub const ECHO: u8 = 0x20;
    pub const ERROR: u8 = 0x40;
    pub const STATUS: u8 = 0x80;
}

/// The content of a message.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Content {
    /// A data, remote or error frame.
    Frame(Frame),
    /// The state of the bus or of a queue.
    Status(Status),
    /// The library has not filled the message, or its content is no classical frame.
    Nothing,
}

impl Message {
    /// A message that no library writes. If it is unchanged after a call, the library has not filled it.
    pub(crate) const UNTOUCHED: Self = Self { id: u32::MAX, kind: u8::MAX, length: u8::MAX, data: [u8::MAX; 8] };

    /// The message for sending a data or remote frame; `None` for other frames.
    pub(crate) fn to_send(frame: &Frame) -> Option<Self> {
        if frame.is_error() || frame.is_fd() || frame.is_xl() || frame.is_head() {
            return None;
        }
        let id = frame.id();
        let extended = if id.is_extended() { kind::EXTENDED } else { 0 };
        let remote = if frame.is_remote() { kind::REMOTE } else { 0 };
        let length = u8::try_from(frame.len()).ok()?;
        Some(Self { id: id.raw(), kind: extended | remote, length, data: frame.bytes() })
    }

    pub fn content(&self) -> Content {
        if *self == Self::UNTOUCHED {
            return Content::Nothing;
        }
        if self.kind & kind::STATUS != 0 {
            let [a, b, c, d, ..] = self.data;
            return Content::Status(Status(u32::from_be_bytes([a, b, c, d])));
        }
        self.frame().map_or(Content::Nothing, Content::Frame)
    }

    fn frame(&self) -> Option<Frame> {
        if self.kind & kind::ERROR != 0 {
            return self.error_frame();
        }
        let id = if self.kind & kind::EXTENDED != 0 { CanId::extended(self.id)? } else { CanId::standard(self.id)? };
        if self.kind & kind::REMOTE != 0 {
            return Frame::remote(id, self.length);
        }
        Frame::new(id, self.data.get(..usize::from(self.length))?)
    }

    /// This message as an error frame in Linux's form. The message holds the controller's error code capture: the
    /// identifier is the kind of error, the first byte the direction, the second byte the position in the frame. Two
    /// further bytes are the error counters.
    fn error_frame(&self) -> Option<Frame> {
        const COUNTERS: u32 = 0x200;
        const BUS_ERROR: u32 = 0x80;
        const NO_ACKNOWLEDGEMENT: u32 = 0x20;
        const PROTOCOL: u32 = 0x08;
        const ACKNOWLEDGE_SLOT: u8 = 25;
        let [direction, place, receive, transmit, ..] = self.data;
        let is_transmitting = direction == 0;
        // The error is a bit error, a form error, a stuff error, or another error.
        let violation = match self.id {
            1 => 0x01,
            2 => 0x02,
            4 => 0x04,
            _ => 0,
        };
        let class = match self.id {
            0 => COUNTERS,
            _ if is_transmitting && place == ACKNOWLEDGE_SLOT => COUNTERS | BUS_ERROR | NO_ACKNOWLEDGEMENT,
            _ => COUNTERS | BUS_ERROR | PROTOCOL,
        };
        let told = class & PROTOCOL != 0;
        let violation = if told { violation | if is_transmitting { 0x80 } else { 0 } } else { 0 };
        // Linux numbers the positions like the controller does.
        let place = if told { place } else { 0 };
        Frame::error(ErrorClass(class), &[0, 0, violation, place, 0, 0, transmit, receive])
    }
}

/// Whether an error frame reports an error, not only the error counters.
pub(super) fn is_error(frame: &Frame) -> bool {
    frame.error_class().is_some_and(|class| class.0 != 0x200)
}

impl Stamp {
    /// The time on the library's clock, whose origin is arbitrary.
    pub fn time(self) -> Timestamp {
        let millis = u64::from(self.millis) + (u64::from(self.overflows) << 32);
        Timestamp((millis * 1_000 + u64::from(self.micros)) * 1_000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_frame() -> impl Strategy<Value = Frame> {
        let id = prop_oneof![
            (0..0x800_u32).prop_map(CanId::standard_masked),
            (0..0x2000_0000_u32).prop_map(CanId::extended_masked)
        ];
        let data = (id.clone(), prop::collection::vec(any::<u8>(), 0..=8))
            .prop_map(|(id, data)| Frame::new(id, &data).unwrap());
        prop_oneof![data, (id, 0..=8_u8).prop_map(|(id, len)| Frame::remote(id, len).unwrap())]
    }

    proptest! {
        #[test]
        fn frames_are_received_as_they_were_sent(frame in any_frame()) {
            let message = Message::to_send(&frame).unwrap();
            prop_assert_eq!(message.content(), Content::Frame(frame));
        }

        /// Checks any message that a library may write.
        #[test]
        fn no_message_is_taken_for_what_it_is_not(id: u32, kind: u8, length: u8, data: [u8; 8]) {
            let message = Message { id, kind, length, data };
            if let Content::Frame(frame) = message.content() {
                prop_assert!(frame.is_error() == (kind & kind::ERROR != 0) && frame.len() <= 8);
                prop_assert!(frame.is_error() || frame.id().raw() == id);
            }
        }
    }

    #[test]
    fn what_was_not_filled_is_no_frame() {
        assert_eq!(Message::UNTOUCHED.content(), Content::Nothing);
        let empty = Message { id: 0x800, kind: 0, length: 0, data: [0; 8] };
        assert_eq!(empty.content(), Content::Nothing, "an identifier of 11 bits is below 800h");
        assert_eq!(Message { id: 1, length: 9, ..empty }.content(), Content::Nothing);
    }

    #[test]
    fn a_status_message_tells_the_status() {
        let message = Message { id: 1, kind: kind::STATUS, length: 4, data: [0, 4, 0, 0x40, 9, 9, 9, 9] };
        assert_eq!(message.content(), Content::Status(Status::BUS_PASSIVE.and(Status::QUEUE_OVERRUN)));
    }

    #[test]
    fn error_frames_have_the_form_of_linux() {
        let error = |id, direction, place| {
            let data = [direction, place, 3, 136, 0, 0, 0, 0];
            let frame = match (Message { id, kind: kind::ERROR, length: 4, data }).content() {
                Content::Frame(frame) => frame,
                other => panic!("{other:?}"),
            };
            (frame.error_class().unwrap().0, frame.data().to_vec(), is_error(&frame))
        };
        // A stuff error in the data of a frame that this controller received.
        assert_eq!(error(4, 1, 10), (0x288, vec![0, 0, 0x04, 10, 0, 0, 136, 3], true));
        // A bit error in the identifier of a frame that this controller sent.
        assert_eq!(error(1, 0, 2), (0x288, vec![0, 0, 0x81, 2, 0, 0, 136, 3], true));
        // No node has acknowledged.
        assert_eq!(error(8, 0, 25), (0x2A0, vec![0, 0, 0, 0, 0, 0, 136, 3], true));
        assert_eq!(error(0, 0, 0), (0x200, vec![0, 0, 0, 0, 0, 0, 136, 3], false));
    }

    #[test]
    fn times_go_on_over_the_overflow_of_their_milliseconds() {
        let time = |millis, overflows, micros| Stamp { millis, overflows, micros }.time().0;
        assert_eq!(time(1, 0, 2), 1_002_000);
        assert_eq!(time(0, 1, 0) - time(u32::MAX, 0, 999), 1_000);
    }
}
