//! The text of a doc comment.

use syn::{Attribute, Expr, ExprLit, Lit, Meta};

/// The whole doc comment: lines joined by spaces, empty lines kept between paragraphs.
pub fn text(attributes: &[Attribute]) -> String {
    let mut text = String::new();
    lines(attributes).for_each(|line| append(&mut text, line.trim()));
    text.trim().to_owned()
}

/// Appends a line of a doc comment: after a space, or as a paragraph break if the line is empty.
pub fn append(text: &mut String, line: &str) {
    if line.is_empty() {
        text.push_str("\n\n");
        return;
    }
    if !text.is_empty() && !text.ends_with('\n') {
        text.push(' ');
    }
    text.push_str(line);
}

/// The lines of the doc comment.
pub fn lines(attributes: &[Attribute]) -> impl Iterator<Item = String> {
    attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(line), .. }) => Some(line.value()),
            _ => None,
        },
        _ => None,
    })
}
