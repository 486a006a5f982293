//! Single frames without context: typed, without state, without allocation.
//!
//! Each service is one file with the layout as in the standard, the typed message, the parser, the encoder and the
//! text. The context of a frame (its object, its transfer) belongs to the network.
//!
//! Illegal values are represented, not refused, as long as the message has a meaning: unknown command specifiers,
//! reserved codes and surplus bytes are kept, because a trace shows the real bus and a test must be able to send
//! them.

pub mod case_marker;
pub mod emcy;
pub mod error_control;
pub mod error_frame;
pub mod fields;
pub mod flying_master;
pub mod layer_setting;
pub mod lmt;
pub mod lss;
pub mod mpdo;
pub mod nmt;
pub mod pdo;
pub mod sdo;
pub mod srdo;
pub mod sync;
pub mod time;

pub use fields::{Field, Fields, Layout};

use canvass_traces::{CanId, Frame};
use nom::{IResult, Parser};

/// A message with a layout of at most eight bytes.
///
/// ```
/// use canvass_analyzer::Multiplexer;
/// use canvass_analyzer::wire::Wire;
/// use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};
///
/// let ask = Request::upload(Multiplexer::new(0x1018, 4)).to_frame(0x605);
/// assert_eq!(ask.to_string(), "605#4018100400000000");
/// let refused = Response::read(&[0x80, 0x18, 0x10, 0x04, 0x11, 0x00, 0x09, 0x06])?;
/// let Response::Abort(abort) = refused else { panic!("{refused:?}") };
/// assert_eq!(abort.code, AbortCode(0x0609_0011));
/// assert!(Response::read(&[0x80, 0x18]).is_err(), "too short to have a meaning");
/// # Ok::<(), canvass_analyzer::wire::Malformed>(())
/// ```
pub trait Wire: Sized {
    /// Reads the message from the start of a payload; returns also the remaining bytes.
    ///
    /// # Errors
    /// [`Malformed`] if the payload is too short to have a meaning.
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed>;

    /// Writes the message to the start of `buffer` and returns its length. Every byte up to that length is written.
    fn emit(&self, buffer: &mut [u8; 8]) -> usize;

    /// Reads the message from a payload; remaining bytes are ignored.
    ///
    /// # Errors
    /// As [`Wire::parse`].
    fn read(payload: &[u8]) -> Result<Self, Malformed> {
        match Self::parse(payload) {
            Ok((_, message)) => Ok(message),
            Err(nom::Err::Error(error) | nom::Err::Failure(error)) => Err(error.in_payload(payload.len())),
            Err(nom::Err::Incomplete(_)) => Err(Malformed::at_end("more bytes").in_payload(payload.len())),
        }
    }

    /// The message as a data frame with an 11-bit CAN-ID.
    fn to_frame(&self, cob_id: u16) -> Frame {
        let mut buffer = [0; 8];
        let len = self.emit(&mut buffer);
        debug_assert!(len <= 8, "a message has at most 8 bytes, found {len}");
        data_frame(CanId::standard_masked(u32::from(cob_id)), &buffer[..len.min(8)])
    }
}

/// A data frame with a payload of at most eight bytes.
fn data_frame(id: CanId, payload: &[u8]) -> Frame {
    let frame = Frame::new(id, payload);
    debug_assert!(frame.is_some(), "a classical frame has at most 8 bytes, found {}", payload.len());
    frame.unwrap_or_else(|| Frame::full(id, [0; 8]))
}

/// Why a payload has no meaning: it is too short for the form that its first bytes announce.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("byte {offset}: expected {expected}")]
pub struct Malformed {
    /// The offset of the error in the payload; during parsing, the number of remaining bytes.
    pub offset: usize,
    /// The expected bytes.
    pub expected: &'static str,
}

impl Malformed {
    const fn at_end(expected: &'static str) -> Self {
        Self { offset: 0, expected }
    }

    /// Turns the number of bytes left into an offset.
    const fn in_payload(self, len: usize) -> Self {
        Self { offset: len - self.offset, ..self }
    }
}

impl nom::error::ParseError<&[u8]> for Malformed {
    fn from_error_kind(input: &[u8], _: nom::error::ErrorKind) -> Self {
        Self { offset: input.len(), expected: "more bytes" }
    }

    fn append(_: &[u8], _: nom::error::ErrorKind, other: Self) -> Self {
        other
    }
}

/// Adds the expected text to a parser's errors.
fn named<'a, T>(
    expected: &'static str,
    mut parser: impl Parser<&'a [u8], Output = T, Error = Malformed>,
) -> impl Parser<&'a [u8], Output = T, Error = Malformed> {
    move |input| {
        parser.parse(input).map_err(|error: nom::Err<Malformed>| error.map(|error| Malformed { expected, ..error }))
    }
}

/// Up to seven bytes, filled up with zeros, and the rest.
fn tail_of(rest: &[u8]) -> ([u8; 7], &[u8]) {
    let (taken, rest) = rest.split_at(rest.len().min(7));
    let mut tail = [0; 7];
    tail[..taken.len()].copy_from_slice(taken);
    (tail, rest)
}

#[cfg(test)]
pub(crate) mod vectors {
    //! Checks of the parser and the encoder against the same static bytes.
    use super::*;

    /// Parses `bytes`, compares, encodes into a buffer of A5h, compares again.
    pub fn both_ways<M: Wire + PartialEq + std::fmt::Debug>(bytes: &[u8], message: M) {
        let mut buffer = [0xA5; 8];
        let len = message.emit(&mut buffer);
        assert_eq!(&buffer[..len], bytes, "{message:?}");
        assert_eq!(M::read(bytes), Ok(message), "{bytes:02X?}");
    }

    /// As [`both_ways`], for a message that fills its frame with reserved bytes. The parser leaves bytes after the
    /// message, and reads the message even if up to `reserved` of its last bytes are missing.
    pub fn whole<M: Wire + PartialEq + std::fmt::Debug + Copy>(bytes: [u8; 8], message: M, reserved: usize) {
        both_ways(&bytes, message);
        let longer = [&bytes[..], &[0xEE, 0xDD]].concat();
        assert_eq!(M::parse(&longer).map(|(rest, read)| (rest.to_vec(), read)), Ok((vec![0xEE, 0xDD], message)));
        for missing in 0..=reserved {
            let parsed = M::parse(&bytes[..8 - missing]).map(|(rest, read)| (rest.len(), read));
            assert_eq!(parsed, Ok((0, message)), "without {missing}");
        }
    }

    /// A message that was read from any bytes encodes to bytes that read as the same message.
    pub fn stable<M: Wire + PartialEq + std::fmt::Debug>(bytes: &[u8]) {
        if let Ok(message) = M::read(bytes) {
            let mut buffer = [0xA5; 8];
            let len = message.emit(&mut buffer);
            assert_eq!(M::read(&buffer[..len]).as_ref(), Ok(&message));
        }
    }
}
