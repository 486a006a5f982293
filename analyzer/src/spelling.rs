//! What a misspelt name may have meant.

/// How much a name must be like a word to be meant by it (Jaro and Winkler, 0 to 1).
const ALIKE: f64 = 0.85;

/// The name that is most like a word, if one is much like it.
pub fn closest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let likeness = |name: &'a str| (strsim::jaro_winkler(&word, &name.to_lowercase()), name);
    let best = names.into_iter().map(likeness).max_by(|one, other| one.0.total_cmp(&other.0))?;
    (best.0 >= ALIKE).then_some(best.1)
}

/// A question for an error message: ` (is heartbeat-wrong-state meant?)`; empty if nothing is like the word.
pub fn meant<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    closest(word, names).map(|name| format!(" (is {name} meant?)")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_are_recognised() {
        let names = ["heartbeat-wrong-state", "boot-up-twice", "sdo-toggle-unchecked"];
        for (word, expected) in [
            ("boot-up-twise", Some("boot-up-twice")),
            ("Heartbeat-wrong-sate", Some("heartbeat-wrong-state")),
            ("sdo-toggle-uncheked", Some("sdo-toggle-unchecked")),
            ("nonsense", None),
            ("", None),
        ] {
            assert_eq!(closest(word, names), expected, "{word}");
        }
        assert_eq!(meant("boot-up-twise", names), " (is boot-up-twice meant?)");
        assert_eq!((closest("x", []), meant("x", [])), (None, String::new()));
    }
}
