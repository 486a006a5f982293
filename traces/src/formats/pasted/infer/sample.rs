//! The lines from which the meaning of the columns is inferred.

use super::super::layout::{Core, Layout};
use super::super::row::{Row, read};
use super::super::token::{Commas, Kind, Token, tokenise};
use crate::columns::Unit;
use crate::lines::head_lines;

/// Number of lines that decide.
const LINES: usize = 300;

/// The lines that decide, each with its tokens.
pub(super) struct Sample<'a> {
    lines: Vec<(&'a [u8], Vec<Token>)>,
    pub(super) hints: Hints,
}

/// What lines without frames, such as the heads of tables, say of the columns.
#[derive(Default)]
pub(super) struct Hints {
    pub(super) unit: Option<Unit>,
    /// A column with flags says which identifiers have 29 bits.
    pub(super) flags: bool,
    /// A column with cycle times.
    pub(super) cycle: bool,
}

impl<'a> Sample<'a> {
    pub(super) fn new(head: &'a [u8], commas: Commas) -> Self {
        let mut sample = Self { lines: Vec::new(), hints: Hints::default() };
        for (line, _) in head_lines(head).filter(|(line, _)| !line.trim_ascii().is_empty()) {
            let mut tokens = Vec::new();
            tokenise(line, commas, &mut tokens);
            let has_value = |token: &Token| token.is_value() || matches!(token.kind, Kind::Notation | Kind::Slcan);
            if tokens.iter().any(has_value) {
                sample.lines.push((line, tokens));
            }
            if sample.lines.len() < 50 {
                sample.hints.look_at(line);
            }
            if sample.lines.len() == LINES {
                break;
            }
        }
        sample
    }

    /// The lines that a layout reads as frames with data, each with its index.
    pub(super) fn rows(&self, layout: &Layout) -> Vec<(usize, Row)> {
        let row = |(index, (line, tokens)): (usize, &(&[u8], Vec<Token>))| {
            let row = read(line, tokens, layout).ok()?;
            let frame = &row.record.frame;
            let has_content = frame.is_remote() || !frame.is_empty() || layout.core != Core::Apart;
            (has_content && !frame.is_error()).then_some((index, row))
        };
        self.lines.iter().enumerate().filter_map(row).collect()
    }

    /// Whether a layout reads all lines with numbers, also as frames without data.
    pub(super) fn fits(&self, layout: &Layout) -> bool {
        self.lines.iter().all(|(line, tokens)| read(line, tokens, layout).is_ok())
    }

    /// Number of lines with two or more bytes in a row, or with a whole frame.
    pub(super) fn alike(&self) -> usize {
        let is_byte = |token: &Token| token.number().is_some_and(|number| number.digits == 2 && !number.extended);
        let is_whole = |token: &Token| matches!(token.kind, Kind::Digits | Kind::Notation | Kind::Slcan);
        let alike =
            |tokens: &[Token]| tokens.iter().any(is_whole) || tokens.windows(2).any(|pair| pair.iter().all(is_byte));
        self.lines.iter().filter(|(_, tokens)| alike(tokens)).count()
    }

    pub(super) fn ends_in_comma(&self, line: usize) -> bool {
        self.lines.get(line).is_some_and(|(line, _)| line.trim_ascii_end().ends_with(b","))
    }

    pub(super) fn line(&self, line: usize) -> &'a [u8] {
        self.lines.get(line).map_or(&[], |(line, _)| line)
    }

    pub(super) fn tokens(&self, line: usize) -> &[Token] {
        self.lines.get(line).map_or(&[], |(_, tokens)| tokens)
    }

    pub(super) fn text(&self, line: usize, token: usize) -> &'a [u8] {
        let line = self.lines.get(line);
        line.and_then(|(line, tokens)| Some(tokens.get(token)?.text(line))).unwrap_or_default()
    }
}

impl Hints {
    fn look_at(&mut self, line: &[u8]) {
        let lower = line.to_ascii_lowercase();
        let has = |text: &str| lower.windows(text.len()).any(|window| window == text.as_bytes());
        self.flags |= has("identifier flg") || has(" flg ");
        // The heads of tables name other columns too; TRC's head has a line for each column.
        let is_comment = matches!(lower.trim_ascii_start().first(), Some(b';' | b'#' | b'|' | b'*'));
        let is_head =
            is_comment || ["id", "identifier", "can-id", "cob-id"].into_iter().any(|name| is_word(&lower, name));
        self.cycle |= has("cycle time") && has("count") && is_head;
        if !is_head {
            return;
        }
        let named = |unit: &Unit| {
            let forms = [" [", "[", " (", "("].map(|open| format!("{open}{}", unit.symbol()));
            let names = ["time", "timestamp", "time stamp", "offset"];
            names.into_iter().any(|name| forms.iter().any(|form| has(&format!("{name}{form}"))))
        };
        self.unit = self.unit.or_else(|| Unit::ALL.into_iter().find(named));
    }
}

/// Whether the text has a word between other characters than letters.
fn is_word(text: &[u8], word: &str) -> bool {
    text.split(|byte| !byte.is_ascii_alphanumeric() && *byte != b'-').any(|part| part == word.as_bytes())
}
