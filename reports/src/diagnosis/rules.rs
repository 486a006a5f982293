//! The texts of the rules: one rule at a time, and the handbook of all.

use crate::page_text::{capitalised, wrapped};
use canvass_analyzer::findings::{Metadata, all};
use std::fmt::Write;

/// A rule in full, for a terminal.
pub fn explain(rule: &Metadata) -> String {
    let mut text = format!("{} ({})\n\n{}.\n\n", rule.id, rule.severity, capitalised(rule.title));
    for (head, body) in [("What", rule.what), ("Why it matters", rule.why), ("What to do", rule.advice)] {
        // Writing to a string can't fail.
        let _ = write!(text, "{head}:\n{}\n", wrapped(body, "  "));
    }
    if !rule.thresholds.is_empty() {
        text.push_str("Thresholds:\n");
    }
    for threshold in rule.thresholds {
        let default = format!("{} {}", threshold.default, threshold.unit);
        let (id, name, meaning) = (rule.id, threshold.name, threshold.meaning);
        let _ = writeln!(text, "  {id}.{name} (default {}): {meaning}", default.trim_end());
    }
    text
}

/// All rules as a page of Markdown: a reference page of the book.
pub fn handbook() -> String {
    let mut text = String::from(
        "# Rules\n\n\
         What `canvass diagnose` looks for. `canvass explain ID` prints one of them.\n\n\
         A threshold is set with `--threshold RULE.NAME=VALUE`, such as `--threshold bus/load.percent=70`.\n\n\
         | rule | severity | finds that |\n|---|---|---|\n",
    );
    for rule in all().map(|definition| definition.metadata) {
        let anchor: String = rule.id.chars().filter(|c| *c != '/').collect();
        let _ = writeln!(text, "| [{}](#{anchor}) | {} | {} |", rule.id, rule.severity, rule.title);
    }
    for rule in all().map(|definition| definition.metadata) {
        section(rule, &mut text);
    }
    text
}

fn section(rule: &Metadata, text: &mut String) {
    let _ = write!(text, "\n## {}\n\n*{}*: {}.\n\n", rule.id, rule.severity, rule.title);
    let _ = write!(text, "{}\n\n", rule.what);
    let _ = write!(text, "**Why it matters.** {}\n\n", rule.why);
    let _ = writeln!(text, "**What to do.** {}", rule.advice);
    if rule.thresholds.is_empty() {
        return;
    }
    text.push_str("\n| threshold | default | |\n|---|---|---|\n");
    for threshold in rule.thresholds {
        let default = format!("{} {}", threshold.default, threshold.unit);
        let _ = writeln!(text, "| `{}` | {} | {} |", threshold.name, default.trim_end(), threshold.meaning);
    }
}
