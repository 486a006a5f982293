//! Descriptions that can be read but are unusable.

use super::rules::{CONFLICT, HALF_READ};
use super::{DeviceDescription, EdsProblem, Rule};

/// Why a description is unusable.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Unusable {
    /// The file contains both sides of a merge conflict.
    #[error("line {0} begins an unresolved merge conflict: choose one side")]
    Conflict(u32),
    /// Half of the file can't be read.
    #[error("{0}: this is no device description")]
    HalfRead(String),
}

impl DeviceDescription {
    /// Refuses a description with an unresolved merge conflict, or with half of its lines unreadable.
    ///
    /// # Errors
    /// Why the description is unusable.
    pub fn usable(&self) -> Result<(), Unusable> {
        Unusable::find(&self.problems).map_or(Ok(()), Err)
    }
}

impl Unusable {
    fn find(problems: &[EdsProblem]) -> Option<Self> {
        let breach = |rule: &Rule| problems.iter().find(|problem| problem.rule == rule);
        if let Some(conflict) = breach(&CONFLICT) {
            return Some(Self::Conflict(conflict.line));
        }
        breach(&HALF_READ).map(|half| Self::HalfRead(half.found.clone()))
    }
}
