//! The cases that did not apply, by reason: many share one.

use super::Run;
use crate::escape::printable;
use canvass_suite::verdict::{Kind, Lack, Reason};
use std::io::{self, Write};

/// Cases that did not apply.
#[derive(Debug, Default)]
pub struct Skipped {
    reasons: Vec<(Reason, Vec<&'static str>)>,
}

impl Skipped {
    /// Adds a case.
    pub fn add(&mut self, case: &'static str, reason: &Reason) {
        match self.reasons.iter_mut().find(|(known, _)| known == reason) {
            Some((_, cases)) => cases.push(case),
            None => self.reasons.push((reason.clone(), vec![case])),
        }
    }

    /// Those of a whole run.
    pub fn of(run: &Run) -> Self {
        let mut skipped = Self::default();
        for report in run.cases.iter().filter(|report| report.verdict.kind() == Kind::NotApplicable) {
            skipped.add(report.case.id, &report.verdict.reason().unwrap_or_default());
        }
        skipped
    }

    /// What was needed and what was there instead, each with the cases that did not apply for it; those of most cases first.
    pub fn groups(&self) -> Vec<(String, &[&'static str])> {
        let mut groups: Vec<_> = self.reasons.iter().map(|(reason, cases)| (sentence(reason, ""), &**cases)).collect();
        groups.sort_by_key(|(_, cases)| std::cmp::Reverse(cases.len()));
        groups
    }

    /// Whether all cases applied.
    pub const fn is_empty(&self) -> bool {
        self.reasons.is_empty()
    }

    /// Writes each reason with its cases, in lines of at most so many columns where an id fits in. `allow` is what the user
    /// has to type before the name of a permission.
    ///
    /// # Errors
    /// As far as nothing can be written.
    pub fn write(&self, width: u16, allow: &str, out: &mut impl Write) -> io::Result<()> {
        for (reason, cases) in &self.reasons {
            writeln!(out, "  {}", printable(&sentence(reason, allow)))?;
            for line in lines(cases, usize::from(width)) {
                writeln!(out, "    {line}")?;
            }
        }
        Ok(())
    }
}

/// What was needed, and what was there instead; not twice where the one names the other.
fn sentence(reason: &Reason, allow: &str) -> String {
    let Reason { expected, actual, lack, .. } = reason;
    if *lack == Lack::Permission {
        return format!("{actual} ({allow}{expected})");
    }
    if actual.contains(expected.as_str()) { actual.clone() } else { format!("{expected}: {actual}") }
}

/// The ids, as many in a line as fit after its indentation.
fn lines(ids: &[&str], width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for (at, id) in ids.iter().enumerate() {
        let comma = if at + 1 < ids.len() { "," } else { "" };
        match lines.last_mut() {
            Some(line) if 4 + line.len() + 1 + id.len() + comma.len() <= width => {
                line.push(' ');
                line.push_str(id);
                line.push_str(comma);
            }
            _ => lines.push(format!("{id}{comma}")),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_of_one_reason_share_its_line() {
        let blocks = Reason::new("the case has what it needs", "SDO block uploads", "answered by an abort");
        let nvm = Reason::new("the user allows it", "nvm", "not allowed: it writes").for_lack_of(Lack::Permission);
        let mut skipped = Skipped::default();
        assert!(skipped.is_empty());
        for (case, reason) in [("301/a", &blocks), ("301/store", &nvm), ("301/b", &blocks), ("301/longer", &blocks)] {
            skipped.add(case, reason);
        }
        let mut text = Vec::new();
        skipped.write(18, "--allow ", &mut text).unwrap();
        let expected = "  SDO block uploads: answered by an abort\n    301/a, 301/b,\n    301/longer\n\
                        \x20 not allowed: it writes (--allow nvm)\n    301/store\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }
}
