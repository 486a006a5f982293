//! The contents of a terminal as a page, with the colours of SGR sequences.

use std::fmt::Write;

/// The colours of terminals with a dark background: 0 to 7, and their bright forms.
const PALETTE: [&str; 16] = [
    "#1e1e1e", "#f14c4c", "#23d18b", "#e5c07b", "#569cd6", "#d670d6", "#29b8db", "#d4d4d4", "#808080", "#ff6b6b",
    "#5af0a8", "#f5e08b", "#7ab8f5", "#e69be6", "#6fd8f0", "#ffffff",
];
const GROUND: &str = "#1e1e1e";
const TEXT: &str = "#d4d4d4";

/// The attributes of the following characters.
#[derive(Clone, Default, PartialEq)]
struct Look {
    text: Option<String>,
    ground: Option<String>,
    bold: bool,
    underlined: bool,
    reversed: bool,
}

/// A page with these lines.
pub fn page(shown: &str) -> String {
    let mut page = format!(
        "<!doctype html><meta charset=\"utf-8\"><style>body {{ margin: 0; background: {GROUND}; color: {TEXT}; }}\
         pre {{ margin: 14px 16px; font: 14px/1.3 \"DejaVu Sans Mono\", monospace; }}</style><pre>"
    );
    let mut look = Look::default();
    let mut pieces = shown.split("\u{1B}[");
    put(&mut page, &look, pieces.next().unwrap_or_default());
    for piece in pieces {
        let end = piece.find(|character: char| character.is_ascii_alphabetic()).unwrap_or(piece.len());
        let (codes, rest) = piece.split_at(end);
        if rest.starts_with('m') {
            look.change(codes);
        }
        put(&mut page, &look, rest.get(1..).unwrap_or_default());
    }
    page.push_str("</pre>");
    page
}

fn put(page: &mut String, look: &Look, text: &str) {
    if text.is_empty() {
        return;
    }
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;");
    if *look == Look::default() {
        page.push_str(&escaped);
        return;
    }
    // Writing to a string can't fail.
    let _ = write!(page, "<span style=\"{}\">{escaped}</span>", look.style());
}

impl Look {
    /// Applies the numbers between `ESC [` and `m`.
    fn change(&mut self, codes: &str) {
        let numbers: Vec<usize> = codes.split([';', ':']).map(|code| code.parse().unwrap_or(0)).collect();
        let mut rest = numbers.as_slice();
        while let [code, after @ ..] = rest {
            rest = after;
            match code {
                0 => *self = Self::default(),
                1 => self.bold = true,
                4 => self.underlined = true,
                7 => self.reversed = true,
                22 => self.bold = false,
                24 => self.underlined = false,
                27 => self.reversed = false,
                30..=37 => self.text = colour(code - 30),
                39 => self.text = None,
                40..=47 => self.ground = colour(code - 40),
                49 => self.ground = None,
                90..=97 => self.text = colour(code - 90 + 8),
                100..=107 => self.ground = colour(code - 100 + 8),
                38 | 48 => {
                    let (asked, behind) = of_many(rest);
                    rest = behind;
                    *(if *code == 38 { &mut self.text } else { &mut self.ground }) = asked;
                }
                _ => {}
            }
        }
    }

    fn style(&self) -> String {
        let (mut text, mut ground) = (self.text.as_deref().unwrap_or(TEXT), self.ground.as_deref().unwrap_or(GROUND));
        if self.reversed {
            (text, ground) = (ground, text);
        }
        let bold = if self.bold { ";font-weight:bold" } else { "" };
        let line = if self.underlined { ";text-decoration:underline" } else { "" };
        format!("color:{text};background:{ground}{bold}{line}")
    }
}

fn colour(number: usize) -> Option<String> {
    PALETTE.get(number).map(|&colour| colour.to_owned())
}

/// The colour in the numbers of an SGR sequence, by its index among 256 or by red, green and blue, and the remaining
/// numbers.
fn of_many(numbers: &[usize]) -> (Option<String>, &[usize]) {
    match numbers {
        [2, red, green, blue, rest @ ..] => (Some(format!("rgb({red},{green},{blue})")), rest),
        [5, number @ 0..=15, rest @ ..] => (colour(*number), rest),
        [5, number @ 16..=231, rest @ ..] => {
            let level = |step: usize| if step == 0 { 0 } else { 55 + 40 * step };
            let (red, green, blue) = ((number - 16) / 36, (number - 16) / 6 % 6, (number - 16) % 6);
            (Some(format!("rgb({},{},{})", level(red), level(green), level(blue))), rest)
        }
        [5, number, rest @ ..] => {
            let grey = 8 + 10 * number.saturating_sub(232);
            (Some(format!("rgb({grey},{grey},{grey})")), rest)
        }
        _ => (None, &[]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_become_styles_and_texts_do_not_act() {
        let shown = page("a \u{1B}[1m\u{1B}[31m<b>\u{1B}[0m c \u{1B}[38;5;196md\u{1B}[39;7me\u{1B}[K");
        let spans = "a <span style=\"color:#f14c4c;background:#1e1e1e;font-weight:bold\">&lt;b></span> c \
                     <span style=\"color:rgb(255,0,0);background:#1e1e1e\">d</span>\
                     <span style=\"color:#1e1e1e;background:#d4d4d4\">e</span></pre>";
        assert!(shown.ends_with(spans), "{shown}");
    }
}
