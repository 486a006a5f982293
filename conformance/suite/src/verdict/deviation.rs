//! Deviations: the documentation of the device or its user announces a breach and so excuses it.

use super::{Authority, Breach};
use crate::glob;
use crate::situation::Situation;
use canvass_bus::observation::{Pattern, Subject};
use canvass_device::models::{self, Model};

/// A difference from the standard that the device's own documentation announces, or that its user accepts: one
/// behaviour of one subject in a case, or in a situation wherever cases meet it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Deviation {
    /// The cases of the deviation: ids, or patterns with `*`.
    pub cases: Vec<String>,
    /// The subject of the deviation; `None` for any.
    pub subject: Option<Subject>,
    /// The situation of the deviation; `None` for any.
    pub situation: Option<Situation>,
    /// The behaviour of the device instead of the required one.
    pub does: Pattern,
    /// The text of the documentation or the waiver, with its source.
    pub documented: String,
    /// The authority that announces the deviation.
    pub by: Authority,
}

impl Deviation {
    /// The deviations in the manual of a built-in model.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let of_row = |row: &models::Deviation| Self {
            cases: vec![row.case.clone()],
            subject: Some(row.subject),
            situation: None,
            does: row.does.clone(),
            documented: row.documented.clone(),
            by: Authority::Manual,
        };
        model.deviations().iter().map(of_row).collect()
    }

    /// Whether the deviation explains this breach of the case.
    pub fn explains(&self, case: &str, breach: &Breach) -> bool {
        let in_situation = self.situation.is_none() || breach.row() == self.situation;
        self.cases.iter().any(|pattern| glob::matches(pattern, case))
            && self.subject.is_none_or(|subject| subject.covers(breach.subject))
            && in_situation
            && self.does.accepts(&breach.actual)
    }
}
