//! What excuses a breach: the documentation of the device, or its user.

use super::{Authority, Breach};
use crate::glob;
use canvass_bus::observation::{Pattern, Subject};
use canvass_device::models::{self, Model};

/// A difference from the standard that the device's own documentation announces, or that its user accepts: of one case,
/// about one subject, in one behaviour.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Deviation {
    /// The case that it explains: an id, or a pattern with `*`.
    pub case: String,
    /// What it is about.
    pub subject: Subject,
    /// What the device does instead of what the standard says.
    pub does: Pattern,
    /// What the documentation or the waiver says, and where.
    pub documented: String,
    /// Who says so.
    pub by: Authority,
}

impl Deviation {
    /// What the manual of a built-in model says.
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

    /// Whether it explains that breach of the case of that id.
    pub fn explains(&self, case: &str, breach: &Breach) -> bool {
        glob::matches(&self.case, case) && self.subject.covers(breach.subject) && self.does.accepts(&breach.actual)
    }
}
