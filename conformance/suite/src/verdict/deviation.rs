//! Deviations: the documentation of the device or its user announces a breach and so excuses it.

use super::{Authority, Breach};
use crate::glob;
use canvass_bus::observation::{Pattern, Subject};
use canvass_device::models::{self, Model};

/// A difference from the standard that the device's own documentation announces, or that its user accepts. It covers
/// one case, one subject and one behaviour.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Deviation {
    /// The case of the deviation: an id, or a pattern with `*`.
    pub case: String,
    /// The subject of the deviation.
    pub subject: Subject,
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
            case: row.case.clone(),
            subject: row.subject,
            does: row.does.clone(),
            documented: row.documented.clone(),
            by: Authority::Manual,
        };
        model.deviations().iter().map(of_row).collect()
    }

    /// Whether the deviation explains this breach of the case.
    pub fn explains(&self, case: &str, breach: &Breach) -> bool {
        glob::matches(&self.case, case) && self.subject.covers(breach.subject) && self.does.accepts(&breach.actual)
    }
}
