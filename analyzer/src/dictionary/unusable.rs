//! Descriptions that describe nothing although they can be read.

use super::rules::{CONFLICT, HALF_READ};
use super::{DeviceDescription, EdsProblem, Rule};

/// Why a description describes nothing.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Unusable {
    /// Both sides of a merge stand in it.
    #[error("line {0} begins a merge conflict that nobody has resolved: choose one side")]
    Conflict(u32),
    /// Half of it can't be read.
    #[error("{0}: this is no device description")]
    HalfRead(String),
}

impl DeviceDescription {
    /// Refuses one with both sides of a merge conflict, or of which half can't be read.
    ///
    /// # Errors
    /// Why it describes nothing.
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
