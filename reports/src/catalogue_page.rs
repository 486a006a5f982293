//! All cases as a page of Markdown: a reference page of the book.

use crate::answers;
use crate::escape::markdown as escaped;
use canvass_suite::case::Case;
use canvass_suite::clause::Level;
use canvass_suite::situation::Situation;
use std::fmt::Write;

const HEAD: &str = "\
# Conformance cases

`canvass explain ID` prints one case in full.

A clause is printed with how sure its number is: without a word where the clause was read or an independent source cites
it, *(derived)* where it was counted between two such, *(unconfirmed)* where it comes from the structure of the standard. *catches* are the
firmware faults (`canvass list faults`) on which the case is known to fail: `canvass selftest` proves it.

## What is only noted

Cases of level *open* are about what the standard leaves free: they record what the device does and never fail. Other cases
note, beside their verdict, what no standard decides: how SDO requests of fewer than eight bytes are answered
(`301/sdo/frame/short`), whether unfinished transfers are ended (`301/sdo/transfer/silent-client`), whether a block upload
switches to a normal one (`301/sdo/block-upload/switch`), whether a new node-ID restarts the device at once
(`305/node-id/pending`), whether NMT frames of three to eight bytes are obeyed (`301/nmt/long-frame`), whether malformed
heartbeats count as a sign of life (`301/heartbeat-consumer/malformed`), whether an object can be mapped with fewer bits
than it has (`301/pdo/mapping/other-length`), and which parameters are not the defaults of the description
(`301/dictionary/after-reset`). Two PDOs with one CAN-ID are not judged: stacks in the field differ, and none is wrong.

## Cases of CiA 301 without a cited clause

The text of CiA 301 was read for all but these. 100Bh (`301/dictionary/node-id`), 1004h (`301/dictionary/number-of-pdos`)
and 100Eh (`301/guarding/cob-id`) are objects of its third edition, which the fourth no longer has; devices in the field have
them. Starting without a command (`301/boot-up/self-start`) is the matter of CiA 302-2. That a remote frame is no request
(`301/sdo/frame/remote`) and that a short request does no harm (`301/sdo/frame/short`) is said nowhere: these two are *should*.
";

/// The page with the cases.
pub fn markdown(cases: &[&'static Case]) -> String {
    let mut page = HEAD.to_owned();
    let of = |level| cases.iter().filter(|case| case.level == level).count();
    let (must, should, open) = (of(Level::Must), of(Level::Should), of(Level::Open));
    // Writing to a string can't fail.
    situations(&mut page);
    let _ = writeln!(page, "\n## The catalogue\n\n{} cases: {must} must, {should} should, {open} open.", cases.len());
    table(&mut page, cases);
    for family in cases.chunk_by(|a, b| a.family() == b.family()) {
        let _ = writeln!(page, "\n### {}\n", family.first().map_or("", |case| case.family()));
        for case in family {
            entry(&mut page, case);
        }
    }
    page
}

/// Appends the table of allowed answers.
fn situations(page: &mut String) {
    page.push_str(
        "\n## Allowed answers\n\nWhat passes in which situation, the best answer first. Cases and the fuzzer ask this one table; \
         `canvass explain SITUATION` prints a row. What is *tolerated* passes with a remark: only CiA's own test tool accepts it.\n\n\
         | situation | what has to happen | clause | level | allowed | tolerated |\n|---|---|---|---|---|---|\n",
    );
    for &row in Situation::ALL {
        let answers = row.answers();
        let (allowed, tolerated) = (answers::allowed(row), answers::tolerated(row));
        let (clause, level) = (answers.clause, answers.level.name());
        let _ =
            writeln!(page, "| `{}` | {} | {clause} | {level} | {allowed} | {tolerated} |", row.id(), row.requirement());
    }
}

/// Appends a row for each case: its clause, confidence and level, and the allowed answers.
fn table(page: &mut String, cases: &[&'static Case]) {
    page.push_str("\n| case | clause | confidence | level | allowed answers |\n|---|---|---|---|---|\n");
    for case in cases {
        let asked = case.answers.iter().map(|row| format!("`{}`: {}", row.id(), answers::allowed(*row)));
        let asked: Vec<String> = asked.collect();
        let allowed = if asked.is_empty() { escaped(case.summary()) } else { asked.join("; ") };
        let (clause, confidence) = (case.clause.bare(), case.clause.confidence.name());
        let _ = writeln!(page, "| `{}` | {clause} | {confidence} | {} | {allowed} |", case.id, case.level.name());
    }
    page.push_str("\nWhere a case judges no single answer, the last column says what has to be seen.\n");
}

fn entry(page: &mut String, case: &Case) {
    let words = |items: Vec<String>| items.join(", ");
    let faults = words(case.catches.iter().map(ToString::to_string).collect());
    let _ = write!(page, "- **`{}`** ({}, {})", case.id, case.clause, case.level.name());
    for paragraph in case.requirement.split("\n\n") {
        let _ = write!(page, "\n  {}", escaped(paragraph));
    }
    let needs = words(case.needs.iter().map(|need| need.text().to_owned()).collect());
    let touches = words(case.touches.iter().map(|touch| format!("`--allow {touch}`")).collect());
    for (name, text) in [("needs", needs), ("asks for", touches), ("catches", faults)] {
        if !text.is_empty() {
            let _ = write!(page, "\n  *{name}:* {text}.");
        }
    }
    if let Some(number) = case.cct {
        let _ = write!(page, "\n  *comparable with case of CiA's tool:* {number}.");
    }
    page.push('\n');
}
