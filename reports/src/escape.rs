//! Texts from a bus or a file are hostile: a device may call itself `<script>`, `ESC [2J` or `=cmd()`. Every renderer
//! escapes them with the functions of this module.
//!
//! The writers of markup (maud, quick-junit, serde_json) escape markup. They do not escape characters that act on
//! terminals and spreadsheets, that reorder text, or that XML forbids.
//!
//! All output is escaped: standard output and reports are a [`Visible`], texts printed at once are a [`Printable`], and
//! messages on standard error go through [`printable`]. There is no way around this: only one place has access to the
//! streams themselves (`clippy.toml`), and only this module makes a [`Printable`].

use crate::ascii::ascii;
use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::io;

/// The text on one line, with every character made visible that would act instead of being shown: control characters
/// (C0, DEL, C1), line separators, bidirectional controls, invisible tags and noncharacters.
///
/// Such a character becomes `\x1B` or `\u{202E}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    visible(text, acts)
}

/// The text of a document, with every character made visible that [`printable`] makes visible, except line feeds.
pub fn document(text: &str) -> Cow<'_, str> {
    visible(text, |c| c != '\n' && acts(c))
}

fn visible(text: &str, is_shown: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_shown) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match u32::from(c) {
            _ if !is_shown(c) => shown.push(c),
            // Writing to a string can't fail.
            code @ 0..=0xFF => _ = write!(shown, "\\x{code:02X}"),
            code => _ = write!(shown, "\\u{{{code:X}}}"),
        }
    }
    Cow::Owned(shown)
}

/// Text without control characters. The program prints only such text.
///
/// Only the functions below make one, so that unchecked text can't be printed:
///
/// ```compile_fail
/// let name = canvass_reports::escape::Printable("\x1b[2J".to_owned());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Printable(String);

impl Printable {
    /// Text of one line: line ends become visible, too.
    pub fn line(text: &str) -> Self {
        Self(printable(text).into_owned())
    }

    /// Text that keeps its lines.
    pub fn document(text: &str) -> Self {
        Self(document(text).into_owned())
    }

    /// JSON on one line, with a line end after it.
    pub fn json(value: &serde_json::Value) -> Self {
        Self(json(&format!("{value}\n")).into_owned())
    }

    /// JSON over several lines.
    pub fn pretty_json(value: &serde_json::Value) -> Self {
        Self(json(&format!("{value:#}\n")).into_owned())
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The text.
    pub fn into_string(self) -> String {
        self.0
    }
}

impl fmt::Display for Printable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

/// An output stream that makes control characters visible. Lines stay, and if colours are wanted, so do the sequences
/// that set them.
#[derive(Debug)]
pub struct Visible<W> {
    out: W,
    colors: bool,
    ascii: bool,
    /// The beginning of a character or sequence whose end has not been written yet.
    pending: Vec<u8>,
}

/// Maximum length of a sequence that sets colours: `ESC [ 38;2;255;255;255;48;2;255;255;255 m`.
const LONGEST_SEQUENCE: usize = 48;

impl<W: io::Write> Visible<W> {
    /// A stream that writes to `out`. `colors`: the renderer's colours stay.
    pub const fn new(out: W, colors: bool) -> Self {
        Self { out, colors, ascii: false, pending: Vec::new() }
    }

    /// If `ascii`, replaces each character that is not ASCII by similar ASCII text, or by its number.
    #[must_use]
    pub fn in_ascii(self, ascii: bool) -> Self {
        Self { ascii, ..self }
    }

    fn put(&mut self, text: &str) -> io::Result<()> {
        let text = document(text);
        if self.ascii { self.out.write_all(ascii(&text).as_bytes()) } else { self.out.write_all(text.as_bytes()) }
    }

    fn write_text(&mut self, text: &str) -> io::Result<()> {
        let mut rest = text;
        while let Some(at) = rest.find('\x1b').filter(|_| self.colors) {
            let (before, sequence) = rest.split_at(at);
            self.put(before)?;
            let length = color_sequence(sequence).unwrap_or(0);
            let (kept, after) = sequence.split_at(length);
            self.out.write_all(kept.as_bytes())?;
            rest = after;
            if length == 0 {
                self.out.write_all(b"\\x1B")?;
                rest = after.get(1..).unwrap_or_default();
            }
        }
        self.put(rest)
    }
}

/// The length of the sequence at the beginning of a text, if it sets colours and nothing else.
fn color_sequence(text: &str) -> Option<usize> {
    let parameters = text.strip_prefix("\x1b[")?;
    let length = parameters.find(|c: char| !c.is_ascii_digit() && c != ';')?;
    parameters.get(length..)?.starts_with('m').then_some(length + 3)
}

impl<W: io::Write> io::Write for Visible<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // The fast way for nearly all lines, as a decoder writes millions.
        if self.pending.is_empty() && is_plain(bytes) && (!self.ascii || bytes.is_ascii()) {
            return self.out.write_all(bytes).map(|()| bytes.len());
        }
        self.pending.extend_from_slice(bytes);
        let pending = std::mem::take(&mut self.pending);
        // A character or sequence that is cut waits for its rest.
        let mut end = match std::str::from_utf8(&pending) {
            Ok(_) => pending.len(),
            Err(error) if error.error_len().is_none() => error.valid_up_to(),
            Err(_) => pending.len(),
        };
        let is_begun = |rest: &[u8]| rest.len() < LONGEST_SEQUENCE && !rest.iter().skip(2).any(u8::is_ascii_alphabetic);
        if let Some(at) = pending.iter().rposition(|&byte| byte == 0x1B).filter(|_| self.colors)
            && pending.get(at..end).is_some_and(is_begun)
        {
            end = at;
        }
        let (whole, cut) = pending.split_at(end);
        self.pending = cut.to_vec();
        self.write_text(&String::from_utf8_lossy(whole))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let pending = std::mem::take(&mut self.pending);
        self.out.write_all(printable(&String::from_utf8_lossy(&pending)).as_bytes())?;
        self.out.flush()
    }
}

/// Whether a quick check shows that the bytes are whole characters and that no character acts.
fn is_plain(bytes: &[u8]) -> bool {
    if is_usual(bytes) {
        return true;
    }
    if bytes.iter().any(|&byte| (byte < b' ' && byte != b'\n') || byte == 0x7F) {
        return false;
    }
    let may_act = |found: bool, three: &[u8; 3]| {
        let [first, second, third] = *three;
        found
            | (first == 0xC2 && second < 0xA0)
            | (first == 0xD8 && second == 0x9C)
            | (first == 0xE2 && second == 0x80 && matches!(third, 0x8B..=0x8F | 0xA8..=0xAE))
            | (first == 0xE2 && second == 0x81 && third >= 0xA0)
            | (first == 0xEF && second >= 0xBB)
            | (first == 0xF3)
    };
    let ends_plainly = bytes.last().is_some_and(u8::is_ascii);
    ends_plainly
        && std::str::from_utf8(bytes).is_ok()
        && !bytes.windows(3).filter_map(|three| three.first_chunk()).fold(false, may_act)
}

/// Whether all bytes are printable ASCII or line ends, which is nearly always the case.
fn is_usual(bytes: &[u8]) -> bool {
    // Computes minimum and maximum in a single pass without early exit, for which processors handle 16 bytes at once.
    // If the line end counts as 0, all lower bytes wrap to the highest numbers. If the byte after the line end counts
    // as 0, the line end itself wraps.
    const LINE_END: u8 = b'\n';
    let (most, least) = bytes.iter().fold((0, u8::MAX), |(most, least), &byte| {
        (byte.wrapping_sub(LINE_END).max(most), byte.wrapping_sub(LINE_END + 1).min(least))
    });
    most <= b'~' - LINE_END && least >= b' ' - LINE_END - 1
}

/// Whether a character acts instead of being shown.
pub const fn acts(c: char) -> bool {
    matches!(c,
        '\0'..='\x1F' | '\x7F'..='\u{9F}'
        | '\u{61C}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}'
        | '\u{FEFF}' | '\u{FFF0}'..='\u{FFFB}' | '\u{FFFE}' | '\u{FFFF}' | '\u{E0000}'..='\u{E0FFF}')
}

/// A cell of a CSV file. Spreadsheets evaluate a cell that begins with `=`, `+`, `-` or `@`, so an apostrophe before it
/// keeps it text. A number with its sign stays a number.
pub fn csv_cell(text: &str) -> String {
    let mut cell = String::with_capacity(text.len() + 2);
    write_csv_cell(text, &mut |part| cell.push_str(part));
    cell
}

/// Appends a CSV cell as [`csv_cell`] makes it. Allocates only if the text contains characters that act.
pub fn push_csv_cell(out: &mut Vec<u8>, text: &str) {
    if stays_as_cell(text.as_bytes()) {
        return out.extend_from_slice(text.as_bytes());
    }
    write_csv_cell(text, &mut |part| out.extend_from_slice(part.as_bytes()));
}

/// Whether a text needs no change as a cell, like nearly all texts: printable ASCII that needs no quotes and is no
/// formula.
fn stays_as_cell(text: &[u8]) -> bool {
    let (Some(first), Some(last)) = (text.first(), text.last()) else { return true };
    let is_plain = |byte: &u8| matches!(byte, b' '..=b'~') & !matches!(byte, b'"' | b',' | b';');
    // Without an early exit, processors check 16 bytes at once.
    let is_all_plain = text.iter().fold(true, |all, byte| all & is_plain(byte));
    is_all_plain && *last != b' ' && !matches!(first, b' ' | b'=' | b'+' | b'-' | b'@')
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

/// Text within a Markdown document or table cell. No part of it acts as markup.
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
            // These characters would make links.
            '@' => shown.push_str("&#64;"),
            ':' if shown.ends_with("http") || shown.ends_with("https") => shown.push_str("&#58;"),
            _ => shown.push(c),
        }
    }
    shown
}

/// A JSON document that is safe to show. Characters that act become `\u` escapes, which mean the same to every reader.
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

/// A stream that escapes JSON as [`json`] does, without holding large documents in memory. No write may cut a
/// character; `serde_json` never does.
#[derive(Debug)]
pub(crate) struct JsonText<W>(pub W);

impl<W: io::Write> io::Write for JsonText<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = std::str::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
        self.0.write_all(json(text).as_bytes()).map(|()| bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
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

    proptest! {
        #[test]
        fn a_cell_is_the_same_however_it_is_written(text in "[ -~]{0,6}|[-=+@a1,;\" \t]{0,6}|\\PC{0,6}") {
            let mut pushed = Vec::new();
            push_csv_cell(&mut pushed, &text);
            prop_assert_eq!(String::from_utf8(pushed).unwrap(), csv_cell(&text));
        }
    }

    #[test]
    fn markdown_is_text() {
        assert_eq!(markdown("a|b <script> [x](http://y) `c`"), "a\\|b &lt;script&gt; \\[x\\](http&#58;//y) \\`c\\`");
    }

    /// The output if a text is written in two pieces.
    fn through(text: &str, at: usize, colors: bool) -> String {
        use std::io::Write;
        let mut visible = Visible::new(Vec::new(), colors);
        let (first, second) = text.as_bytes().split_at(at.min(text.len()));
        visible.write_all(first).unwrap();
        visible.write_all(second).unwrap();
        visible.flush().unwrap();
        String::from_utf8(visible.out).unwrap()
    }

    #[test]
    fn only_colours_get_through() {
        let text = "\x1b[1;31mbad\x1b[0m\n\x1b[2Jgone\x1b]0;title\x07\u{2028}\u{feff}\u{e0041}µ";
        let shown = "\x1b[1;31mbad\x1b[0m\n\\x1B[2Jgone\\x1B]0;title\\x07\\u{2028}\\u{FEFF}\\u{E0041}µ";
        for at in 0..=text.len() {
            assert_eq!(through(text, at, true), shown, "cut at {at}");
            assert_eq!(through(text, at, false), shown.replace('\x1b', "\\x1B"), "cut at {at}");
        }
    }

    /// The quick check finds every character that acts, alone and within other characters.
    #[test]
    fn a_quick_look_overlooks_nothing() {
        for c in '\0'..=char::MAX {
            let text = format!("a{c}b\n");
            assert!(!(is_plain(text.as_bytes()) && document(&text) != text), "{c:?}");
        }
        assert!(is_plain("25 °C, 3 µs – Kübler…\n".as_bytes()));
        assert!(!is_plain(b"\x9b2J\n") && !is_plain("cut µ".as_bytes().split_last().unwrap().1));
    }

    #[test]
    fn usual_is_printable_ascii_and_line_ends() {
        for byte in 0..=u8::MAX {
            assert_eq!(is_usual(&[b'a', byte]), matches!(byte, b'\n' | b' '..=b'~'), "{byte:02X}h");
        }
        assert!(is_usual(b""));
    }

    #[test]
    fn what_is_printed_was_looked_at() {
        let hostile = "\u{1b}[2J\u{202e}\n\u{e0041}";
        assert_eq!(Printable::line(hostile).as_str(), "\\x1B[2J\\u{202E}\\x0A\\u{E0041}");
        assert_eq!(Printable::document(hostile).to_string(), "\\x1B[2J\\u{202E}\n\\u{E0041}");
        let json = Printable::json(&serde_json::Value::from(hostile)).into_string();
        assert!(!json.trim_end().contains(acts) && json.ends_with('\n'), "{json}");
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), hostile);
    }

    proptest! {
        #[test]
        fn a_document_keeps_its_lines_only(text in any::<String>(), at in 0..100_usize) {
            prop_assert_eq!(through(&text, at, false), document(&text));
            prop_assert!(!document(&text).contains(|c| c != '\n' && acts(c)));
        }

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
            prop_assert_eq!(serde_json::from_str::<String>(&shown).unwrap(), &*text);
            let mut streamed = Vec::new();
            serde_json::to_writer(JsonText(&mut streamed), &text).unwrap();
            prop_assert_eq!(String::from_utf8(streamed).unwrap(), shown);
        }
    }
}
