//! Case markers of CiA's conformance test tool (CAN-ID 7FFh): they mark the beginning and end of cases in a
//! certification run.
//!
//! ```text
//! 01 gg cc 00 00 00    case c of group g begins
//! 02 gg cc 00 vv 00    case c of group g ends with verdict v
//! ```
//!
//! The tool writes the markers into its log; nothing else in CANopen uses the CAN-ID.

use super::{Malformed, Wire, named};
use nom::{
    IResult, Parser,
    bytes::complete::tag,
    combinator::{eof, verify},
    number::complete::u8,
};
use std::fmt;

/// The CAN-ID of the markers.
pub const CAN_ID: u16 = 0x7FF;

/// The marker at the begin or end of a case.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct CaseMarker {
    /// The group, as the tool numbers it.
    pub group: u8,
    /// The case in the group.
    pub case: u8,
    /// The verdict; `None` at the beginning of a case.
    pub verdict: Option<Verdict>,
}

/// A verdict of the tool.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Verdict(pub u8);

impl Verdict {
    /// Passed.
    pub const PASS: Self = Self(1);
    /// Passed with a warning.
    pub const WARNING: Self = Self(3);
    /// Failed.
    pub const FAIL: Self = Self(4);
    /// Skipped.
    pub const SKIPPED: Self = Self(5);

    /// The verdict in a word, `None` for a number that is not known.
    pub const fn name(self) -> Option<&'static str> {
        Some(match self {
            Self::PASS => "pass",
            Self::WARNING => "warning",
            Self::FAIL => "fail",
            Self::SKIPPED => "skipped",
            _ => return None,
        })
    }
}

impl Wire for CaseMarker {
    /// Only the exact form is a marker: a frame of another form is another use of the CAN-ID.
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let zero = || named("a zero", tag([0_u8].as_slice()));
        let (rest, kind) = named("01 or 02", verify(u8, |kind| matches!(kind, 1 | 2))).parse(input)?;
        let (rest, (group, case, _)) = (named("a group", u8), named("a case", u8), zero()).parse(rest)?;
        let (rest, verdict) = match kind {
            1 => zero().map(|_| None).parse(rest)?,
            _ => named("a verdict", u8).map(|verdict| Some(Verdict(verdict))).parse(rest)?,
        };
        let (rest, _) = zero().parse(rest)?;
        let (rest, _) = named("no further bytes", eof).parse(rest)?;
        Ok((rest, Self { group, case, verdict }))
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        let (kind, verdict) = match self.verdict {
            None => (1, 0),
            Some(verdict) => (2, verdict.0),
        };
        buffer[..6].copy_from_slice(&[kind, self.group, self.case, 0, verdict, 0]);
        6
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "unknown verdict {}", self.0),
        }
    }
}

impl fmt::Debug for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Verdict({self})")
    }
}

/// Writes `case 7 of group 3 begins`, `case 7 of group 3 ends: pass`.
impl fmt::Display for CaseMarker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "case {} of group {} ", self.case, self.group)?;
        match self.verdict {
            None => f.write_str("begins"),
            Some(verdict) => write!(f, "ends: {verdict}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{both_ways, stable};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn begin_and_end() {
        both_ways(&[1, 3, 7, 0, 0, 0], CaseMarker { group: 3, case: 7, verdict: None });
        let ended = CaseMarker { group: 3, case: 7, verdict: Some(Verdict::FAIL) };
        both_ways(&[2, 3, 7, 0, 4, 0], ended);
        assert_eq!(ended.to_string(), "case 7 of group 3 ends: fail");
        assert_eq!(
            CaseMarker::read(&[2, 3, 7, 0, 9, 0]).unwrap().to_string(),
            "case 7 of group 3 ends: unknown verdict 9"
        );
    }

    #[test]
    fn anything_else_is_no_marker() {
        for payload in [&[][..], &[3, 3, 7, 0, 0, 0], &[1, 3, 7, 0, 1, 0], &[1, 3, 7, 0, 0], &[1, 3, 7, 0, 0, 0, 0]] {
            assert!(CaseMarker::read(payload).is_err(), "{payload:02X?}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<CaseMarker>(&bytes);
        }
    }
}
