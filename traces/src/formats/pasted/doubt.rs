//! Lines that are no frames and may have been: damaged ones, and the last one if it has no line end.

use super::layout::{Core, Layout, Role};
use super::token::{Kind, Token};
use super::word::Word;

/// Whether a line that is no frame looks like one.
pub(super) fn is_like_frame(line: &[u8], tokens: &[Token], layout: &Layout) -> bool {
    match layout.core {
        Core::Apart => has_numbers(tokens) || is_lone_identifier(tokens, layout),
        Core::Notation => memchr::memchr(b'#', line).is_some_and(|at| {
            let is_digit = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_hexdigit);
            is_digit(at.checked_sub(1).and_then(|before| line.get(before))) && unknown_words(tokens) <= 2
        }),
        Core::Slcan => is_like_slcan(line.trim_ascii(), tokens),
    }
}

/// Whether a line has more numbers than words.
fn has_numbers(tokens: &[Token]) -> bool {
    let is_number =
        |token: &&Token| matches!(token.kind, Kind::Number(_) | Kind::Digits | Kind::Notation | Kind::Slcan);
    let numbers = tokens.iter().filter(is_number).count();
    let others = tokens.iter().filter(|token| token.kind == Kind::Other).count();
    numbers >= 2 && numbers >= unknown_words(tokens).max(others) && !names_bytes(tokens)
}

/// Whether a line is a single number that may be the identifier of a frame without data.
fn is_lone_identifier(tokens: &[Token], layout: &Layout) -> bool {
    let digits = |token: &Token| token.number().map(|number| number.digits);
    !layout.has(Role::Length) && matches!(tokens, [token] if matches!(digits(token), Some(3 | 8)))
}

/// Whether a line is the head of a table with a column for each byte: `D0 D1 D2 D3`.
fn names_bytes(tokens: &[Token]) -> bool {
    let value = |token: &Token| token.number().map(|number| number.hex);
    tokens.windows(4).any(|names| names.iter().map(value).eq((0xD0..0xD4).map(Some)))
        && !tokens.iter().any(|token| token.number().is_some_and(|number| number.is_decimal))
}

fn unknown_words(tokens: &[Token]) -> usize {
    tokens.iter().filter(|token| token.kind == Kind::Word(Word::Unknown)).count()
}

/// Whether a line begins like a frame in SLCAN's notation, or has mostly digits.
fn is_like_slcan(line: &[u8], tokens: &[Token]) -> bool {
    let count = |is: fn(&u8) -> bool| line.iter().filter(|byte| is(byte)).count();
    let begins = matches!(line, [b't' | b'T' | b'r' | b'R', digit, ..] if digit.is_ascii_hexdigit());
    // A damaged byte splits a line into two words, and leaves more than half of its digits.
    tokens.len() <= 2 && begins && count(u8::is_ascii_digit) > 0
        || count(u8::is_ascii_digit) >= 3 && 2 * count(u8::is_ascii_hexdigit) >= line.len()
}

/// Whether a line that is no frame, and whose reading failed at the offset `at`, may be the beginning of one.
pub(super) fn is_begun(line: &[u8], tokens: &[Token], layout: &Layout, at: usize) -> bool {
    let Some((last, before)) = tokens.split_last() else { return false };
    let says = |token: &Token| !matches!(token.kind, Kind::Mark | Kind::Other | Kind::Word(Word::Unknown));
    match layout.core {
        Core::Slcan if before.is_empty() => matches!(last.text(line), [b't' | b'T' | b'r' | b'R', digits @ ..]
            if digits.iter().all(u8::is_ascii_hexdigit)),
        _ => {
            // The cut may be in the last number or word.
            let has_digit = last.text(line).iter().any(u8::is_ascii_digit);
            at >= last.start && (has_digit || says(last) || before.iter().any(Token::is_value))
        }
    }
}
