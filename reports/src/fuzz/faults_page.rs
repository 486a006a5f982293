//! Which faults the fuzzer finds, as a page of Markdown: what `docs/fuzz-faults.md` is.

use crate::escape::markdown;
use canvass_conformance::Fault;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The page.
pub fn page() -> String {
    let (found, others): (Vec<Fault>, Vec<Fault>) = Fault::ALL.iter().partition(|fault| fault.is_fuzzed());
    let mut page = String::from(
        "# Faults and the fuzzer\n\nMade by `canvass list faults --format markdown`. `canvass selftest --fuzz` proves the \
         first part.\n",
    );
    // Writing to a string can't fail.
    let _ = writeln!(page, "\n## Found: {}\n\n| fault | model | what the firmware does |\n|---|---|---|", found.len());
    for fault in &found {
        let _ = writeln!(page, "| `{fault}` | {} | {} |", fault.model(), markdown(fault.summary()));
    }
    let mut reasons: BTreeMap<&'static str, Vec<Fault>> = BTreeMap::new();
    for fault in others.iter().copied() {
        reasons.entry(fault.unfuzzed().unwrap_or_default()).or_default().push(fault);
    }
    let _ = writeln!(page, "\n## No matter of the fuzzer: {}", others.len());
    for (reason, faults) in reasons {
        let _ = writeln!(page, "\nIt {}:\n\n| fault | what the firmware does |\n|---|---|", markdown(reason));
        for fault in faults {
            let _ = writeln!(page, "| `{fault}` | {} |", markdown(fault.summary()));
        }
    }
    page
}
