//! The numbers and words of a pasted line.

use super::word::{Label, Word, label, word};
use crate::grammar::nibble;

/// A number or word of a line, without the brackets and quotes around it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Token {
    /// The offset of the token's text in the line.
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) kind: Kind,
    /// Whether `;` after a blank is before the token: what follows is a remark.
    pub(super) aside: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// One to eight hexadecimal digits.
    Number(Number),
    /// More than eight hexadecimal digits.
    Digits,
    /// Decimal digits with a point between them.
    Fraction,
    /// A time of the day: `12:30:01.5`.
    Clock,
    /// A date, perhaps with a time of the day: `2023-05-01`, `01.05.2023`, `2023-05-01T12:30:01.5Z`.
    Date,
    /// A frame in candump's notation: identifier, `#`, data.
    Notation,
    /// A frame in SLCAN's notation: `t6058…`.
    Slcan,
    Word(Word),
    /// The name of the number after it: `ID:`, `DLC=`.
    Label(Label),
    /// A mark without meaning: a quote mark, a list bullet.
    Mark,
    /// Anything else, such as a part of an expression.
    Other,
}

/// A number that may be decimal or hexadecimal.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Number {
    /// The value of the hexadecimal digits.
    pub(super) hex: u32,
    pub(super) digits: u8,
    /// Whether `0x` before the digits or `h` after them says that they are hexadecimal.
    pub(super) is_hex: bool,
    /// Whether all digits are decimal ones.
    pub(super) is_decimal: bool,
    /// Whether `x` after the digits marks an identifier of 29 bits.
    pub(super) extended: bool,
    /// Whether the number is in square brackets.
    pub(super) bracketed: bool,
    /// Whether `)`, `.` or `:` follows, as after the number of a line.
    pub(super) closed: bool,
}

impl Number {
    /// The value of the digits as decimal ones.
    pub(super) fn decimal(&self) -> Option<u32> {
        let digit = |place: u8| self.hex >> (4 * place) & 15;
        let all = (0..self.digits).rev().fold(0, |value, place| 10 * value + digit(place));
        self.is_decimal.then_some(all)
    }

    /// Whether the digits are letters only, so that they may be a word, such as `d`.
    pub(super) fn may_be_word(&self) -> bool {
        let is_letter = |place: u8| self.hex >> (4 * place) & 15 > 9;
        !self.is_hex && !self.bracketed && self.digits <= 2 && (0..self.digits).all(is_letter)
    }
}

impl Token {
    pub(super) fn text<'a>(&self, line: &'a [u8]) -> &'a [u8] {
        line.get(self.start..self.end).unwrap_or_default()
    }

    pub(super) fn number(&self) -> Option<Number> {
        match self.kind {
            Kind::Number(number) => Some(number),
            _ => None,
        }
    }

    /// Whether the token fills a column of numbers. Times of the day, dates, words, labels and marks don't.
    pub(super) fn is_value(&self) -> bool {
        match self.kind {
            Kind::Number(number) => !number.may_be_word(),
            Kind::Digits | Kind::Fraction => true,
            _ => false,
        }
    }
}

/// Maximum number of tokens in a line: a CAN FD frame of 64 bytes, and what is beside it.
pub(super) const MOST: usize = 128;

/// The meaning of a comma between two digits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Commas {
    Separate,
    /// A single comma in a word is the decimal sign of a time.
    Decimal,
}

/// Splits a line; `tokens` is emptied first.
pub(super) fn tokenise(line: &[u8], commas: Commas, tokens: &mut Vec<Token>) {
    tokens.clear();
    let semicolons = if separates(line) { Semicolons::Separate } else { Semicolons::BeginRemark };
    let mut at = 0;
    while tokens.len() < MOST {
        let (start, aside) = skip_separators(line, at, semicolons);
        let mut end = separator(line, start);
        if commas == Commas::Decimal && line.get(end) == Some(&b',') {
            end = after_decimals(line, start, end).unwrap_or(end);
        }
        if start == end {
            return;
        }
        at = labelled(line, start, end);
        tokens.push(token(line, start, at, aside));
    }
}

/// The meaning of semicolons behind blanks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Semicolons {
    BeginRemark,
    Separate,
}

/// Whether semicolons separate the columns of a line: there are at least two, with nothing but numbers between them, and
/// the first column is one word. Behind a frame a semicolon begins a remark.
fn separates(line: &[u8]) -> bool {
    let is_of_number = |byte: &u8| byte.is_ascii_hexdigit() || b" \t.:xXh[],-".contains(byte);
    // Bytes may have no decimal digit, such as `EA FF`; a frame without data has an empty column.
    let are_bytes = |part: &[u8]| part.split(|byte| *byte == b' ').all(|word| word.len() == 2);
    let is_number = |part: &[u8]| {
        part.is_empty() || part.iter().all(is_of_number) && (part.iter().any(u8::is_ascii_digit) || are_bytes(part))
    };
    let mut parts = line.trim_ascii().split(|byte| *byte == b';').map(<[u8]>::trim_ascii);
    let begins_with_one_word = parts.clone().next().is_some_and(|first| !first.contains(&b' '));
    begins_with_one_word && parts.clone().count() > 2 && parts.all(is_number)
}

/// The offset after the separators, and whether they begin a remark.
fn skip_separators(line: &[u8], from: usize, semicolons: Semicolons) -> (usize, bool) {
    let (mut at, mut blank, mut aside) = (from, false, false);
    while let Some(&byte) = line.get(at) {
        match byte {
            b' ' | b'\t' => blank = true,
            b';' => aside |= blank && from > 0 && semicolons == Semicolons::BeginRemark,
            b',' | b'|' => {}
            0xC2 if is_hard_blank(line, at) => (at, blank) = (at + 1, true),
            _ => break,
        }
        at += 1;
    }
    (at, aside)
}

/// The offset of the first separator from `start` on, or the length of the line.
fn separator(line: &[u8], start: usize) -> usize {
    let mut at = start;
    while let Some(&byte) = line.get(at) {
        match byte {
            b' ' | b'\t' | b',' | b';' | b'|' => break,
            0xC2 if is_hard_blank(line, at) => break,
            _ => at += 1,
        }
    }
    at
}

/// Whether a blank at which lines must not be broken (U+00A0) begins here.
#[cold]
fn is_hard_blank(line: &[u8], at: usize) -> bool {
    line.get(at + 1) == Some(&0xA0)
}

/// The end of a time whose decimal sign is the comma at `comma`.
fn after_decimals(line: &[u8], start: usize, comma: usize) -> Option<usize> {
    let before = line.get(start..comma)?.trim_ascii_start();
    let whole = before.strip_prefix(b"(").or_else(|| before.strip_prefix(b"[")).unwrap_or(before);
    let decimals = line.get(comma + 1..)?.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let behind = comma + 1 + decimals;
    let is_time = !whole.is_empty() && whole.iter().all(|byte| byte.is_ascii_digit() || *byte == b':');
    let ends = line.get(behind).is_none_or(|byte| !byte.is_ascii_alphanumeric() && *byte != b',');
    (is_time && decimals > 0 && ends).then(|| separator(line, behind))
}

/// The end of the token: that of its label, if a number follows without a blank, as in `ID:605`.
fn labelled(line: &[u8], start: usize, end: usize) -> usize {
    let text = line.get(start..end).unwrap_or_default();
    let letters = text.iter().take_while(|byte| byte.is_ascii_alphabetic() || matches!(byte, b'-' | b'_')).count();
    match text.get(letters) {
        Some(b':' | b'=') if letters > 0 => start + letters + 1,
        _ => end,
    }
}

fn token(line: &[u8], start: usize, end: usize, aside: bool) -> Token {
    let text = line.get(start..end).unwrap_or_default();
    if let Some(kind) = arrow(text) {
        return Token { start, end, kind, aside };
    }
    let head = text.iter().take_while(|byte| b"\"'([<=>".contains(byte)).count();
    let tail = text.iter().skip(head).rev().take_while(|byte| b"\"')]>:.=".contains(byte)).count();
    let inner = text.get(head..text.len() - tail).unwrap_or_default();
    let (before, after) = (text.get(..head).unwrap_or_default(), text.get(text.len() - tail..).unwrap_or_default());
    let kind = match kind(inner, before, after) {
        Kind::Other if head + tail > 0 => word(text).map_or(Kind::Other, Kind::Word),
        kind => kind,
    };
    Token { start: start + head, end: end - tail, kind, aside }
}

/// An arrow or another mark without letters and digits.
fn arrow(text: &[u8]) -> Option<Kind> {
    let is_mark = text.iter().all(|byte| b"<->=*`".contains(byte));
    is_mark.then(|| match text {
        b"<-" | b"->" => word(text).map_or(Kind::Mark, Kind::Word),
        _ => Kind::Mark,
    })
}

fn kind(text: &[u8], before: &[u8], after: &[u8]) -> Kind {
    if text.is_empty() {
        return Kind::Mark;
    }
    let is_name = matches!(after, [b':' | b'=', ..]) && text.iter().all(u8::is_ascii_alphabetic);
    if let Some(number) = number(text).filter(|_| !is_name) {
        let bracketed = before.ends_with(b"[");
        let closed = !before.ends_with(b"(") && matches!(after, [b')' | b'.' | b':', ..]);
        return Kind::Number(Number { bracketed, closed, ..number });
    }
    match text {
        [b'0'..=b'9', ..] => numeric(text),
        _ if matches!(after, [b':' | b'=', ..]) => label(text).map_or(Kind::Other, Kind::Label),
        [b't' | b'T' | b'r' | b'R', digits @ ..] if is_slcan(text, digits) => Kind::Slcan,
        _ if is_digits(text) => Kind::Digits,
        _ if is_notation(text) => Kind::Notation,
        _ => match word(text) {
            Some(word) => Kind::Word(word),
            None => Kind::Other,
        },
    }
}

/// The kind of a text that begins with a digit and is no single number.
fn numeric(text: &[u8]) -> Kind {
    let count = |wanted: u8| text.iter().filter(|byte| **byte == wanted).count();
    let only = |others: &[u8]| text.iter().all(|byte| byte.is_ascii_digit() || others.contains(byte));
    match () {
        () if is_digits(text) => Kind::Digits,
        () if only(b".,") && count(b'.') + count(b',') == 1 && !text.ends_with(b".") => Kind::Fraction,
        () if only(b":.,") && (2..=3).contains(&count(b':')) => Kind::Clock,
        () if only(b"-./:TZ") && is_date(text) => Kind::Date,
        () if only(b".") => Kind::Word(Word::Unknown),
        () if is_notation(text) => Kind::Notation,
        () => match word(text) {
            Some(bits @ Word::Bits(..)) => Kind::Word(bits),
            _ => Kind::Other,
        },
    }
}

/// Whether the text before a `T` has the three numbers of a date; addresses and versions have more or shorter ones.
fn is_date(text: &[u8]) -> bool {
    let day = text.split(|byte| *byte == b'T').next().unwrap_or_default();
    let count = |wanted: u8| day.iter().filter(|byte| **byte == wanted).count();
    day.len() >= 8 && [b'-', b'/', b'.'].into_iter().any(|mark| count(mark) == 2)
}

/// Parses `605`, `0x605`, `605h`, `18FF1234x`.
fn number(text: &[u8]) -> Option<Number> {
    let (digits, prefixed) = match text {
        [b'0', b'x' | b'X', digits @ ..] => (digits, true),
        _ => (text, false),
    };
    let (digits, extended) = match digits {
        [digits @ .., b'x' | b'X'] if !digits.is_empty() => (digits, true),
        _ => (digits, false),
    };
    let (digits, suffixed) = match digits {
        [digits @ .., b'h' | b'H'] if !digits.is_empty() => (digits, true),
        _ => (digits, false),
    };
    if digits.is_empty() || digits.len() > 8 {
        return None;
    }
    let hex = digits.iter().try_fold(0, |value, digit| Some(value << 4 | u32::from(nibble(*digit)?)))?;
    Some(Number {
        hex,
        digits: digits.len() as u8,
        is_hex: prefixed || suffixed,
        is_decimal: !(prefixed || suffixed) && digits.iter().all(u8::is_ascii_digit),
        extended,
        bracketed: false,
        closed: false,
    })
}

/// Hexadecimal digits of several bytes, perhaps after `0x`.
fn is_digits(text: &[u8]) -> bool {
    let digits = text.strip_prefix(b"0x").unwrap_or(text);
    digits.len() > 8 && digits.len() <= 128 && digits.iter().all(|byte| nibble(*byte).is_some())
}

/// One to eight digits and `#`: the rest is parsed where the frame is read.
fn is_notation(text: &[u8]) -> bool {
    let digits = text.iter().take_while(|byte| nibble(**byte).is_some()).count();
    matches!(digits, 3 | 5 | 8) && text.get(digits) == Some(&b'#')
}

/// Whether the digits are an identifier, a length and as many bytes, perhaps with a time after them.
fn is_slcan(text: &[u8], digits: &[u8]) -> bool {
    let id = if matches!(text, [b'T' | b'R', ..]) { 8 } else { 3 };
    let Some(len @ b'0'..=b'8') = digits.get(id) else { return false };
    let bytes = if matches!(text, [b'r' | b'R', ..]) { 0 } else { usize::from(len - b'0') };
    let rest = digits.len().checked_sub(id + 1 + 2 * bytes);
    matches!(rest, Some(0 | 4)) && digits.iter().all(|byte| nibble(*byte).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(line: &str) -> Vec<Kind> {
        let mut tokens = Vec::new();
        tokenise(line.as_bytes(), Commas::Separate, &mut tokens);
        tokens.iter().map(|token| token.kind).collect()
    }

    fn values(line: &str) -> Vec<u32> {
        let number = |kind| if let Kind::Number(number) = kind { Some(number.hex) } else { None };
        kinds(line).into_iter().filter_map(number).collect()
    }

    #[test]
    fn identifiers_in_all_forms() {
        for text in ["605", "0x605", "605h", "(605)", "\"605\"", "ID:605", "ID=0x605,", "id = 605h;", "0605"] {
            assert_eq!(values(text), [0x605], "{text}");
        }
        assert_eq!(values("18FF1234x"), [0x18FF_1234]);
        assert_eq!(values("605 [8] 40,00|10"), [0x605, 8, 0x40, 0, 0x10]);
    }

    #[test]
    fn times_are_no_numbers() {
        assert_eq!(kinds("(0.001)"), [Kind::Fraction]);
        assert_eq!(kinds("(2023-05-01 10:00:00.5)"), [Kind::Date, Kind::Clock]);
        assert_eq!(kinds("19:07:12:3500"), [Kind::Clock]);
        assert_eq!(kinds("2023-05-01T10:00:00.123Z"), [Kind::Date]);
        assert_eq!(kinds("15.03.2023"), [Kind::Date]);
    }

    #[test]
    fn whole_frames() {
        assert_eq!(kinds("605#4000 18FF1234#"), [Kind::Notation, Kind::Notation]);
        assert_eq!(kinds("t60584000100000000000 t705105 T18FF12340"), [Kind::Slcan; 3]);
        assert_eq!(kinds("4000100000000000"), [Kind::Digits]);
        assert!(matches!(kinds("t7051"), ref kinds if kinds != &[Kind::Slcan]), "a byte is missing");
    }

    #[test]
    fn a_decimal_number_is_both() {
        let [Kind::Number(number)] = kinds("128")[..] else { panic!() };
        assert_eq!((number.hex, number.decimal()), (0x128, Some(128)));
    }

    #[test]
    fn parts_of_expressions_are_nothing() {
        for text in ["{0x605", "buf[3]", "a+b", "f(x)", "0x605u"] {
            assert_eq!(kinds(text), [Kind::Other], "{text}");
        }
    }
}
