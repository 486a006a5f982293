//! Text for terminals that show only ASCII.

use std::borrow::Cow;
use std::fmt::Write;

/// The text in ASCII. A character that the program itself writes gets a similar character; any other character becomes
/// `\u{3B1}`, so that nothing is lost.
pub fn ascii(text: &str) -> Cow<'_, str> {
    if text.is_ascii() {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match likeness(c) {
            Some(likeness) => plain.push_str(likeness),
            None if c.is_ascii() => plain.push(c),
            // Writing to a string can't fail.
            None => _ = write!(plain, "\\u{{{:X}}}", u32::from(c)),
        }
    }
    Cow::Owned(plain)
}

/// The similar ASCII text of a character. Table frames and signs of verdicts keep their width, so that columns stay
/// aligned.
const fn likeness(c: char) -> Option<&'static str> {
    Some(match c {
        '─' | '═' | '┄' | '–' | '—' => "-",
        '│' | '┆' | '║' => "|",
        '┌' | '┐' | '└' | '┘' | '├' | '┤' | '┬' | '┴' | '┼' | '╞' | '╡' | '╪' => "+",
        '✓' | '✔' => "+",
        '✗' | '✘' | '×' => "x",
        '≈' => "~",
        '≠' => "=",
        '·' => ".",
        '…' => "...",
        '→' => "->",
        '←' => "<-",
        'µ' => "u",
        '°' => " deg",
        '‘' | '’' => "'",
        '“' | '”' => "\"",
        'ä' => "ae",
        'ö' => "oe",
        'ü' => "ue",
        'ß' => "ss",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_has_a_likeness_or_its_number() {
        assert!(matches!(ascii("plain"), Cow::Borrowed("plain")));
        assert_eq!(ascii("✗ fail │ 12° → Kübler, 3 µs …"), "x fail | 12 deg -> Kuebler, 3 us ...");
        assert_eq!(ascii("α"), "\\u{3B1}");
    }
}
