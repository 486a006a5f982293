//! The faults that the fuzzer finds, as a page of Markdown: a reference page of the book.

use crate::escape::markdown;
use canvass_device::Fault;
use std::collections::BTreeMap;
use std::fmt::Write as _;

pub fn page() -> String {
    let (found, others): (Vec<Fault>, Vec<Fault>) = Fault::ALL.iter().partition(|fault| fault.unfuzzed().is_none());
    let (more, found): (Vec<Fault>, Vec<Fault>) = found.into_iter().partition(|fault| fault.fuzz_needs().is_some());
    let mut page = String::from(
        "# Faults and the fuzzer\n\n`canvass selftest --fuzz` proves the \
         first two parts.\n",
    );
    // Writing to a string can't fail.
    let _ = writeln!(page, "\n## Found: {}\n\n| fault | model | what the firmware does |\n|---|---|---|", found.len());
    for fault in &found {
        let _ = writeln!(page, "| `{fault}` | {} | {} |", fault.model(), markdown(fault.summary()));
    }
    let _ = writeln!(page, "\n## Found with `--allow`: {}\n", more.len());
    let _ = writeln!(page, "| fault | model | `--allow` | what the firmware does |\n|---|---|---|---|");
    for fault in &more {
        let (model, touch) = (fault.model(), fault.fuzz_needs().unwrap_or_default());
        let _ = writeln!(page, "| `{fault}` | {model} | `{touch}` | {} |", markdown(fault.summary()));
    }
    let mut reasons: BTreeMap<&'static str, Vec<Fault>> = BTreeMap::new();
    for fault in others.iter().copied() {
        reasons.entry(fault.unfuzzed().unwrap_or_default()).or_default().push(fault);
    }
    let _ = writeln!(page, "\n## Not claimed by the fuzzer: {}", others.len());
    let _ = writeln!(page, "\nIt may find some of them, but it does not claim to.");
    for (reason, faults) in reasons {
        let _ = writeln!(page, "\nThe fault {}:\n\n| fault | what the firmware does |\n|---|---|", markdown(reason));
        for fault in faults {
            let _ = writeln!(page, "| `{fault}` | {} |", markdown(fault.summary()));
        }
    }
    page
}
