//! Entries for the failures of a run: what the user would otherwise copy out of the report. One entry is for one
//! behaviour in one situation, whatever cases see it.

use super::Waivers;
use crate::runner::CaseReport;
use crate::situation::Situation;
use crate::verdict::{Breach, Grade, Kind};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Duration;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The breaches that one entry excuses.
struct Entry<'a> {
    situation: Option<Situation>,
    subjects: Vec<Subject>,
    does: String,
    cases: BTreeSet<&'a str>,
    /// The first breach, which stands for all.
    first: &'a Breach,
}

/// The text of a waiver file with an entry for each failure that nothing excuses yet; `None` if there is none. The
/// reasons are empty: [`Waivers::read`] refuses the file until the user has written them. `last` is a day to suggest for
/// the end of the waivers, `YYYY-MM-DD`.
pub fn suggested(reports: &[&CaseReport], device: &str, last: &str) -> Option<String> {
    let mut entries: Vec<Entry<'_>> = Vec::new();
    for report in reports.iter().filter(|report| report.verdict.kind() == Kind::Fail) {
        let unexcused = report.verdict.breaches().iter().filter(|ruled| ruled.excuse.is_none());
        for breach in unexcused.map(|ruled| &ruled.breach).filter(|breach| breach.grade == Grade::Wrong) {
            add(&mut entries, report.case.id, breach);
        }
    }
    if entries.is_empty() {
        return None;
    }
    let one_line = |text: &str| text.replace(|c: char| c.is_control(), " ");
    let mut text = format!(
        "# Waivers for {}: one for each behaviour that a run found, and that nothing excused.\n# Write the reason of each \
         that you accept, remove the others. {} entries.\n",
        one_line(device),
        entries.len()
    );
    entries.iter().for_each(|entry| entry.write(&mut text, last));
    debug_assert!(Waivers::read(&text.replace("reason = \"\"", "reason = \"x\"")).is_ok(), "{text}");
    Some(text)
}

fn add<'a>(entries: &mut Vec<Entry<'a>>, case: &'a str, breach: &'a Breach) {
    let (situation, does) = (breach.row(), accepted(&breach.actual));
    let is_same = |entry: &&mut Entry<'a>| {
        let same_subject = situation.is_some() || entry.subjects.contains(&breach.subject);
        entry.situation == situation && entry.does == does && same_subject
    };
    match entries.iter_mut().find(is_same) {
        Some(entry) => {
            entry.cases.insert(case);
            if !entry.subjects.contains(&breach.subject) {
                entry.subjects.push(breach.subject);
            }
        }
        None => {
            let (subjects, cases) = (vec![breach.subject], BTreeSet::from([case]));
            entries.push(Entry { situation, subjects, does, cases, first: breach });
        }
    }
}

/// The pattern for a behaviour. A time that was measured differs a little in the next run, and so does a frame.
fn accepted(observation: &Observation) -> String {
    match observation {
        Observation::Time(time) => {
            let (least, most) = (Duration(time.0 - time.0 / 10), Duration(time.0.saturating_add(time.0 / 10)));
            format!("time {least}..{most}")
        }
        Observation::Frame(_) => "frame *".to_owned(),
        other => other.to_string(),
    }
}

impl Entry<'_> {
    fn write(&self, text: &mut String, last: &str) {
        let one_line = |text: &str| text.replace(|c: char| c.is_control(), " ");
        let cases: Vec<&str> = self.cases.iter().copied().collect();
        // Writing to a string can't fail.
        let _ = writeln!(text, "\n# {}", one_line(&self.first.to_string()));
        let _ = writeln!(text, "# in {}: {}", counted(cases.len()), cases.join(", "));
        text.push_str("[[waiver]]\n");
        match self.situation {
            Some(situation) => {
                let _ = writeln!(text, "situation = \"{}\"", situation.id());
            }
            None => {
                let list: Vec<String> = cases.iter().map(|case| quoted(case)).collect();
                let _ = match &list[..] {
                    [case] => writeln!(text, "case = {case}"),
                    _ => writeln!(text, "case = [{}]", list.join(", ")),
                };
            }
        }
        let object = match self.subjects[..] {
            [subject] => subject.to_string(),
            _ => "*".to_owned(),
        };
        let _ = writeln!(text, "object = {}\ndoes = {}", quoted(&object), quoted(&self.does));
        text.push_str("reason = \"\"                             # why it is accepted\n");
        let _ = writeln!(text, "# owner = \"\"                            # who answers for it\n# expires = {last}");
    }
}

fn counted(cases: usize) -> String {
    if cases == 1 { "1 case".to_owned() } else { format!("{cases} cases") }
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
