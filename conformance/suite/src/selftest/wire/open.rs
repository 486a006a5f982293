//! The reviewed list of mutants that the standard leaves open.

use super::Mutant;
use crate::glob;
use serde::Deserialize;

/// Mutants that are right, with the reasons.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Open {
    open: Vec<Group>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Group {
    mutants: Vec<String>,
    reason: String,
}

impl Open {
    /// # Errors
    /// The error of the list if it can't be read.
    pub fn read() -> Result<Self, toml::de::Error> {
        toml::from_str(include_str!("open.toml"))
    }

    /// The reason why the mutant is right; `None` if it is not listed.
    pub fn reason(&self, mutant: &Mutant) -> Option<&str> {
        let id = mutant.to_string();
        let group = self.open.iter().find(|group| group.mutants.iter().any(|pattern| glob::matches(pattern, &id)))?;
        Some(&group.reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::wire::Primitive;

    /// A pattern that matches no mutant would have no effect.
    #[test]
    fn every_pattern_is_that_of_a_mutant() {
        let ids: Vec<String> = Mutant::all(&Primitive::all()).iter().map(ToString::to_string).collect();
        for group in Open::read().unwrap().open {
            assert!(group.reason.len() > 20, "{}", group.reason);
            for pattern in group.mutants {
                assert!(ids.iter().any(|id| glob::matches(&pattern, id)), "{pattern}");
            }
        }
    }
}
