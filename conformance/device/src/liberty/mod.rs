//! Liberties: behaviour of a firmware that differs from the plain simulated device's, and is right because the standard
//! leaves it free. A liberty is the counterpart of a fault: the cases must find each fault, and must not fail on a
//! liberty.

mod catalogue;
mod description;
mod dictionary;
mod edit;
mod timing;

pub use catalogue::Liberty;
pub(crate) use description::{changes_text, rewrite};
pub(crate) use dictionary::apply;

use canvass_analyzer::meant;
use std::fmt;
use std::str::FromStr;

/// A set of liberties, one bit for each.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Liberties([u64; WORDS]);

const WORDS: usize = Liberty::ALL.len().div_ceil(u64::BITS as usize);

impl Liberties {
    /// The empty set: a firmware that takes no liberty.
    pub const NONE: Self = Self([0; WORDS]);

    /// The set with one more liberty.
    pub const fn with(mut self, liberty: Liberty) -> Self {
        self.0[liberty as usize / u64::BITS as usize] |= Self::bit(liberty);
        self
    }

    /// Whether the set contains the liberty.
    pub const fn has(self, liberty: Liberty) -> bool {
        self.0[liberty as usize / u64::BITS as usize] & Self::bit(liberty) != 0
    }

    /// Whether the set is empty.
    pub fn is_empty(self) -> bool {
        self == Self::NONE
    }

    const fn bit(liberty: Liberty) -> u64 {
        1 << (liberty as usize % u64::BITS as usize)
    }

    /// The liberties of the set, in the order of their definition.
    pub fn iter(self) -> impl Iterator<Item = Liberty> {
        Liberty::ALL.iter().copied().filter(move |&liberty| self.has(liberty))
    }
}

impl FromIterator<Liberty> for Liberties {
    fn from_iter<T: IntoIterator<Item = Liberty>>(liberties: T) -> Self {
        liberties.into_iter().fold(Self::NONE, Self::with)
    }
}

impl From<Liberty> for Liberties {
    fn from(liberty: Liberty) -> Self {
        Self::NONE.with(liberty)
    }
}

impl fmt::Debug for Liberties {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

impl fmt::Display for Liberty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// No liberty has this name.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no liberty is called \"{0}\"{hint}: `canvass list liberties` shows them", hint = meant(.0, Liberty::ALL.iter().map(|liberty| liberty.id())))]
pub struct UnknownLiberty(pub String);

impl FromStr for Liberty {
    type Err = UnknownLiberty;

    fn from_str(id: &str) -> Result<Self, UnknownLiberty> {
        Self::ALL.iter().copied().find(|liberty| liberty.id() == id).ok_or_else(|| UnknownLiberty(id.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fault;
    use crate::models::Model;

    #[test]
    fn names_are_unique_and_found() {
        for &liberty in Liberty::ALL {
            assert_eq!(liberty.id().parse(), Ok(liberty));
            assert!(liberty.id().parse::<Fault>().is_err(), "{liberty} is a fault too");
            assert!(Model::by_id(liberty.model()).is_some(), "{liberty}");
            assert!(liberty.clause().starts_with("CiA 30"), "{liberty}");
        }
        assert!("nonsense".parse::<Liberty>().is_err());
    }

    #[test]
    fn sets_hold_what_was_put_in() {
        assert_eq!(Liberty::ALL.iter().copied().collect::<Liberties>().iter().collect::<Vec<_>>(), Liberty::ALL);
        assert!(Liberties::NONE.is_empty() && !Liberties::from(Liberty::NoEmcy).is_empty());
    }
}
