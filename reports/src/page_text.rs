//! The layout of rule texts on a terminal.

use std::fmt::Write;

/// The text with a capital letter at its beginning.
pub(crate) fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|first| first.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

/// The text in lines of at most 100 columns, each after `indent`.
pub fn wrapped(text: &str, indent: &str) -> String {
    const WIDTH: usize = 100;
    let mut lines = String::new();
    let mut line = indent.to_owned();
    for word in text.split_whitespace() {
        if line.chars().count() + word.chars().count() > WIDTH {
            let _ = writeln!(lines, "{}", line.trim_end());
            line = indent.to_owned();
        }
        line.push_str(word);
        line.push(' ');
    }
    lines + line.trim_end() + "\n"
}

/// The parts in lines of at most `width` columns. The separator and a blank are between the parts of a line.
pub fn packed(parts: &[String], separator: &str, width: usize) -> Vec<String> {
    let length = |text: &str| text.chars().count();
    let mut lines: Vec<String> = Vec::new();
    for (at, part) in parts.iter().enumerate() {
        let part = if at + 1 < parts.len() { format!("{part}{separator}") } else { part.clone() };
        match lines.last_mut() {
            Some(line) if length(line) + 1 + length(&part) <= width => *line += &format!(" {part}"),
            _ => lines.push(part),
        }
    }
    lines
}

/// `1 warning`, `2 warnings`.
pub fn counted(count: usize, one: &str) -> String {
    format!("{count} {one}{}", if count == 1 { "" } else { "s" })
}

/// `no warnings`, `1 warning`, `2 warnings`.
pub(crate) fn none_or_counted(count: usize, one: &str) -> String {
    if count == 0 { format!("no {one}s") } else { counted(count, one) }
}
