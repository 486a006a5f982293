//! For tickets and wikis: a table for each class.

use super::{Compared, fact, subject};
use crate::escape::markdown;
use canvass_analyzer::dictionary::difference::Class;
use std::fmt::Write;

pub(super) fn document(compared: &Compared) -> String {
    let mut text = format!("# {} → {}\n\n", markdown(&compared.old), markdown(&compared.new));
    if compared.differences.is_empty() {
        text.push_str("No difference.\n");
        return text;
    }
    // Writing to a string can't fail.
    let _ = writeln!(text, "{}.", compared.counts());
    for class in Class::ALL {
        let kinds: Vec<_> = compared.by_kind().into_iter().filter(|(kind, _)| kind.class == class).collect();
        if kinds.is_empty() {
            continue;
        }
        let _ = write!(text, "\n## {class}\n\n| what | where | old | new |\n|---|---|---|---|\n");
        for (kind, differences) in &kinds {
            for difference in differences {
                let [before, after] = [&difference.before, &difference.after].map(|it| markdown(&fact(it.as_ref())));
                let place = markdown(&subject(difference));
                let _ = writeln!(text, "| {} | {place} | {before} | {after} |", kind.title());
            }
        }
        text.push('\n');
        for (kind, _) in &kinds {
            let _ = writeln!(text, "- *{}* (`{}`): {}", kind.title(), kind.id, kind.why());
        }
    }
    text
}
