//! Completion in filters. The parser itself tells which words fit, so there is no second grammar.

use super::expression::{Flag, NumberField};
use super::parser;
use crate::message::Service;

/// Words that join tests or precede a test.
const WORDS: [&str; 5] = ["and ", "or ", "not ", "in ", "("];
/// Operators after a number or a name.
const OPERATORS: [&str; 2] = ["=", " in "];

/// A word that can occur in a filter only as a name.
const UNHEARD_OF: &str = "unheard-of";

/// Completions at the end of `text`, replacing the unfinished word there.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Completion {
    /// The offset of the unfinished word.
    pub from: usize,
    /// The fitting words, in the form to insert.
    pub words: Vec<String>,
}

impl Completion {
    /// Completes an unfinished filter; `channels` are names to offer.
    pub fn of<'a>(text: &str, channels: impl IntoIterator<Item = &'a str>) -> Self {
        let from = text.rfind(|c: char| c.is_whitespace() || "()=<>!,".contains(c)).map_or(0, |at| at + 1);
        // Separators are one byte long, except blanks of other scripts.
        let from = (from..=text.len()).find(|&at| text.is_char_boundary(at)).unwrap_or(text.len());
        let (before, begun) = text.split_at(from);
        let fields = NumberField::NAMES.iter().map(|field| field.0).chain(["service", "channel"]);
        let compared = fields.flat_map(|field| OPERATORS.map(|operator| format!("{field}{operator}")));
        let flags = Flag::NAMES.iter().map(|flag| flag.0.to_owned());
        let services = Service::ALL.into_iter().map(|service| service.name().to_owned());
        let channels = channels.into_iter().filter(|name| !name.contains('"')).map(quoted);
        let others = compared.chain(flags).chain(services).chain(WORDS.map(str::to_owned));
        // At the place of a channel name every word fits; offering keywords at this place would be misleading.
        let names_channel = fits(before, UNHEARD_OF);
        let all = others.filter(|_| !names_channel).chain(channels);
        let mut words: Vec<String> = Vec::new();
        for word in all.filter(|word| word.starts_with(begun) && word != begun) {
            if !words.contains(&word) && fits(before, &word) {
                words.push(word);
            }
        }
        Self { from, words }
    }
}

/// A name, quoted if a filter needs it.
fn quoted(name: &str) -> String {
    let bare = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || "-_./:".contains(c));
    if bare { name.to_owned() } else { format!("\"{name}\"") }
}

/// Whether `word` fits after `before`: the parser finds no mistake, or only a missing continuation.
fn fits(before: &str, word: &str) -> bool {
    let text = format!("{before}{word}");
    parser::parse(&text).err().is_none_or(|error| error.found.is_none())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Filter;
    use proptest::prelude::*;

    fn words(text: &str) -> Vec<String> {
        Completion::of(text, ["can0", "my bus"]).words
    }

    #[test]
    fn only_what_fits_is_offered() {
        assert_eq!(words("service=s"), ["sync", "sdo", "srdo"]);
        assert_eq!(words("no"), ["node=", "node in ", "not "]);
        assert_eq!(words("abort a"), ["and "]);
        assert_eq!(words("channel="), ["can0", "\"my bus\""]);
        assert_eq!(words("node=5 "), ["and ", "or "]);
        assert_eq!(words("service "), ["in "]);
        assert!(words("service=sdo and ").contains(&"abort".to_owned()));
        assert!(!words("service=sdo and ").contains(&"and ".to_owned()));
        assert!(words("").contains(&"service=".to_owned()));
    }

    #[test]
    fn the_word_that_was_begun_is_replaced() {
        assert_eq!(Completion::of("service=sd", []).from, 8);
        assert_eq!(Completion::of("not (ab", []).from, 5);
        assert_eq!(Completion::of("a\u{2003}ab", []).from, 4);
    }

    proptest! {
        /// A completion adds no mistake to the text, whatever the text is.
        #[test]
        fn what_is_offered_is_no_mistake(text in "[a-z=0-9 ()<>!,\u{2003}\"]{0,20}") {
            let Completion { from, words } = Completion::of(&text, ["can0"]);
            for word in words {
                if let Err(error) = format!("{}{word}", &text[..from]).parse::<Filter>() {
                    prop_assert_eq!(error.found, None);
                }
            }
        }
    }
}
