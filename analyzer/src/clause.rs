//! References to standards: the clause, its certainty, and the level of the requirement.

use std::fmt;

/// A place in a standard, and its certainty.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Clause {
    /// `CiA 301`.
    pub standard: &'static str,
    /// The section, such as `7.2.8.2.3.1`, if it is known.
    pub section: Option<&'static str>,
    /// How certain the section is.
    pub confidence: Confidence,
}

/// How certain the number of a section is. The text of most standards is not public: their numbers come from
/// documents that cite them.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Confidence {
    /// The section was read in a public edition of the standard.
    Cited,
    /// An independent source cites the section.
    Attested,
    /// The number was counted between two attested sections.
    Derived,
    /// The number comes from general knowledge of the standard's structure.
    Known,
    /// The section is not known.
    Unknown,
}

impl Confidence {
    /// The name in JSON.
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
    /// `CiA 301 7.2.8.2.3.1` without its certainty: for places that show [`Clause::confidence`] beside it.
    pub fn bare(&self) -> String {
        match self.section {
            Some(section) => format!("{} {section}", self.standard),
            None => self.standard.to_owned(),
        }
    }

    /// `CiA 301 7.5.2.20 (derived)`, or the standard alone if the section is unknown.
    pub fn brief(&self) -> String {
        if self.section.is_some() { self.to_string() } else { self.standard.to_owned() }
    }
}

/// `CiA 301 7.5.2.20 (derived)`: an uncertain section is always marked as such.
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

/// How strictly the standard requires a behaviour.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Level {
    /// The standard says "shall".
    Must,
    /// The standard recommends the behaviour, or several readings are plausible.
    Should,
    /// The standard leaves the behaviour open: it is recorded and never fails.
    Open,
}

impl Level {
    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Must => "must",
            Self::Should => "should",
            Self::Open => "open",
        }
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
        let brief = |section, confidence| Clause { standard: "CiA 301", section, confidence }.brief();
        assert_eq!(brief(Some("7.5.2.20"), Confidence::Derived), "CiA 301 7.5.2.20 (derived)");
        assert_eq!(brief(None, Confidence::Unknown), "CiA 301");
    }
}
