//! The doc comment of a rule.

use crate::doc::{append, lines};
use proc_macro2::Span;
use syn::{Attribute, Error, Result};

/// The parts of a rule's doc comment.
#[derive(PartialEq, Eq, Debug)]
pub struct Doc {
    pub title: String,
    pub what: String,
    pub why: String,
    pub advice: String,
}

/// Splits a doc comment into its parts, at the headings `# Why` and `# What to do`.
pub fn doc(attributes: &[Attribute], whole: Span) -> Result<Doc> {
    let mut parts: [String; 4] = Default::default();
    let mut at = 0;
    for line in lines(attributes) {
        match line.trim() {
            "# Why" => at = 2,
            "# What to do" => at = 3,
            "" if at == 0 && !parts[0].is_empty() => at = 1,
            heading if heading.starts_with("# ") => {
                let advice = format!("a rule has no section `{heading}`: there are `# Why` and `# What to do`");
                return Err(Error::new(whole, advice));
            }
            line => append(&mut parts[at], line),
        }
    }
    let [title, what, why, advice] = parts.map(|part| part.trim().to_owned());
    let lacking = [
        (&title, "a title as its first paragraph"),
        (&what, "a paragraph that says what exactly is found"),
        (&why, "a section `# Why`"),
        (&advice, "a section `# What to do`"),
    ];
    match lacking.iter().find(|part| part.0.is_empty()) {
        Some((_, lacking)) => Err(Error::new(whole, format!("the doc comment of the rule lacks {lacking}"))),
        None => Ok(Doc { title, what, why, advice }),
    }
}
