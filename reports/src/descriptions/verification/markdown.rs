//! For tickets and wikis.

use super::{Verification, remark, side, subject};
use crate::escape::markdown;
use std::fmt::Write;

pub(super) fn document(verification: &Verification) -> String {
    let (file, bus) = (markdown(&verification.file), markdown(&verification.bus));
    let node = verification.node;
    let mut text = format!("# {file} and node {node} on {bus}\n\n{}.\n", verification.summary());
    // Writing to a string can't fail.
    let incomplete = verification.incomplete();
    if !incomplete.is_empty() {
        let _ = write!(text, "\n{incomplete}.\n");
    }
    let groups: [(&str, Vec<_>); 2] = [
        ("Differences", verification.differences().collect()),
        ("May be configuration or state", verification.explicable().collect()),
    ];
    for (title, mismatches) in groups {
        if mismatches.is_empty() {
            continue;
        }
        let _ =
            write!(text, "\n## {title}\n\n| object | what | described | found | meaning |\n|---|---|---|---|---|\n");
        for mismatch in mismatches {
            let what = [mismatch.kind.id(), remark(mismatch.weight)].join(" ");
            let [described, found] = [&mismatch.described, &mismatch.found].map(|it| markdown(&side(it)));
            let (object, meaning) = (markdown(&subject(mismatch)), mismatch.kind.meaning());
            let _ = writeln!(text, "| {object} | {} | {described} | {found} | {meaning} |", what.trim_end());
        }
    }
    text
}
