//! The observations that a manual's sheet or a waiver accepts.

use super::Observation;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::Duration;
use std::fmt;
use std::str::FromStr;

/// A pattern of observations, as typed in a sheet or a waiver:
///
/// ```text
/// silence | confirmation | boot-up      that, and nothing else
/// abort 0609 0030h                      that code; an abort can't be accepted without its code
/// value 05 00 | number 5 | state stopped | EMCY 8130h | error code 1 | violation toggle | frame 1BF#00
/// time 90 ms..110 ms | count 2..5       within these, both included
/// value * | time * | count * | frame *  of that sort, whichever
/// ```
///
/// The *found* text of a report is a pattern that accepts exactly the observation found.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Pattern(Accepted);

#[derive(Clone, PartialEq, Eq, Debug)]
enum Accepted {
    Exactly(Observation),
    /// `Frame` holds the notation of a frame, `Violation` the name of a violation. Other details of the observation do
    /// not matter.
    Frame(String),
    Violation(String),
    /// Any observation of this sort.
    Sort(String),
    Time {
        least: Duration,
        most: Duration,
    },
    Count {
        least: u64,
        most: u64,
    },
}

/// The error for a text that is no pattern.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "expected what the device does, such as \"silence\", \"abort 0609 0030h\" or \"time 90 ms..110 ms\": {problem}"
)]
pub struct BadPattern {
    /// The error in the pattern.
    pub problem: String,
}

impl Pattern {
    /// Whether the pattern accepts the observation.
    pub fn accepts(&self, observation: &Observation) -> bool {
        match (&self.0, observation) {
            (Accepted::Exactly(accepted), _) => accepted == observation,
            (Accepted::Frame(notation), Observation::Frame(frame)) => *notation == frame.to_string(),
            (Accepted::Violation(name), Observation::Violation(violation)) => name == violation.name(),
            (Accepted::Sort(sort), _) => sort == observation.sort(),
            (Accepted::Time { least, most }, Observation::Time(span)) => (least..=most).contains(&span),
            (Accepted::Count { least, most }, Observation::Count(count)) => (least..=most).contains(&count),
            _ => false,
        }
    }
}

impl Pattern {
    /// Whether the pattern accepts an observation that is given as the pattern that a report prints for it.
    pub fn covers(&self, found: &Self) -> bool {
        match (&self.0, &found.0) {
            (_, Accepted::Exactly(observation)) => self.accepts(observation),
            (Accepted::Sort(sort), Accepted::Frame(_)) => sort == "frame",
            (own, found) => own == found,
        }
    }
}

/// The sorts of which a pattern may accept any value, because the value may differ between runs.
const OPEN_SORTS: [&str; 5] = ["value", "number", "time", "count", "frame"];

impl FromStr for Pattern {
    type Err = BadPattern;

    fn from_str(text: &str) -> Result<Self, BadPattern> {
        let text = text.trim();
        let bad = |problem: String| BadPattern { problem };
        if text.is_empty() {
            return Err(bad("the pattern is empty".to_owned()));
        }
        if let Some(sort) = text.strip_suffix('*') {
            let sort = sort.trim_end();
            let names = OPEN_SORTS.map(|sort| format!("\"{sort} *\"")).join(", ");
            return match OPEN_SORTS.contains(&sort) {
                true => Ok(Self(Accepted::Sort(sort.to_owned()))),
                false => Err(bad(format!("expected one of {names}, found \"{text}\""))),
            };
        }
        let accepted = match text.split_once(' ').unwrap_or((text, "")) {
            ("silence", "") => Accepted::Exactly(Observation::Silence),
            ("confirmation", "") => Accepted::Exactly(Observation::Confirmation),
            ("boot-up", "") => Accepted::Exactly(Observation::BootUp),
            ("abort", code) => Accepted::Exactly(Observation::Abort(required(abort(code), "an abort code", text)?)),
            ("value", bytes) => Accepted::Exactly(Observation::Value(required(value(bytes), "bytes", text)?)),
            ("number", number) => {
                Accepted::Exactly(Observation::Number(required(number.parse().ok(), "a number", text)?))
            }
            ("state", name) => Accepted::Exactly(Observation::State(required(state(name), "an NMT state", text)?)),
            ("EMCY", code) => Accepted::Exactly(Observation::Emcy(required(emcy(code), "an error code", text)?)),
            ("error", code) => {
                let code = code.strip_prefix("code ").and_then(|code| code.trim().parse().ok());
                Accepted::Exactly(Observation::ErrorCode(required(code, "\"error code 1\"", text)?))
            }
            ("time", span) => required(times(span), "a span of time", text)?,
            ("count", range) => required(counts(range), "a count", text)?,
            ("frame", notation) => Accepted::Frame(notation.to_owned()),
            ("violation", name) => Accepted::Violation(name.to_owned()),
            _ => Accepted::Exactly(Observation::Named(text.to_owned().into())),
        };
        Ok(Self(accepted))
    }
}

fn required<T>(found: Option<T>, expected: &str, text: &str) -> Result<T, BadPattern> {
    found.ok_or_else(|| BadPattern { problem: format!("expected {expected}, found \"{text}\"") })
}

/// Parses an abort code, in upper or lower case. The meaning, which is printed after the code of an
/// [`Observation::Abort`], is ignored.
fn abort(text: &str) -> Option<AbortCode> {
    let digits: String = text.chars().filter(|c| !c.is_whitespace()).take(8).collect();
    u32::from_str_radix(&digits, 16).ok().filter(|_| digits.len() == 8).map(AbortCode)
}

/// Parses bytes such as `05 00`; they may be empty.
fn value(text: &str) -> Option<Vec<u8>> {
    let byte = |text: &str| u8::from_str_radix(text, 16).ok().filter(|_| text.len() == 2);
    text.split_whitespace().map(byte).collect()
}

fn state(name: &str) -> Option<State> {
    (0..=u8::MAX).map(State).find(|state| state.name() == Some(name.trim()))
}

/// Parses an EMCY error code such as `8130h`.
fn emcy(text: &str) -> Option<EmcyCode> {
    let digits = text.trim().trim_end_matches(['h', 'H']);
    u16::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 4).map(EmcyCode)
}

/// Parses a time or a range of times: `105 ms` or `90 ms..110 ms`.
fn times(text: &str) -> Option<Accepted> {
    match text.split_once("..") {
        Some((from, to)) => Some(Accepted::Time { least: duration(from)?, most: duration(to)? }),
        None => duration(text).map(|span| Accepted::Exactly(Observation::Time(span))),
    }
}

/// Parses a count or a range of counts: `3`, `2..5` or `2..`.
fn counts(text: &str) -> Option<Accepted> {
    match text.split_once("..") {
        Some((from, to)) => Some(Accepted::Count { least: count(from, 0)?, most: count(to, u64::MAX)? }),
        None => text.trim().parse().ok().map(|count| Accepted::Exactly(Observation::Count(count))),
    }
}

/// Parses a duration in the form in which a [`Duration`] is written: `105 ms`, `1.5 s`.
fn duration(text: &str) -> Option<Duration> {
    let text = text.trim();
    let unit = text.find(|c: char| c.is_alphabetic() || c == 'µ')?;
    let (number, unit) = text.split_at_checked(unit)?;
    let scale: u64 = match unit.trim() {
        "ns" => 1,
        "µs" | "us" => 1_000,
        "ms" => 1_000_000,
        "s" => 1_000_000_000,
        _ => return None,
    };
    let number = number.trim().parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0)?;
    Some(Duration::from_nanos((number * scale as f64).round() as u64))
}

fn count(text: &str, open: u64) -> Option<u64> {
    let text = text.trim();
    if text.is_empty() { Some(open) } else { text.parse().ok() }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Accepted::Exactly(observation) => write!(f, "{observation}"),
            Accepted::Frame(notation) => write!(f, "frame {notation}"),
            Accepted::Violation(name) => write!(f, "violation {name}"),
            Accepted::Sort(sort) => write!(f, "{sort} *"),
            Accepted::Time { least, most } => write!(f, "time {least}..{most}"),
            Accepted::Count { least, most: u64::MAX } => write!(f, "count {least}.."),
            Accepted::Count { least, most } => write!(f, "count {least}..{most}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn accepts(pattern: &str, observation: &Observation) -> bool {
        pattern.parse::<Pattern>().unwrap().accepts(observation)
    }

    #[test]
    fn what_is_found_is_a_pattern_for_itself_and_for_nothing_else() {
        let observations = [
            Observation::Silence,
            Observation::Confirmation,
            Observation::Abort(AbortCode::INVALID_VALUE),
            Observation::Abort(AbortCode::GENERAL),
            Observation::Value(vec![5, 0]),
            Observation::Value(vec![5; 20]),
            Observation::State(State::STOPPED),
            Observation::Emcy(EmcyCode(0x8130)),
            Observation::Number(5),
            Observation::BootUp,
            Observation::Count(3),
            Observation::Time(Duration::from_millis(105)),
            Observation::ErrorCode(1),
            Observation::named("both channels equal"),
        ];
        for (n, one) in observations.iter().enumerate() {
            for (m, other) in observations.iter().enumerate() {
                assert_eq!(accepts(&one.to_string(), other), n == m, "{one}, {other}");
            }
        }
    }

    #[test]
    fn ranges_and_sorts_accept_what_lies_in_them() {
        let time = |ms| Observation::Time(Duration::from_millis(ms));
        assert!(accepts("time 90 ms..0.11 s", &time(110)) && !accepts("time 90 ms..110 ms", &time(111)));
        assert!(accepts("count 2..", &Observation::Count(9)) && !accepts("count 2..5", &Observation::Count(6)));
        assert!(accepts("value *", &Observation::Value(vec![1])) && !accepts("value *", &Observation::Silence));
        assert!(accepts("abort 06090030h invalid value", &Observation::Abort(AbortCode::INVALID_VALUE)));
    }

    #[test]
    fn what_would_accept_too_much_is_refused() {
        for text in ["", "*", "abort", "abort *", "abort 06", "silence *", "time 1..2", "count x.."] {
            assert!(text.parse::<Pattern>().is_err(), "{text}");
        }
    }
}
