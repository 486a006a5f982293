//! A text by its lines, with what one look at the bytes of each tells.

/// A line without its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    pub text: &'a str,
    /// Whether there is nothing in it but printable ASCII characters and tabs.
    pub is_plain: bool,
    /// Where the first equals sign is; only of a plain line.
    equals: Option<usize>,
}

impl<'a> Line<'a> {
    /// Without blanks and zeros at both ends.
    pub fn trimmed(self) -> Self {
        if self.is_plain {
            let text = self.text.trim_ascii_start();
            let equals = self.equals.and_then(|equals| equals.checked_sub(self.text.len() - text.len()));
            return Self { text: text.trim_ascii_end(), equals, ..self };
        }
        let text = self.text.trim_matches('\0');
        Self { text: text.trim_matches(|character: char| character.is_whitespace() || character == '\0'), ..self }
    }

    /// What stands on both sides of the equals sign, without blanks around it.
    pub fn sides(&self) -> Option<(&'a str, &'a str)> {
        if self.is_plain {
            let equals = self.equals?;
            let (name, value) = (self.text.get(..equals)?, self.text.get(equals + 1..)?);
            return Some((name.trim_ascii_end(), value.trim_ascii_start()));
        }
        let (name, value) = self.text.split_once('=')?;
        Some((name.trim(), value.trim()))
    }
}

/// What a byte means for the line that it is in.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Plain,
    Equals,
    /// A control character, or a part of a character beyond ASCII.
    Other,
    End,
}

const KINDS: [Kind; 256] = {
    let mut kinds = [Kind::Other; 256];
    let mut byte = b' ';
    while byte < 0x7F {
        kinds[byte as usize] = Kind::Plain;
        byte += 1;
    }
    kinds[b'\t' as usize] = Kind::Plain;
    kinds[b'=' as usize] = Kind::Equals;
    kinds[b'\n' as usize] = Kind::End;
    kinds[b'\r' as usize] = Kind::End;
    kinds
};

/// Lines that end in LF, CR LF or CR alone. Behind the end of the last there is an empty one.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let (line, after) = next(rest?);
        rest = after;
        Some(line)
    })
}

/// The first line, and what follows its end.
fn next(text: &str) -> (Line<'_>, Option<&str>) {
    let (mut is_plain, mut equals) = (true, None);
    for (at, &byte) in text.as_bytes().iter().enumerate() {
        match KINDS[byte as usize] {
            Kind::Plain => {}
            Kind::Equals => equals = equals.or(Some(at)),
            Kind::Other => is_plain = false,
            Kind::End => {
                let line = Line { text: text.get(..at).unwrap_or_default(), is_plain, equals };
                let rest = text.get(at + 1..).unwrap_or_default();
                let rest = if byte == b'\r' { rest.strip_prefix('\n').unwrap_or(rest) } else { rest };
                return (line, Some(rest));
            }
        }
    }
    (Line { text, is_plain, equals }, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lines_end_in_three_ways() {
        let all: Vec<&str> = lines("a\nb\r\nc\rd\r\r\n\n").map(|line| line.text).collect();
        assert_eq!(all, ["a", "b", "c", "d", "", "", ""]);
    }

    proptest! {
        #[test]
        fn plain_lines_are_read_as_all_others(text in "[ \t=a;\\[]{0,12}") {
            let line = next(&text).0;
            prop_assert!(line.is_plain);
            let other = Line { is_plain: false, ..line };
            prop_assert_eq!(line.trimmed().text, other.trimmed().text);
            prop_assert_eq!(line.trimmed().sides(), other.trimmed().sides());
        }
    }
}
