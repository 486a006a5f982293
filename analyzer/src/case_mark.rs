//! The mark at the beginning and end of a case in a recording of `canvass test`: a line of a comment with the
//! case's id.
//!
//! ```text
//! case 301/boot-up/every-time begins
//! case 301/boot-up/every-time ends: not applicable
//! ```

use std::fmt;

/// The begin or end of a case.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct CaseMark<'a> {
    /// The case's id.
    pub id: &'a str,
    /// The verdict in words; `None` at the beginning of a case.
    pub verdict: Option<&'a str>,
}

impl<'a> CaseMark<'a> {
    /// Parses a line; `None` if the line is no mark.
    pub fn of(line: &'a str) -> Option<Self> {
        let (id, what) = line.strip_prefix("case ")?.split_once(' ')?;
        let verdict = match what {
            "begins" => None,
            _ => Some(what.strip_prefix("ends: ").filter(|verdict| is_plain(verdict, " "))?),
        };
        is_plain(id, "0123456789/-").then_some(Self { id, verdict })
    }

    /// All marks in a comment of several lines.
    pub fn all(comment: &'a str) -> impl Iterator<Item = Self> {
        comment.lines().filter_map(Self::of)
    }
}

/// Whether a text is short and has only small letters and the characters in `others`. Captures may contain any text,
/// and no other text counts as a mark.
fn is_plain(text: &str, others: &str) -> bool {
    (1..=120).contains(&text.len()) && text.chars().all(|c| c.is_ascii_lowercase() || others.contains(c))
}

impl fmt::Display for CaseMark<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.verdict {
            None => write!(f, "case {} begins", self.id),
            Some(verdict) => write!(f, "case {} ends: {verdict}", self.id),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_is_read_as_it_is_written() {
        let begin = CaseMark { id: "301/boot-up/every-time", verdict: None };
        let end = CaseMark { verdict: Some("not applicable"), ..begin };
        assert_eq!(CaseMark::all(&format!("{begin}\nhello\n{end}")).collect::<Vec<_>>(), [begin, end]);
    }

    #[test]
    fn other_comments_are_no_marks() {
        for line in ["", "case", "case 301/x", "case 301/x ends: ", "case 301/<b> begins", "case 7 of group 3 begins"] {
            assert_eq!(CaseMark::of(line), None, "{line}");
        }
    }
}
