//! Text of descriptions on one line.

use std::fmt;

/// The text escaped as by [`str::escape_debug`]. Most names need no escaping and are written at once.
pub struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.bytes().all(|byte| matches!(byte, b' '..=b'~') && !matches!(byte, b'"' | b'\'' | b'\\')) {
            return f.write_str(self.0);
        }
        self.0.escape_debug().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn as_escape_debug(text in prop_oneof![any::<String>(), "[ -~]*"]) {
            prop_assert_eq!(Escaped(&text).to_string(), text.escape_debug().to_string());
        }
    }
}
