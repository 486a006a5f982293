//! Numbers and formulas: decimal, `0x` hexadecimal, leading `0` octal, and sums with `$NODEID` (CiA 306, entry value
//! interpretation), and further spellings that occur in the field.

use crate::dictionary::rules::{Rule, number as rules};

/// A parsed number field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Number {
    /// The number, or the sum of all terms but `$NODEID`.
    pub value: i128,
    /// Whether `$NODEID` is added.
    pub plus_node_id: bool,
    /// The deviation from the standard's form, if there is one.
    pub oddity: Option<Oddity>,
}

/// A spelling that the reader understands although the standard does not allow it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Oddity {
    /// The form that the standard expects.
    pub expected: &'static str,
    /// The rule that the spelling breaks.
    pub rule: &'static Rule,
}

impl Oddity {
    const fn form(expected: &'static str) -> Self {
        Self { expected, rule: &rules::FORM }
    }
}

/// Parses a number or formula; `None` if it is neither.
pub(super) fn parse(text: &str) -> Option<Number> {
    match plain(text.as_bytes()) {
        Some(value) => Some(Number { value: value.into(), plus_node_id: false, oddity: None }),
        None => parse_any(text),
    }
}

/// The number in that text; `None` if it depends on the node-ID.
pub(in crate::dictionary) fn value_of(text: &str) -> Option<i128> {
    parse(text).filter(|number| !number.plus_node_id).map(|number| number.value)
}

/// A decimal or hexadecimal number in the standard's form, of at most 16 digits: a quick parser for nearly all numbers.
fn plain(text: &[u8]) -> Option<u64> {
    let (digits, radix) = match text {
        [b'0'] => return Some(0),
        [b'0', b'x' | b'X', digits @ ..] => (digits, 16),
        [b'1'..=b'9', ..] => (text, 10),
        _ => return None,
    };
    if !(1..=16).contains(&digits.len()) {
        return None;
    }
    digits.iter().try_fold(0, |value, &digit| {
        let digit = char::from(digit).to_digit(radix)?;
        Some(value * u64::from(radix) + u64::from(digit))
    })
}

fn parse_any(text: &str) -> Option<Number> {
    let (text, mut oddity) = without_decoration(text);
    let mut number = Number { value: 0, plus_node_id: false, oddity: None };
    let mut rest = text;
    let mut first = true;
    while first || !rest.is_empty() {
        let negative = match rest.strip_prefix(['+', '-']) {
            Some(unsigned) => {
                let negative = rest.starts_with('-');
                rest = unsigned.trim_start();
                negative
            }
            None if first => false,
            None => return None,
        };
        let end = rest.find(['+', '-']).filter(|&end| !is_exponent(rest, end)).unwrap_or(rest.len());
        let (term, after) = rest.split_at_checked(end)?;
        if let Some(odd) = node_id(term.trim()) {
            if number.plus_node_id || negative {
                return None;
            }
            number.plus_node_id = true;
            oddity = oddity.or(odd.map(Oddity::form));
            if !first {
                oddity =
                    oddity.or(Some(Oddity { expected: "$NODEID before the number", rule: &rules::NODE_ID_BEHIND }));
            }
        } else {
            let (value, odd) = literal(term.trim())?;
            oddity = oddity.or(odd);
            number.value = number.value.checked_add(if negative { -value } else { value })?;
        }
        rest = after;
        first = false;
    }
    number.oddity = oddity;
    Some(number)
}

/// The number or formula in the form of CiA 306; `None` if converting it would be a guess.
pub(in crate::dictionary) fn in_form(text: &str) -> Option<String> {
    let number = parse(text)?;
    let (bare, comment) = match text.split_once([';', '#']) {
        Some((bare, _)) => (bare.trim_end(), text.get(bare.trim_end().len()..).unwrap_or_default()),
        None => (text, ""),
    };
    let is_hexadecimal = bare.contains(['x', 'X']) || bare.trim_end_matches('"').ends_with(['h', 'H']);
    let value = match (is_hexadecimal, u64::try_from(number.value)) {
        (true, Ok(value)) => format!("0x{value:X}"),
        _ => number.value.to_string(),
    };
    let written = match (number.plus_node_id, number.value) {
        (true, 0) => "$NODEID".to_owned(),
        (true, 1..) => format!("$NODEID+{value}"),
        (true, _) => return None,
        (false, _) => value,
    };
    let same = parse(&written).is_some_and(|new| {
        new.oddity.is_none() && (new.value, new.plus_node_id) == (number.value, number.plus_node_id)
    });
    same.then(|| format!("{written}{comment}"))
}

/// The text without quotes and without the part after `;`.
fn without_decoration(text: &str) -> (&str, Option<Oddity>) {
    let mut oddity = None;
    let mut text = text.trim();
    if let Some((number, _)) = text.split_once([';', '#']) {
        text = number.trim();
        oddity = Some(Oddity { expected: "a comment on a line of its own", rule: &rules::COMMENT });
    }
    if let Some(inner) = text.strip_prefix('"').and_then(|text| text.strip_suffix('"')) {
        text = inner.trim();
        oddity = Some(Oddity::form("a number without quotes"));
    }
    (text, oddity)
}

/// Whether a sign belongs to the exponent of a number such as `1e+3`.
fn is_exponent(text: &str, sign: usize) -> bool {
    let before = text.get(..sign).unwrap_or_default();
    before.ends_with(['e', 'E']) && before.contains('.')
}

/// Parses `$NODEID`, ignoring case; the inner option is the deviation from the standard's form.
fn node_id(term: &str) -> Option<Option<&'static str>> {
    match term {
        "$NODEID" => Some(None),
        _ if term.eq_ignore_ascii_case("$NODEID") => Some(Some("$NODEID in capital letters")),
        _ if ["NODEID", "$NODE_ID", "$NODE-ID"].iter().any(|name| term.eq_ignore_ascii_case(name)) => {
            Some(Some("$NODEID"))
        }
        _ => None,
    }
}

/// A number without sign.
fn literal(text: &str) -> Option<(i128, Option<Oddity>)> {
    let digits = |digits: &str, radix| {
        let only_digits = !digits.is_empty() && digits.chars().all(|digit| digit.is_digit(radix));
        if only_digits { i128::from_str_radix(digits, radix).ok() } else { None }
    };
    if let Some(hexadecimal) = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        return Some((digits(hexadecimal, 16)?, None));
    }
    if let Some(hexadecimal) = text.strip_suffix(['h', 'H']) {
        return Some((digits(hexadecimal, 16)?, Some(Oddity::form("hexadecimal numbers with 0x"))));
    }
    if let Some(octal) = text.strip_prefix('0').filter(|rest| !rest.is_empty())
        && let Some(value) = digits(octal, 8)
    {
        // Up to 7 the octal and the decimal number are the same.
        let odd = (value > 7).then_some(Oddity { expected: "no leading 0, which means octal", rule: &rules::OCTAL });
        return Some((value, odd));
    }
    if let Some(value) = digits(text, 10) {
        let odd = text.starts_with('0') && text.len() > 1;
        return Some((value, odd.then_some(Oddity::form("octal digits after a leading 0"))));
    }
    let real: f64 = text.parse().ok().filter(|_| text.starts_with(|first: char| first.is_ascii_digit()))?;
    let whole = real.fract() == 0.0 && real.abs() < 9_007_199_254_740_992.0;
    whole.then_some((real as i128, Some(Oddity::form("a whole number without decimal point"))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> Option<(i128, bool)> {
        parse(text).map(|number| (number.value, number.plus_node_id))
    }

    #[test]
    fn numbers_have_three_bases() {
        assert_eq!(value("10"), Some((10, false)));
        assert_eq!(value("0x10"), Some((16, false)));
        assert_eq!(value("0X1f"), Some((31, false)));
        assert_eq!(value("010"), Some((8, false)));
        assert_eq!((value("0"), value("00"), value("001")), (Some((0, false)), Some((0, false)), Some((1, false))));
        assert_eq!(value("-5"), Some((-5, false)));
        assert_eq!(value("0xFFFFFFFFFFFFFFFF"), Some((u64::MAX.into(), false)));
    }

    #[test]
    fn node_id_may_stand_on_either_side() {
        for text in ["$NODEID+0x180", "0x180+$NODEID", " $NodeId + 384 ", "NODEID+180h", "0x100+$NODEID+0x80"] {
            assert_eq!(value(text), Some((0x180, true)), "{text}");
        }
        assert_eq!(value("$NODEID"), Some((0, true)));
        assert_eq!(value("$NODEID+0x40000180"), Some((0x4000_0180, true)));
        assert_eq!(parse("$NODEID+0x180").and_then(|number| number.oddity), None);
        assert_eq!((value("$NODEID+$NODEID"), value("$NODEID*2"), value("5-$NODEID")), (None, None, None));
    }

    #[test]
    fn odd_spellings_are_understood_and_named() {
        let odd = |text| parse(text).and_then(|number| number.oddity.map(|oddity| (number.value, oddity.expected)));
        assert_eq!(odd("180h"), Some((0x180, "hexadecimal numbers with 0x")));
        assert_eq!(odd("5 ; five"), Some((5, "a comment on a line of its own")));
        assert_eq!(odd("0x7 # VAR"), Some((7, "a comment on a line of its own")));
        assert_eq!(odd("\"5\""), Some((5, "a number without quotes")));
        assert_eq!(odd("0.0"), Some((0, "a whole number without decimal point")));
        assert_eq!(odd("089"), Some((89, "octal digits after a leading 0")));
        assert_eq!(odd("010"), Some((8, "no leading 0, which means octal")));
    }

    #[test]
    fn what_is_no_number_is_none() {
        for text in ["", ";", "abc", "0x", "0xG", "1.5", "1 2", "+", "--1", "inf", "nan", "5-", "0x+1", "1e999"] {
            assert_eq!(value(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn nothing_panics(text in "[$NODEIDnodeid0-9xXa-fhH+. ;\"-]{0,40}") {
            let _ = parse(&text);
        }

        #[test]
        fn all_bases_agree(value in any::<u64>()) {
            let expected = Some((i128::from(value), false));
            prop_assert_eq!(super::tests::value(&value.to_string()), expected);
            prop_assert_eq!(super::tests::value(&format!("{value:#x}")), expected);
            prop_assert_eq!(super::tests::value(&format!("0{value:o}")), expected);
        }

        #[test]
        fn plain_numbers_are_read_as_all_others(text in "(0[xX])?[0-9a-fA-FxX]{0,18}") {
            if let Some(value) = plain(text.as_bytes()) {
                let expected = Number { value: value.into(), plus_node_id: false, oddity: None };
                prop_assert_eq!(parse_any(&text), Some(expected), "{}", text);
            }
        }
    }
}
