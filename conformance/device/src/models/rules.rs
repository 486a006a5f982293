//! `[[link]]` and `[[check]]` of a sheet: which objects hold the same value, and which values an object refuses.

use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Index, Multiplexer, SubIndex};
use serde::de::IgnoredAny as ForPeople;
use serde::{Deserialize, Deserializer, de};

/// Objects whose values depend on each other.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// How the values depend on each other.
    pub kind: LinkKind,
    #[serde(deserialize_with = "super::sheet::addresses")]
    pub objects: Vec<Multiplexer>,
    /// Where the manual says it: for readers of the file, not used by the program.
    #[serde(default)]
    pub source: ForPeople,
}

/// How the values of linked objects depend on each other.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LinkKind {
    /// All hold the same value: a write to one is a write to all.
    Same,
    /// The first always shows the value of the second.
    Follows,
}

/// A rule for writing an object beyond its limits, and what answers a breach.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// The objects that it holds for.
    pub at: Addresses,
    pub rule: Rule,
    /// The object that the value is compared with, where the rule compares.
    #[serde(default, deserialize_with = "super::sheet::address_option")]
    pub of: Option<Multiplexer>,
    /// The SDO abort code of a breach.
    #[serde(deserialize_with = "abort_code")]
    pub abort: AbortCode,
    /// Which of these values the manual does not say: for readers of the file.
    #[serde(default)]
    pub assumed: ForPeople,
    /// Where the manual says it: for readers of the file, not used by the program.
    #[serde(default)]
    pub source: ForPeople,
}

/// The rules that a sheet can name. Those of CiA 301 hold for every device; a row in the sheet gives the abort code of
/// this one.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// 6001h is at most 6002h.
    UnitsAtMostRange,
    /// The value is a position that the encoder can show.
    InsideActiveRange,
    /// 1016h: no second time for a node-ID; an entry is erased before it is given another node-ID.
    OneConsumerPerNode,
    /// The CAN-ID of a PDO changes only while bit 31 is set.
    CanIdWhileInvalid,
    /// Mapping entries change only while sub-index 0 is 0 and the PDO is invalid.
    MappingWhileDisabled,
    /// The value is at most that of the object `of`.
    AtMost,
    /// The value is at least that of the object `of`.
    AtLeast,
}

impl Rule {
    /// The abort code of CiA 301 where the sheet names none.
    pub const fn standard_abort(self) -> AbortCode {
        match self {
            Self::UnitsAtMostRange | Self::InsideActiveRange | Self::CanIdWhileInvalid => AbortCode::INVALID_VALUE,
            Self::OneConsumerPerNode => AbortCode::PARAMETER_INCOMPATIBLE,
            Self::MappingWhileDisabled => AbortCode::UNSUPPORTED_ACCESS,
            Self::AtMost | Self::AtLeast => AbortCode::MAXIMUM_BELOW_MINIMUM,
        }
    }
}

/// A set of addresses: `"6001:00"`, `"1016:*"` (every sub-index but 0), `"1800..1802:01"`, `"1A00..1A02:*"`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Addresses {
    first: Index,
    last: Index,
    /// `None`: every one but 0.
    sub: Option<SubIndex>,
}

impl Addresses {
    /// Whether the address is one of them.
    pub fn contains(self, at: Multiplexer) -> bool {
        let in_sub = self.sub.map_or(at.sub.0 != 0, |sub| sub == at.sub);
        (self.first..=self.last).contains(&at.index) && in_sub
    }

    fn parse(text: &str) -> Option<Self> {
        let index = |text| Some(Index(u16::from_str_radix(text, 16).ok()?));
        let (indexes, sub) = text.split_once(':')?;
        let (first, last) = indexes.split_once("..").unwrap_or((indexes, indexes));
        let sub = if sub == "*" { None } else { Some(SubIndex(u8::from_str_radix(sub, 16).ok()?)) };
        Some(Self { first: index(first)?, last: index(last)?, sub })
    }
}

impl<'de> Deserialize<'de> for Addresses {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        Self::parse(&text).ok_or_else(|| {
            de::Error::custom(format!("expected \"6001:00\", \"1016:*\" or \"1800..1802:01\", found \"{text}\""))
        })
    }
}

fn abort_code<'de, D: Deserializer<'de>>(from: D) -> Result<AbortCode, D::Error> {
    u32::deserialize(from).map(AbortCode)
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;

    #[test]
    fn addresses_of_all_forms() {
        let contains = |text, index, sub| Addresses::parse(text).unwrap().contains(Multiplexer::new(index, sub));
        assert!(contains("6001:00", 0x6001, 0) && !contains("6001:00", 0x6001, 1) && !contains("6001:00", 0x6002, 0));
        assert!(
            contains("1016:*", object::CONSUMER_HEARTBEAT_TIME, 127)
                && !contains("1016:*", object::CONSUMER_HEARTBEAT_TIME, 0)
        );
        assert!(contains("1800..1802:01", 0x1802, 1) && !contains("1800..1802:01", 0x1803, 1));
        assert!(contains("1A00..1A02:*", 0x1A01, 8));
        for wrong in ["", "6001", "60010:00", "6001:", "6001:100", "..:00"] {
            assert_eq!(Addresses::parse(wrong), None, "{wrong}");
        }
    }
}
