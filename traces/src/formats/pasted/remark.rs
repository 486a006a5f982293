//! The remark after a frame.

/// The remark in the text after a frame, without the mark before it; `None` if there is none, or only the data as
/// characters.
pub(crate) fn remark(text: &[u8]) -> Option<&str> {
    let text = text.trim_ascii();
    let text = text
        .iter()
        .position(|byte| !matches!(byte, b',' | b'|' | b']' | b')' | b'`'))
        .map_or(&[][..], |at| text.get(at..).unwrap_or_default());
    let text = text.trim_ascii();
    if let [quote @ (b'\'' | b'"'), .., last] = text
        && quote == last
    {
        return None;
    }
    let is_mark = |c: char| {
        matches!(c, '<' | '>' | '-' | '=' | '/' | '#' | ';' | '*' | '!' | '|' | ',' | '←' | '→' | '"' | '\'')
            || c.is_whitespace()
    };
    let text = std::str::from_utf8(text).ok()?.trim_start_matches(is_mark).trim_end();
    let text = text.strip_suffix("*/").unwrap_or(text).trim_end_matches(|c: char| c == '|' || c.is_whitespace());
    text.chars().any(char::is_alphanumeric).then_some(text)
}

/// Whether a remark only repeats the data as characters, with points for those that can't be printed.
pub(super) fn shows_data(text: &str, data: &[u8]) -> bool {
    let mut characters = [b'.'; 64];
    let characters = characters.get_mut(..data.len()).unwrap_or_default();
    for (place, byte) in characters.iter_mut().zip(data).filter(|(_, byte)| matches!(byte, b' '..=b'~')) {
        *place = *byte;
    }
    text.len() <= data.len() && remark(characters) == Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_no_part_of_a_remark() {
        for text in [
            "    <---- no answer",
            " // no answer",
            "; no answer",
            "\t-> no answer",
            " # no answer",
            "| no answer",
            " /* no answer */",
            " <- no answer",
            " ← no answer",
            "  no answer",
        ] {
            assert_eq!(remark(text.as_bytes()), Some("no answer"), "{text}");
        }
    }

    #[test]
    fn characters_of_the_data_are_no_remark() {
        assert!(shows_data("C.......", &[0x43, 0, 0x10, 0, 0x92, 1, 2, 0]));
        assert!(shows_data(".A C.", &[0, 0x41, 0x20, 0x43, 0]));
        assert!(!shows_data("C", &[0x43, 0]) && !shows_data("no", &[0x43, 0]));
        for text in ["", "   ", "  '@.......'", " \"....\"", ",", " |", " <---"] {
            assert_eq!(remark(text.as_bytes()), None, "{text}");
        }
    }
}
