//! The file: an EDS, with a comment for each guess.

use super::{Guess, Scanned};
use crate::dictionary::check::check;
use crate::dictionary::eds;
use crate::dictionary::names;
use crate::dictionary::rules::Severity;
use crate::identity::{Multiplexer, SubIndex};
use std::collections::{BTreeMap, BTreeSet};

impl Scanned {
    /// The text of an EDS. Each guessed entry has a comment. A property that a check would report as an error has a
    /// waiver as comment, because the device really has the property.
    pub fn eds(&self) -> String {
        let (text, _) = eds::write(&self.description);
        let text = with_comments(&text, &self.by_section());
        with_comments(&text, &waivers(&text))
    }

    fn by_section(&self) -> BTreeMap<String, String> {
        let section = |at: Multiplexer| {
            let object = self.description.dictionary.object(at.index);
            let is_single = at.sub == SubIndex(0) && object.is_some_and(|object| object.code.is_single());
            if is_single { format!("{:04X}", at.index.0) } else { format!("{:04X}sub{:X}", at.index.0, at.sub.0) }
        };
        let comment = |guesses: &[Guess]| {
            let words: Vec<String> = guesses.iter().map(|guess| guess.to_string()).collect();
            format!("; guessed: {}", words.join("; "))
        };
        self.guesses.iter().map(|(at, guesses)| (section(*at), comment(guesses))).collect()
    }
}

/// Inserts comments into their sections; comments without section come first.
fn with_comments(text: &str, comments: &BTreeMap<String, String>) -> String {
    let mut commented = comments.get("").map(|comment| format!("{comment}\r\n")).unwrap_or_default();
    for line in text.split_inclusive('\n') {
        commented.push_str(line);
        if let Some(comment) = heading(line).and_then(|section| comments.get(section)) {
            commented.push_str(comment);
            commented.push_str("\r\n");
        }
    }
    commented
}

fn heading(line: &str) -> Option<&str> {
    line.trim_end().strip_prefix('[').and_then(|line| line.strip_suffix(']'))
}

/// The section that contains a line; empty for line 0, which stands for the whole file.
fn section_of(text: &str, line: u32) -> &str {
    text.lines().take(line as usize).filter_map(heading).last().unwrap_or_default()
}

/// Waivers for the device's own errors, such as a mapping with another length than the object's.
fn waivers(text: &str) -> BTreeMap<String, String> {
    let mut rules: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    let checked = check(text.as_bytes(), None);
    let findings = checked.iter().flat_map(|checked| &checked.findings);
    for finding in findings.filter(|finding| finding.severity() == Severity::Error) {
        let section = section_of(text, finding.line).to_owned();
        rules.entry(section).or_default().insert(finding.problem.rule.id);
    }
    let comment = |rules: BTreeSet<&str>| {
        let rules: Vec<&str> = rules.into_iter().collect();
        format!("; canvass: allow {} the device has it so", rules.join(", "))
    };
    rules.into_iter().map(|(section, rules)| (section, comment(rules))).collect()
}

impl std::fmt::Display for Guess {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TypeOf(1) => f.write_str("the data type, from 1 byte"),
            Self::TypeOf(bytes) => write!(f, "the data type, from {bytes} bytes"),
            Self::Type => f.write_str("the data type, as no value could be read"),
            Self::TypeBeside(bytes) => {
                write!(f, "the data type, from {bytes} bytes: the standard's has another length")
            }
            Self::Access => f.write_str("the access type, which only writing would show"),
        }
    }
}

/// The sources of the standard names: `CiA 301, 302, 304`, and the device profiles.
fn standards() -> String {
    let profiles = names::profiles().map(|profile| profile.number().to_string());
    let mut numbers: Vec<String> = ["302", "304"].map(str::to_owned).into_iter().chain(profiles).collect();
    let last = numbers.pop().unwrap_or_default();
    format!("CiA 301, {} and {last}", numbers.join(", "))
}

/// The comments about the whole file.
pub(super) fn comments(guesses: &BTreeMap<Multiplexer, Vec<Guess>>) -> Vec<String> {
    let guessed = match guesses.len() {
        0 => "No single entry had to be guessed.".to_owned(),
        1 => "1 entry is partly guessed: see the comment in its section.".to_owned(),
        count => format!("{count} entries are partly guessed: see the comments in their sections."),
    };
    let lines = [
        "Read from a device, as a start: nothing was written to it.",
        &format!("Names, types and access of standard objects are those of {}.", standards()),
        "Defaults are the values that the device had when it was read.",
        "PDOMapping=1 marks the objects that were mapped; limits, LSS and further bit rates are unknown.",
    ];
    lines.into_iter().map(str::to_owned).chain([guessed]).collect()
}
