//! `--fix` and `--diff`.

use crate::commands::eds::found::Description;
use crate::output::diagnostic;
use crate::whole_file::WholeFile;
use anyhow::{Context, Result, bail};
use canvass_analyzer::dictionary::check::{Finding, apply_fixes, check};
use similar::TextDiff;
use std::io::Write;

/// Writes the fixed file, and reports it. Files without fixes are not written.
pub fn fix_file(description: &mut Description, wanted: impl Fn(&Finding) -> bool) -> Result<()> {
    if description.is_input() {
        bail!("standard input can't be overwritten: use --diff to see the changes");
    }
    let name = description.path.display().to_string();
    let fixed = apply_fixes(&description.bytes, wanted).with_context(|| format!("can't check {name}"))?;
    if fixed.bytes == description.bytes {
        return Ok(());
    }
    let file = WholeFile::create(&description.path)?;
    file.writer()?.write_all(&fixed.bytes).with_context(|| format!("can't write {name}"))?;
    file.complete()?;
    let number = fixed.rules.len();
    diagnostic(&format!("{name}: {number} finding{} fixed", if number == 1 { "" } else { "s" }));
    description.bytes = fixed.bytes;
    Ok(())
}

/// The changes as a unified diff; empty if there are none.
pub fn difference(description: &Description, text: &str, wanted: impl Fn(&Finding) -> bool) -> Result<String> {
    let failed = || format!("can't check {}", description.path.display());
    let fixed = apply_fixes(&description.bytes, wanted).with_context(failed)?;
    if fixed.bytes == description.bytes {
        return Ok(String::new());
    }
    let new = check(&fixed.bytes, None).with_context(failed)?;
    let (before, after) = (format!("a/{}", description.name), format!("b/{}", description.name));
    // Differences in line ends would make every line of the diff differ; they are reported separately.
    let plain = |text: &str| text.replace("\r\n", "\n").replace('\r', "\n");
    let (old, new) = (plain(text), plain(&new.source.text));
    let diff = TextDiff::from_lines(old.as_str(), new.as_str());
    let mut shown = diff.unified_diff().context_radius(2).header(&before, &after).to_string();
    if shown.is_empty() {
        shown = format!("--- {before}\n+++ {after}\n(line ends or character set)\n");
    }
    Ok(shown)
}
