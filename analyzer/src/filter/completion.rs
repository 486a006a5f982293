//! What can be written next in a filter. The parser itself says what fits, so that there is no second grammar.

use super::expression::{Flag, NumberField};
use super::parser;
use crate::message::Service;

/// What joins tests, and what stands before one.
const WORDS: [&str; 5] = ["and ", "or ", "not ", "in ", "("];
/// What a number or a name is compared with.
const OPERATORS: [&str; 2] = ["=", " in "];

/// A word that no filter has but as a name.
const UNHEARD_OF: &str = "unheard-of";

/// What can stand at the end of `text`, in place of the word that was begun there.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Completion {
    /// Where the word begins, in bytes.
    pub from: usize,
    /// The words, each as it is to be written.
    pub words: Vec<String>,
}

impl Completion {
    /// Of a filter that was written so far; `channels` are names that can be meant.
    pub fn of<'a>(text: &str, channels: impl IntoIterator<Item = &'a str>) -> Self {
        let from = text.rfind(|c: char| c.is_whitespace() || "()=<>!,".contains(c)).map_or(0, |at| at + 1);
        // What parts words is one byte long, but for blanks of other scripts.
        let from = (from..=text.len()).find(|&at| text.is_char_boundary(at)).unwrap_or(text.len());
        let (before, begun) = text.split_at(from);
        let fields = NumberField::NAMES.iter().map(|field| field.0).chain(["service", "channel"]);
        let compared = fields.flat_map(|field| OPERATORS.map(|operator| format!("{field}{operator}")));
        let flags = Flag::NAMES.iter().map(|flag| flag.0.to_owned());
        let services = Service::ALL.into_iter().map(|service| service.name().to_owned());
        let channels = channels.into_iter().filter(|name| !name.contains('"')).map(quoted);
        let others = compared.chain(flags).chain(services).chain(WORDS.map(str::to_owned));
        // Where a channel is named, every word is right: the others would only be in the way.
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

/// A name as a filter takes it.
fn quoted(name: &str) -> String {
    let bare = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || "-_./:".contains(c));
    if bare { name.to_owned() } else { format!("\"{name}\"") }
}

/// Whether the word is right there: there is no mistake, or only something is missing after it.
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
        /// Whatever was written: what is offered makes no mistake that was not there before.
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
