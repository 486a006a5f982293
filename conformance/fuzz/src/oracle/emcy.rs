//! EMCY messages: few, well-formed, each error once.

use super::nmt;
use super::{Violation, violation};
use crate::property::Property;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_traces::{Duration, Frame, Timestamp};

/// The same message again so soon is the same event.
const SAME_EVENT: Duration = Duration::from_millis(20);

/// More in a second than this is a storm.
const STORM: u32 = 100;

/// What was seen of EMCY.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    last: Option<(Timestamp, [u8; 8])>,
    second: Timestamp,
    count: u32,
}

impl Watch {
    pub const fn new() -> Self {
        Self { last: None, second: Timestamp::ZERO, count: 0 }
    }

    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// The fuzzer has sent something: an error that is reported from now on may be another one.
    pub const fn provoked(&mut self) {
        self.last = None;
    }

    /// An EMCY came.
    ///
    /// # Errors
    /// [`Violation`] if it must not.
    pub fn came(&mut self, now: Timestamp, frame: &Frame, nmt: &nmt::Slave) -> Result<(), Violation> {
        if frame.len() != 8 {
            let expected = "an EMCY of eight bytes";
            return Err(violation(Property::EmcyRate, "length of EMCY", expected, format!("{frame}"), now));
        }
        if !nmt.serves_emcy(now) {
            let expected = "no EMCY in stopped";
            return Err(violation(Property::Silent, "EMCY in stopped", expected, format!("{frame}"), now));
        }
        let bytes = frame.bytes();
        if bytes[..2] != [0, 0] && bytes[2] == 0 {
            let expected = "the error register in byte 2, in which at least one bit is set while there is an error";
            return Err(violation(Property::EmcyRate, "error register in EMCY", expected, format!("{frame}"), now));
        }
        // Several errors can be gone at the same time.
        let is_reset = bytes[..2] == [0, 0];
        // A device that has one code for all errors says the same of two of them.
        let is_generic = bytes[..2] == EmcyCode::GENERIC.0.to_le_bytes();
        let repeated = !is_reset
            && !is_generic
            && self.last.is_some_and(|(at, before)| before == bytes && now.since(at) < SAME_EVENT);
        self.last = Some((now, bytes));
        if repeated {
            let expected = "one EMCY for one event";
            return Err(violation(Property::EmcyRate, "EMCY repeated", expected, format!("{frame} again"), now));
        }
        if now.since(self.second) > Duration::from_secs(1) {
            (self.second, self.count) = (now, 0);
        }
        self.count += 1;
        if self.count > STORM {
            let expected = format!("at most {STORM} EMCY in a second");
            return Err(violation(Property::EmcyRate, "EMCY storm", expected, format!("{}", self.count), now));
        }
        Ok(())
    }
}
