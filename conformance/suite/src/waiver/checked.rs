//! Waivers beside the result of a run: which are used, which excuse nothing, and which are wider than they need be.

use super::{Waiver, Waivers};
use canvass_bus::observation::{Pattern, Subject};
use std::collections::BTreeSet;

/// A breach of a result.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Found {
    /// The id of the case.
    pub case: String,
    /// The subject of the breach.
    pub subject: Subject,
    /// The id of the situation, if it is one of the table of allowed answers.
    pub situation: Option<String>,
    /// The pattern of what was found.
    pub does: Pattern,
}

/// A waiver beside a result.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Checked<'a> {
    /// The waiver.
    pub waiver: &'a Waiver,
    /// What it is good for.
    pub usage: Use,
}

/// What a waiver is good for.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Use {
    /// It excuses this many breaches.
    Used(usize),
    /// It excuses breaches, but could name what it excuses: the sentence says what.
    TooWide(usize, String),
    /// It excuses nothing; the nearest breaches, as `object: behaviour in case`.
    Unused(Vec<String>),
    /// Its last day is over.
    Expired,
}

/// Maximum number of breaches that are near an unused waiver.
const SHOWN: usize = 3;

impl Waivers {
    /// Each waiver beside the breaches of a result, on this day.
    pub fn checked(&self, today: &str, found: &[Found]) -> Vec<Checked<'_>> {
        self.waivers.iter().map(|waiver| Checked { waiver, usage: waiver.usage(today, found) }).collect()
    }
}

impl Waiver {
    fn usage(&self, today: &str, found: &[Found]) -> Use {
        if self.has_expired(today) {
            return Use::Expired;
        }
        let excused: Vec<&Found> = found.iter().filter(|breach| self.matched(breach) == [true; 4]).collect();
        if excused.is_empty() {
            return Use::Unused(self.near(found));
        }
        match self.narrower(&excused) {
            Some(how) => Use::TooWide(excused.len(), how),
            None => Use::Used(excused.len()),
        }
    }

    /// Whether case, situation, object and behaviour of a breach are those of the waiver.
    fn matched(&self, breach: &Found) -> [bool; 4] {
        let situation = self.situation.map(|situation| situation.id());
        [
            self.is_for(&breach.case),
            situation.is_none() || breach.situation.as_deref() == situation,
            self.subject.is_none_or(|subject| subject.covers(breach.subject)),
            self.does.covers(&breach.does),
        ]
    }

    /// Breaches that lack one property only.
    fn near(&self, found: &[Found]) -> Vec<String> {
        let lacks_one = |breach: &&Found| self.matched(breach).iter().filter(|is_same| !**is_same).count() == 1;
        let mut near: Vec<String> = found
            .iter()
            .filter(lacks_one)
            .map(|Found { case, subject, does, .. }| format!("{subject}: {does} in {case}"))
            .collect();
        near.dedup();
        near.truncate(SHOWN);
        near
    }

    /// How the waiver could name what it excuses, if a pattern of it stands for one thing only.
    fn narrower(&self, excused: &[&Found]) -> Option<String> {
        let cases: BTreeSet<&str> = excused.iter().map(|breach| &*breach.case).collect();
        let subjects: Vec<Subject> = excused.iter().map(|breach| breach.subject).collect();
        let is_pattern = self.situation.is_none() && self.cases.iter().any(|case| case.contains('*'));
        if let (true, [case]) = (is_pattern, &cases.iter().copied().collect::<Vec<_>>()[..]) {
            return Some(format!("its case could be {case}"));
        }
        let first = subjects.first()?;
        if self.subject.is_none() && subjects.iter().all(|subject| subject == first) {
            return Some(format!("its object could be {first}"));
        }
        let idle = self.cases.iter().find(|pattern| {
            let is_used = cases.iter().any(|case| crate::glob::matches(pattern, case));
            self.cases.len() > 1 && !is_used
        });
        idle.map(|case| format!("nothing is excused in {case}"))
    }
}

impl Checked<'_> {
    /// Whether the waiver is as it should be.
    pub const fn is_good(&self) -> bool {
        matches!(self.usage, Use::Used(_))
    }

    /// Where the waiver holds, and what it accepts.
    pub fn text(&self) -> [String; 3] {
        [self.waiver.place(), self.waiver.subject_text(), self.waiver.does.to_string()]
    }
}
