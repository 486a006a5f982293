//! The behaviour of a device, as data: verdicts compare it, manuals and waivers name it, and reports turn it into text.
//!
//! - [`Subject`]: the part of the device concerned, such as an object;
//! - [`Observation`]: the behaviour observed, such as an abort code, a value or silence;
//! - [`Pattern`]: the observations that a manual or a waiver accepts.

mod pattern;
mod subject;

pub use pattern::{BadPattern, Pattern};
pub use subject::{BadSubject, Subject};

use crate::client::Violation;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Frame, hex};
use std::borrow::Cow;
use std::fmt;

/// An observed behaviour of a device.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Observation {
    /// No response.
    Silence,
    /// The service was confirmed.
    Confirmation,
    /// An SDO server ended the transfer with this code.
    Abort(AbortCode),
    /// The bytes of a value, in the order on the bus.
    Value(Vec<u8>),
    /// A number that the device shows: a count in a message, a bit field, a node-ID.
    Number(u64),
    /// The NMT state that the device shows.
    State(State),
    /// A boot-up message.
    BootUp,
    /// An EMCY message with this error code.
    Emcy(EmcyCode),
    /// The error code of an LSS or LMT confirmation; 0 is success.
    ErrorCode(u8),
    /// A span of time.
    Time(Duration),
    /// A number of frames, events or objects.
    Count(u64),
    /// An unexpected frame.
    Frame(Frame),
    /// A response that breaks the SDO protocol.
    Violation(Violation),
    /// Another behaviour, by a fixed name.
    Named(Cow<'static, str>),
}

impl Observation {
    /// Another behaviour, by a fixed name.
    pub const fn named(name: &'static str) -> Self {
        Self::Named(Cow::Borrowed(name))
    }

    /// Whether the observation depends on a moment in time, so that a late tester's machine may have caused it.
    pub const fn depends_on_time(&self) -> bool {
        matches!(self, Self::Silence | Self::Time(_) | Self::Count(_))
    }

    /// The name of the observation's sort, in JSON and in patterns.
    pub fn sort(&self) -> &str {
        match self {
            Self::Silence => "silence",
            Self::Confirmation => "confirmation",
            Self::Abort(_) => "abort",
            Self::Value(_) => "value",
            Self::Number(_) => "number",
            Self::State(_) => "state",
            Self::BootUp => "boot-up",
            Self::Emcy(_) => "EMCY",
            Self::ErrorCode(_) => "error code",
            Self::Time(_) => "time",
            Self::Count(_) => "count",
            Self::Frame(_) => "frame",
            Self::Violation(_) => "violation",
            Self::Named(name) => name,
        }
    }
}

/// The observation in the form of a [`Pattern`]: `abort 0609 0030h`, `value 05 00`, `silence`.
impl fmt::Display for Observation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sort = self.sort();
        match self {
            Self::Silence | Self::Confirmation | Self::BootUp | Self::Named(_) => f.write_str(sort),
            Self::Abort(code) => write!(f, "{sort} {}", code.digits()),
            Self::Value(bytes) if bytes.is_empty() => f.write_str(sort),
            Self::Value(bytes) => write!(f, "{sort} {}", hex::spaced(bytes)),
            Self::Number(number) => write!(f, "{sort} {number}"),
            Self::State(state) => write!(f, "{sort} {state}"),
            Self::Emcy(code) => write!(f, "{sort} {:04X}h", code.0),
            Self::ErrorCode(code) => write!(f, "{sort} {code}"),
            Self::Time(span) => write!(f, "{sort} {span}"),
            Self::Count(count) => write!(f, "{sort} {count}"),
            Self::Frame(frame) => write!(f, "{sort} {frame}"),
            Self::Violation(violation) => write!(f, "{sort} {}", violation.name()),
        }
    }
}
