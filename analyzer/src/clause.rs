//! Where a standard demands something, how sure that place is, and how strictly it is demanded.

use std::fmt;

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

    /// `CiA 301 7.5.2.20 (derived)`, but the standard alone where the section is not known: for places where that is no news.
    pub fn brief(&self) -> String {
        if self.section.is_some() { self.to_string() } else { self.standard.to_owned() }
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
