//! The lowest parsers of the text formats: numbers, bytes, words; with the expected text for errors.
//!
//! The parsers are nom parsers written by hand, because these few loops see every byte of a capture. Each format
//! combines them with nom's combinators.

use crate::digits::{four_decimal, hex_prefix};
use nom::IResult;
use nom::error::{ErrorKind, ParseError};

/// The error of a parser: the expected text, and the input at the place of the error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Expected<'a> {
    pub(crate) at: &'a [u8],
    pub(crate) what: &'static str,
}

/// The result of a parser: the rest of the input, and the value.
pub(crate) type Parsed<'a, T> = IResult<&'a [u8], T, Expected<'a>>;

impl<'a> ParseError<&'a [u8]> for Expected<'a> {
    /// Nom's own parsers only combine the parsers of this module, so they have no expected text.
    fn from_error_kind(at: &'a [u8], _: ErrorKind) -> Self {
        Self { at, what: "something else" }
    }

    /// The error of the innermost parser is the most precise one.
    fn append(_: &'a [u8], _: ErrorKind, inner: Self) -> Self {
        inner
    }
}

impl<'a> Expected<'a> {
    pub(crate) const fn new(at: &'a [u8], what: &'static str) -> Self {
        Self { at, what }
    }

    /// The recoverable error of nom: another alternative may fit.
    pub(crate) fn fail<T>(at: &'a [u8], what: &'static str) -> Parsed<'a, T> {
        Err(nom::Err::Error(Self { at, what }))
    }
}

/// These parsers never return nom's `Incomplete`.
impl<'a> From<nom::Err<Self>> for Expected<'a> {
    fn from(error: nom::Err<Self>) -> Self {
        match error {
            nom::Err::Error(expected) | nom::Err::Failure(expected) => expected,
            nom::Err::Incomplete(_) => Self { at: &[], what: "more" },
        }
    }
}

/// Requires that a parser consumed its whole input.
pub(crate) fn whole<'a, T>(parsed: Parsed<'a, T>, what: &'static str) -> Result<T, Expected<'a>> {
    match parsed {
        Ok(([], value)) => Ok(value),
        Ok((rest, _)) => Err(Expected::new(rest, what)),
        Err(error) => Err(error.into()),
    }
}

/// Parses exactly these bytes.
#[inline]
pub(crate) fn tag<'a>(text: &'static [u8], what: &'static str) -> impl Fn(&'a [u8]) -> Parsed<'a, ()> {
    move |input| match input.strip_prefix(text) {
        Some(rest) => Ok((rest, ())),
        None => Expected::fail(input, what),
    }
}

const fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// Skips spaces and tabs.
#[inline]
pub(crate) fn skip_blanks(input: &[u8]) -> &[u8] {
    let count = input.iter().take_while(|&&b| is_blank(b)).count();
    input.get(count..).unwrap_or_default()
}

/// Skips at least one space or tab.
#[inline]
pub(crate) fn blanks1(input: &[u8]) -> Parsed<'_, ()> {
    match skip_blanks(input) {
        rest if rest.len() < input.len() => Ok((rest, ())),
        _ => Expected::fail(input, "a space"),
    }
}

/// A run of at least one byte that is neither space nor tab.
#[inline]
pub(crate) fn word<'a>(what: &'static str) -> impl Fn(&'a [u8]) -> Parsed<'a, &'a [u8]> {
    move |input| {
        let count = input.iter().take_while(|&&b| !is_blank(b)).count();
        match input.split_at_checked(count) {
            Some((word, rest)) if count > 0 => Ok((rest, word)),
            _ => Expected::fail(input, what),
        }
    }
}

/// The length of the run of decimal digits at the input's start, and its value, which is right for up to
/// [`SAFE_DIGITS`] digits.
#[inline]
fn digits(input: &[u8]) -> (usize, u64) {
    let mut value = 0_u64;
    let mut rest = input;
    // Single digits form a chain of multiplications; groups of four shorten it.
    while let Some((four, tail)) = rest.split_first_chunk::<4>()
        && let Some(next) = four_decimal(*four)
    {
        (value, rest) = (value.wrapping_mul(10_000).wrapping_add(u64::from(next)), tail);
    }
    while let [digit @ b'0'..=b'9', tail @ ..] = rest {
        (value, rest) = (value.wrapping_mul(10).wrapping_add(u64::from(digit - b'0')), tail);
    }
    (input.len() - rest.len(), value)
}

/// Number of decimal digits that always fit into 64 bits.
const SAFE_DIGITS: usize = 19;

/// Parses a decimal number of at most 19 digits.
#[inline]
pub(crate) fn decimal<'a>(what: &'static str) -> impl Fn(&'a [u8]) -> Parsed<'a, u64> {
    move |input| match digits(input) {
        (count @ 1..=SAFE_DIGITS, value) => Ok((input.get(count..).unwrap_or_default(), value)),
        _ => Expected::fail(input, what),
    }
}

/// Parses the digits after a decimal point, at least one and at most nine, in billionths.
#[inline]
pub(crate) fn billionths(input: &[u8]) -> Parsed<'_, u32> {
    const SCALE: [u32; 10] = [1_000_000_000, 100_000_000, 10_000_000, 1_000_000, 100_000, 10_000, 1_000, 100, 10, 1];
    match digits(input) {
        (0, _) => Expected::fail(input, "digits after the point"),
        (count, value) => match SCALE.get(count) {
            Some(scale) => Ok((input.get(count..).unwrap_or_default(), value as u32 * scale)),
            None => Expected::fail(input, "at most nine digits after the point"),
        },
    }
}

/// Parses `SECONDS.FRACTION`; the value is in nanoseconds.
#[inline]
pub(crate) fn seconds(input: &[u8]) -> Parsed<'_, u64> {
    let (point, whole) = decimal("a time in seconds")(input)?;
    let (digits, ()) = tag(b".", "a decimal point in the time")(point)?;
    let (rest, fraction) = billionths(digits)?;
    match whole.checked_mul(1_000_000_000).and_then(|nanos| nanos.checked_add(u64::from(fraction))) {
        Some(nanos) => Ok((rest, nanos)),
        None => Expected::fail(input, "a time before the year 2554"),
    }
}

const NOT_HEX: u8 = 0xFF;

/// The value of each hexadecimal digit.
const NIBBLES: [u8; 256] = {
    let mut table = [NOT_HEX; 256];
    let mut value = 0;
    while value < 10 {
        table[b'0' as usize + value] = value as u8;
        value += 1;
    }
    while value < 16 {
        table[b'A' as usize + value - 10] = value as u8;
        table[b'a' as usize + value - 10] = value as u8;
        value += 1;
    }
    table
};

/// The value of a hexadecimal digit.
pub(crate) const fn nibble(digit: u8) -> Option<u8> {
    match NIBBLES[digit as usize] {
        NOT_HEX => None,
        value => Some(value),
    }
}

/// Parses a run of at most 8 hexadecimal digits; gives the rest of the input, the number of digits and their value.
#[inline]
pub(crate) fn hex_run(input: &[u8]) -> (&[u8], usize, u32) {
    let mut value = 0;
    let mut count = 0;
    let mut rest = input;
    while let [digit, tail @ ..] = rest {
        let Some(nibble) = nibble(*digit) else { break };
        if count == 8 {
            break;
        }
        (value, count, rest) = (value << 4 | u32::from(nibble), count + 1, tail);
    }
    (rest, count, value)
}

/// Parses one to eight hexadecimal digits.
pub(crate) fn hexadecimal<'a>(what: &'static str) -> impl Fn(&'a [u8]) -> Parsed<'a, u32> {
    move |input| match hex_run(input) {
        (_, 0, _) => Expected::fail(input, what),
        (rest, _, value) => Ok((rest, value)),
    }
}

/// Parses exactly `digits` hexadecimal digits.
pub(crate) fn hex_field<'a>(digits: usize, what: &'static str) -> impl Fn(&'a [u8]) -> Parsed<'a, u32> {
    move |input| match hex_run(input) {
        (rest, count, value) if count == digits => Ok((rest, value)),
        _ => Expected::fail(input, what),
    }
}

/// Parses a byte of two hexadecimal digits.
#[inline]
pub(crate) fn hex_byte(input: &[u8]) -> Parsed<'_, u8> {
    let [high, low, rest @ ..] = input else {
        return match input {
            [digit] if nibble(*digit).is_some() => Expected::fail(&input[1..], "the second hex digit of a byte"),
            _ => Expected::fail(input, "a byte of two hex digits"),
        };
    };
    match (nibble(*high), nibble(*low)) {
        (Some(high), Some(low)) => Ok((rest, high << 4 | low)),
        (Some(_), None) => Expected::fail(&input[1..], "the second hex digit of a byte"),
        _ => Expected::fail(input, "a byte of two hex digits"),
    }
}

/// Parses eight bytes of two hexadecimal digits each without separators, the form of nearly every line.
#[inline]
pub(crate) fn eight_bytes(input: &[u8]) -> Option<([u8; 8], &[u8])> {
    let (digits, rest) = input.split_first_chunk::<16>()?;
    match hex_prefix(*digits) {
        (16, bytes) => Some((bytes, rest)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        assert_eq!(seconds(b"1700000000.123456)"), Ok((&b")"[..], 1_700_000_000_123_456_000)));
        assert_eq!(seconds(b"000.000000001"), Ok((&b""[..], 1)));
        assert_eq!(seconds(b"18446744073.709551615"), Ok((&b""[..], u64::MAX)));
        for wrong in ["", "1", "1.", ".5", "x", "1.0000000000", "18446744073.709551616", "99999999999999999999.0"] {
            assert!(seconds(wrong.as_bytes()).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_that_do_not_fit_are_refused() {
        assert_eq!(decimal("n")(b"9999999999999999999"), Ok((&b""[..], 9_999_999_999_999_999_999)));
        assert!(decimal("n")(b"10000000000000000000").is_err());
        assert_eq!(hex_run(b"123456789"), (&b"9"[..], 8, 0x1234_5678));
    }

    #[test]
    fn half_a_byte_is_missed_where_it_is_missing() {
        let missing = |input| Expected::from(hex_byte(input).unwrap_err()).at.len();
        assert_eq!(missing(b"A"), 0);
        assert_eq!(missing(b"A x"), 2);
        assert_eq!(missing(b"x"), 1);
        assert_eq!(hex_byte(b"aF0"), Ok((&b"0"[..], 0xAF)));
    }
}
