//! What a conformance case is: an item of the catalogue.

use crate::bench::Bench;
pub use crate::need::Need;
use crate::verdict::Judged;
use canvass_device::Fault;
use std::fmt;
use std::str::FromStr;

/// A case of the catalogue, registered by the `#[case]` attribute.
#[derive(Debug)]
pub struct Case {
    /// Stable and textual: `301/sdo/download/read-only`.
    pub id: &'static str,
    /// What the standard demands, in the words of its author: the doc comment of the case.
    pub requirement: &'static str,
    /// Where the standard demands it.
    pub clause: Clause,
    /// How strictly it is demanded.
    pub level: Level,
    /// Features without which the case is not applicable.
    pub needs: &'static [&'static Need],
    /// What the case does that the user must allow first.
    pub touches: &'static [Touch],
    /// Firmware faults, each of which makes the case fail.
    pub catches: &'static [Fault],
    /// The number of a comparable case of CiA's conformance test tool.
    pub cct: Option<&'static str>,
    /// Stimulus and verdict.
    pub run: fn(&mut Bench<'_>) -> Judged,
}

inventory::collect!(Case);

impl Case {
    /// Standard and service: the first two words of the id, such as `301/sdo`.
    pub fn family(&self) -> &'static str {
        self.id.match_indices('/').nth(1).map_or(self.id, |(at, _)| self.id.get(..at).unwrap_or(self.id))
    }

    /// The first sentence of the requirement: a line for lists.
    pub fn summary(&self) -> &'static str {
        let paragraph = self.requirement.split("\n\n").next().unwrap_or(self.requirement);
        paragraph.split_inclusive(". ").next().unwrap_or(paragraph).trim_end()
    }
}

/// A place in a standard, and how sure it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Clause {
    /// `CiA 301`.
    pub standard: &'static str,
    /// `7.2.8.2.3.1`, where it is known.
    pub section: Option<&'static str>,
    /// How sure the section is.
    pub confidence: Confidence,
}

/// How sure the number of a section is. Of most standards the text is not public: their numbers come from those who cite it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Confidence {
    /// The clause was read, in a public edition of the standard.
    Cited,
    /// An independent source cites it.
    Attested,
    /// Counted between two attested sections.
    Derived,
    /// From general knowledge of the standard's structure.
    Known,
    /// The section is not known.
    Unknown,
}

impl Confidence {
    /// The word for it in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cited => "cited",
            Self::Attested => "attested",
            Self::Derived => "derived",
            Self::Known => "known",
            Self::Unknown => "unknown",
        }
    }
}

impl Clause {
    /// `CiA 301 7.2.8.2.3.1` without a word on how sure it is: only where [`Clause::confidence`] stands beside it.
    pub fn bare(&self) -> String {
        match self.section {
            Some(section) => format!("{} {section}", self.standard),
            None => self.standard.to_owned(),
        }
    }
}

/// Never shows a section as certain that is not: `CiA 301 7.5.2.20 (derived)`.
impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.section, self.confidence) {
            (Some(section), Confidence::Cited | Confidence::Attested) => write!(f, "{} {section}", self.standard),
            (Some(section), Confidence::Derived) => write!(f, "{} {section} (derived)", self.standard),
            (Some(section), _) => write!(f, "{} {section} (unconfirmed)", self.standard),
            (None, _) => write!(f, "{}, section unknown", self.standard),
        }
    }
}

/// How strictly the standard demands something.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Level {
    /// The standard says "shall".
    Must,
    /// The standard recommends it, or several readings are plausible.
    Should,
    /// The standard leaves it open: what the device does is recorded and never fails.
    Open,
}

impl Level {
    /// The word for it in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Must => "must",
            Self::Should => "should",
            Self::Open => "open",
        }
    }
}

/// What a case does to a device or a bus that is not done without the user's leave.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Touch {
    /// Writes non-volatile memory, which wears out.
    Nvm,
    /// Changes the node-ID.
    NodeId,
    /// Changes the bit rate.
    BitRate,
    /// Commands other nodes than the device under test.
    OtherNodes,
    /// Restores the factory defaults: what the user had configured is lost.
    FactoryDefaults,
}

impl Touch {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Nvm, Self::NodeId, Self::BitRate, Self::OtherNodes, Self::FactoryDefaults];

    /// The name for `--allow`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nvm => "nvm",
            Self::NodeId => "node-id",
            Self::BitRate => "bit-rate",
            Self::OtherNodes => "other-nodes",
            Self::FactoryDefaults => "factory-defaults",
        }
    }

    /// What the case would do.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Nvm => "writes non-volatile memory",
            Self::NodeId => "changes the node-ID",
            Self::BitRate => "changes the bit rate",
            Self::OtherNodes => "commands other nodes",
            Self::FactoryDefaults => "restores the factory defaults",
        }
    }
}

impl fmt::Display for Touch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is nothing of that name to allow.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("nothing to allow is called \"{0}\": there are nvm, node-id, bit-rate, other-nodes and factory-defaults")]
pub struct UnknownTouch(pub String);

impl FromStr for Touch {
    type Err = UnknownTouch;

    fn from_str(name: &str) -> Result<Self, UnknownTouch> {
        Self::ALL.into_iter().find(|touch| touch.name() == name).ok_or_else(|| UnknownTouch(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clause_that_is_not_attested_never_looks_certain() {
        let clause = |section, confidence| Clause { standard: "CiA 301", section, confidence }.to_string();
        assert_eq!(clause(Some("7.2.8.2.3.1"), Confidence::Attested), "CiA 301 7.2.8.2.3.1");
        assert_eq!(clause(Some("7.5.2.20"), Confidence::Derived), "CiA 301 7.5.2.20 (derived)");
        assert_eq!(clause(Some("7.2.4.3.6"), Confidence::Known), "CiA 301 7.2.4.3.6 (unconfirmed)");
        assert_eq!(clause(None, Confidence::Unknown), "CiA 301, section unknown");
    }

    #[test]
    fn names_to_allow_are_found() {
        for touch in Touch::ALL {
            assert_eq!(touch.name().parse(), Ok(touch));
        }
        assert!("everything".parse::<Touch>().is_err());
    }
}
