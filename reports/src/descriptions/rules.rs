//! The texts of the rules for descriptions: one rule at a time, and the handbook of all.

use crate::page_text::{capitalised, wrapped};
use canvass_analyzer::dictionary::Rule;
use canvass_analyzer::dictionary::rules::all;
use std::fmt::Write;

/// A rule in full, for a terminal.
pub fn explain(rule: &Rule) -> String {
    let mut text = format!("{} ({})\n\n{}.\n\n", rule.id, rule.severity, capitalised(rule.title()));
    for (head, body) in [("What", rule.what()), ("What to do", rule.advice())] {
        // Writing to a string can't fail.
        let _ = write!(text, "{head}:\n{}\n", wrapped(&body, "  "));
    }
    let _ = write!(text, "Clause:\n  {}\n\n", rule.clause);
    let indented = |example: &str| example.replace('\r', "\\r").replace('\n', "\n  ");
    let _ = writeln!(text, "Fails:\n  {}\n\nPasses:\n  {}", indented(rule.fails), indented(rule.passes));
    text
}

/// All rules as a page of Markdown: a reference page of the book.
pub fn handbook() -> String {
    let mut text = String::from(
        "# Rules of device descriptions\n\n\
         What `canvass eds check` looks for. `canvass explain ID` prints one of them.\n\n\
         An *error* makes a configuration tool or the device fail, a *warning* is against the letter of the standard, \
         a *hint* is a habit or worth knowing. In the examples a line `...` stands for the other fields of \
         the section.\n\n\
         | rule | severity | finds that |\n|---|---|---|\n",
    );
    for rule in all() {
        let anchor: String = rule.id.chars().filter(|c| *c != '/').collect();
        let _ = writeln!(text, "| [{}](#{anchor}) | {} | {} |", rule.id, rule.severity, rule.title());
    }
    for rule in all() {
        let _ = write!(text, "\n## {}\n\n*{}*: {}. {}.\n\n", rule.id, rule.severity, rule.title(), rule.clause);
        let _ = write!(text, "{}\n\n**What to do.** {}\n\n", rule.what(), rule.advice());
        let language = if rule.id.starts_with("xdd/") { "xml" } else { "ini" };
        for (head, example) in [("Fails", rule.fails), ("Passes", rule.passes)] {
            let example = crate::escape::document(example).into_owned();
            let _ = write!(text, "{head}:\n\n```{language}\n{example}\n```\n\n");
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text
}
