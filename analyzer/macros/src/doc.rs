//! What a doc comment says of a rule.

use proc_macro2::Span;
use syn::{Attribute, Error, Expr, ExprLit, Lit, Meta, Result};

/// The parts of a rule's doc comment.
#[derive(PartialEq, Eq, Debug)]
pub struct Doc {
    pub title: String,
    pub what: String,
    pub why: String,
    pub advice: String,
}

/// The parts, told apart by the headings `# Why` and `# What to do`.
pub fn doc(attributes: &[Attribute], whole: Span) -> Result<Doc> {
    let mut parts: [String; 4] = Default::default();
    let mut at = 0;
    for line in attributes.iter().filter_map(doc_line) {
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

/// The doc comment as one line.
pub fn line(attributes: &[Attribute]) -> String {
    let mut text = String::new();
    attributes.iter().filter_map(doc_line).for_each(|line| append(&mut text, line.trim()));
    text
}

/// Lines are joined by spaces, empty ones separate paragraphs.
fn append(text: &mut String, line: &str) {
    if line.is_empty() {
        text.push_str("\n\n");
        return;
    }
    if !text.is_empty() && !text.ends_with('\n') {
        text.push(' ');
    }
    text.push_str(line);
}

fn doc_line(attribute: &Attribute) -> Option<String> {
    match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(line), .. }) => Some(line.value()),
            _ => None,
        },
        _ => None,
    }
}
