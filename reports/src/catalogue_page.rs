//! All cases as a page of Markdown: what `docs/cases.md` is.

use crate::escape::markdown as escaped;
use canvass_suite::case::{Case, Level};
use std::fmt::Write;

const HEAD: &str = "\
# Conformance cases

Written by `canvass list cases --format markdown`; a test keeps this page current. `canvass explain ID` prints one in full.

A clause is printed with how sure its number is: without a word where the clause was read or an independent source cites
it, *(derived)* where it was counted between two such, *(unconfirmed)* where it comes from the structure of the standard. *catches* are the
firmware faults (`canvass list faults`) on which the case is known to fail: `canvass selftest` proves it.

## Waivers

Breaches that the user of a device accepts stand in a file for `--waivers`. They get the verdict *deviation*, as what the
device's own manual documents does.

```toml
[[waiver]]
case = \"301/pdo/mapping/*\"              # an id or a pattern with *
object = \"1A00:01\"                      # what the breach is about: an object, a service, \"TPDO 1\", \"device\"
does = \"abort 0604 0041h\"               # what the device does instead of what the standard says
reason = \"mapping is fixed, ticket 4711\"
expires = 2027-06-30                    # optional: the last day on which the waiver holds
```

A waiver excuses that behaviour of that object in that case, and nothing else: whatever else the case finds still fails. A
report prints `object` and `does` of each failure (*as data*), ready to be copied. What differs from run to run is named by a
range, `time 90 ms..110 ms` or `count 2..5`, or by its sort: `value *`, `number *`, `time *`, `count *`, `frame *`; an abort
is accepted with its code only.

A waiver that lacks one of these, or is for a case that does not exist, is an error with its line. One that has expired, or
that excused nothing in a run, is reported with what was found instead: waivers must not outlive what they are for.

## What is only noted

Where the standards say nothing, a case does not fail a device; what it does is a note in the report: SDO requests of
fewer than eight bytes (`301/sdo/frame/short`), whether unfinished transfers are ended (`301/sdo/transfer/silent-client`),
whether a block upload switches to a normal one (`301/sdo/block-upload/switch`), whether RPDOs and SYNC of a wrong length
are reported by EMCY (`301/rpdo/too-short`, `301/sync/wrong-length`), whether a new node-ID restarts the device at once
(`305/node-id/pending`), whether NMT frames of three to eight bytes are obeyed (`301/nmt/long-frame`), whether malformed
heartbeats count as a sign of life (`301/heartbeat-consumer/malformed`), whether an object can be mapped with fewer bits than
it has (`301/pdo/mapping/other-length`), which of several reasons wins in a refusal (`301/sdo/download/several-reasons`),
and which parameters are not the defaults of the description (`301/dictionary/after-reset`). Two PDOs with one CAN-ID are
not judged: stacks in the field differ, and none is wrong.
";

/// The page.
pub fn markdown(cases: &[&'static Case]) -> String {
    let mut page = HEAD.to_owned();
    let of = |level| cases.iter().filter(|case| case.level == level).count();
    let (must, should, open) = (of(Level::Must), of(Level::Should), of(Level::Open));
    // Writing to a string can't fail.
    let _ = writeln!(page, "\n## The catalogue\n\n{} cases: {must} must, {should} should, {open} open.", cases.len());
    for family in cases.chunk_by(|a, b| a.family() == b.family()) {
        let _ = writeln!(page, "\n### {}\n", family.first().map_or("", |case| case.family()));
        for case in family {
            entry(&mut page, case);
        }
    }
    page
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
