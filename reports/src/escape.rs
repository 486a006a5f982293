//! Strings that come off a bus or out of a file are hostile: a device may call itself `<script>`, `ESC [2J` or
//! `=cmd()`. Every renderer takes them through here.
//!
//! Markup is escaped by what writes it (maud, quick-junit, serde_json); what they leave alone are characters that act
//! on terminals and spreadsheets, that reorder text, or that XML forbids.

use std::borrow::Cow;
use std::fmt::Write as _;

/// The text on one line, with every character made visible that would act instead of being shown: control characters
/// (C0, DEL, C1), line separators, bidirectional controls, invisible tags and what is no character at all.
///
/// They become `\x1B` or `\u{202E}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match u32::from(c) {
            _ if !acts(c) => shown.push(c),
            // Writing to a string can't fail.
            code @ 0..=0xFF => _ = write!(shown, "\\x{code:02X}"),
            code => _ = write!(shown, "\\u{{{code:X}}}"),
        }
    }
    Cow::Owned(shown)
}

/// Whether a character does something other than appear.
pub const fn acts(c: char) -> bool {
    matches!(c,
        '\0'..='\x1F' | '\x7F'..='\u{9F}'
        | '\u{61C}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}'
        | '\u{FEFF}' | '\u{FFF0}'..='\u{FFFB}' | '\u{FFFE}' | '\u{FFFF}' | '\u{E0000}'..='\u{E0FFF}')
}

/// One cell of a CSV file. Spreadsheets run what begins with `=`, `+`, `-` or `@`: an apostrophe before it keeps it
/// text. A number with its sign stays a number.
pub fn csv_cell(text: &str) -> String {
    let mut cell = String::with_capacity(text.len() + 2);
    write_csv_cell(text, &mut |part| cell.push_str(part));
    cell
}

/// Appends such a cell; allocates only where there are characters that act.
pub fn push_csv_cell(out: &mut Vec<u8>, text: &str) {
    write_csv_cell(text, &mut |part| out.extend_from_slice(part.as_bytes()));
}

fn write_csv_cell(text: &str, write: &mut dyn FnMut(&str)) {
    let text = printable(text);
    // Spreadsheets skip leading blanks before they look for a formula.
    let dangerous = text.trim_start().starts_with(['=', '+', '-', '@']) && text.trim().parse::<f64>().is_err();
    let needs_quotes = text.contains([',', ';', '"']) || text.trim() != text;
    if needs_quotes {
        write("\"");
    }
    if dangerous {
        write("'");
    }
    for (n, part) in text.split('"').enumerate() {
        if n > 0 {
            write("\"\"");
        }
        write(part);
    }
    if needs_quotes {
        write("\"");
    }
}

/// Text inside a Markdown document or one of its table cells: nothing in it is markup.
pub fn markdown(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '&' => shown.push_str("&amp;"),
            '<' => shown.push_str("&lt;"),
            '>' => shown.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' | '$' => {
                shown.push('\\');
                shown.push(c);
            }
            // Would become links by themselves.
            '@' => shown.push_str("&#64;"),
            ':' if shown.ends_with("http") || shown.ends_with("https") => shown.push_str("&#58;"),
            _ => shown.push(c),
        }
    }
    shown
}

/// A JSON document that is safe to show: characters that act become `\u` escapes, which mean the same to every reader.
/// Line ends between values stay.
pub fn json(document: &str) -> Cow<'_, str> {
    let unsafe_here = |c: char| c != '\n' && acts(c);
    if !document.contains(unsafe_here) {
        return Cow::Borrowed(document);
    }
    let mut shown = String::with_capacity(document.len() + 16);
    for c in document.chars() {
        if unsafe_here(c) {
            let mut units = [0; 2];
            c.encode_utf16(&mut units).iter().for_each(|unit| _ = write!(shown, "\\u{unit:04x}"));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_acts_is_made_visible() {
        assert_eq!(printable("Kübler 58x8 µ"), "Kübler 58x8 µ");
        assert_eq!(printable("\x1b[2Ja\nb\u{9b}c\u{202e}"), "\\x1B[2Ja\\x0Ab\\x9Bc\\u{202E}");
    }

    #[test]
    fn cells_are_no_formulas() {
        assert_eq!(csv_cell("=cmd|' /C calc'!A0"), "'=cmd|' /C calc'!A0");
        assert_eq!(csv_cell(" @SUM(1,2)"), "\"' @SUM(1,2)\"");
        assert_eq!(csv_cell("a \"b\", c"), "\"a \"\"b\"\", c\"");
        assert_eq!(csv_cell("-17.5"), "-17.5");
        assert_eq!(csv_cell("\t=1+1"), "\\x09=1+1");
    }

    #[test]
    fn markdown_is_text() {
        assert_eq!(markdown("a|b <script> [x](http://y) `c`"), "a\\|b &lt;script&gt; \\[x\\](http&#58;//y) \\`c\\`");
    }

    proptest! {
        #[test]
        fn nothing_that_acts_is_left(text in any::<String>()) {
            prop_assert!(!printable(&text).contains(acts));
            prop_assert!(!csv_cell(&text).contains(acts));
            prop_assert!(!markdown(&text).contains(acts));
        }

        #[test]
        fn json_means_the_same(text in any::<String>()) {
            let document = serde_json::to_string(&text).unwrap();
            let shown = json(&document);
            prop_assert!(!shown.contains(acts));
            prop_assert_eq!(serde_json::from_str::<String>(&shown).unwrap(), text);
        }
    }
}
