//! EMCY messages have to be few and well-formed, and each error is reported once.

use super::nmt;
use super::{Violation, violation};
use crate::property::Property;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_traces::{Duration, Frame, Timestamp};

/// Within this time the same message again reports the same event.
const SAME_EVENT: Duration = Duration::from_millis(20);

/// More messages than this in one second are a storm.
const STORM: u32 = 100;

/// The EMCY messages seen so far.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    last: Option<(Timestamp, [u8; 8])>,
    /// The last frame that may have caused an error. Requests to the SDO server are excluded, as the server answers
    /// them.
    cause: Option<Frame>,
    /// Number of times that the cause was sent since the last EMCY, without another frame that may have ended the
    /// error.
    causes: u32,
    /// Number of allowed repetitions of the last EMCY: one for each further cause.
    again: u32,
    second: Timestamp,
    count: u32,
}

impl Watch {
    pub const fn new() -> Self {
        Self { last: None, cause: None, causes: 0, again: 0, second: Timestamp::ZERO, count: 0 }
    }

    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// The fuzzer has sent a frame, so that an error reported from now on may be a new error.
    pub fn provoked(&mut self, frame: &Frame, is_sdo: bool) {
        self.last = None;
        if !is_sdo {
            self.causes = if self.cause == Some(*frame) { self.causes.saturating_add(1) } else { 1 };
            self.cause = Some(*frame);
        }
    }

    /// Checks an EMCY message.
    ///
    /// # Errors
    /// [`Violation`] if the device must not send it.
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
        // Several errors can end at the same time.
        let is_reset = bytes[..2] == [0, 0];
        // A device with one code for all errors sends the same message for two of these errors.
        let is_generic = bytes[..2] == EmcyCode::GENERIC.0.to_le_bytes();
        let repeated = !is_reset
            && !is_generic
            && self.last.is_some_and(|(at, before)| before == bytes && now.since(at) < SAME_EVENT);
        if self.last.is_none() {
            self.again = self.causes.saturating_sub(1);
        }
        (self.last, self.causes) = (Some((now, bytes)), 0);
        if repeated && self.again > 0 {
            self.again -= 1;
        } else if repeated {
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

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::parse_frame;

    /// Whether EMCY 8240h (unexpected length of SYNC) may come `times` times after `causes` SYNC messages with a wrong
    /// length.
    fn come(causes: u32, times: u32) -> bool {
        let sync = frame("080#010203");
        let mut watch = Watch::new();
        (0..causes).for_each(|_| watch.provoked(&sync, false));
        reported(&mut watch, times)
    }

    fn reported(watch: &mut Watch, times: u32) -> bool {
        let (emcy, nmt) = (frame("08A#4082110000000000"), nmt::Slave::new(Duration::ZERO, true));
        (0..times).all(|n| watch.came(Timestamp(u64::from(n) * 1_000_000), &emcy, &nmt).is_ok())
    }

    fn frame(text: &str) -> Frame {
        parse_frame(text).unwrap().frame
    }

    #[test]
    fn each_cause_may_be_reported_once() {
        assert!(come(1, 1) && come(2, 2) && come(5, 3));
        assert!(!come(1, 2) && !come(2, 3));
    }

    #[test]
    fn after_a_right_frame_the_end_of_the_error_comes_first() {
        let mut watch = Watch::new();
        ["080#010203", "080#", "080#010203"].iter().for_each(|text| watch.provoked(&frame(text), false));
        assert!(!reported(&mut watch, 2));
    }

    #[test]
    fn a_request_to_the_sdo_server_is_no_cause() {
        let mut watch = Watch::new();
        (0..9).for_each(|_| watch.provoked(&frame("60A#4000100000000000"), true));
        assert!(!reported(&mut watch, 2));
    }
}
