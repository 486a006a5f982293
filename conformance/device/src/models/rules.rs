//! The rows `[[link]]` and `[[check]]` of a sheet: objects that hold the same value, and values that an object refuses.

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
    /// The place in the manual: for readers of the file; the program does not use it.
    #[serde(default)]
    pub source: ForPeople,
}

/// How the values of linked objects depend on each other.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LinkKind {
    /// All objects hold the same value: a write to one object is a write to all.
    Same,
    /// The first object always shows the value of the second.
    Follows,
}

/// A rule for written values in addition to the limits of the object, and the abort code of a breach.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// The objects for which the rule holds.
    pub at: Addresses,
    pub rule: Rule,
    /// The object with which the rule compares the value, if the rule compares.
    #[serde(default, deserialize_with = "super::sheet::address_option")]
    pub of: Option<Multiplexer>,
    /// The SDO abort code of a breach.
    #[serde(deserialize_with = "abort_code")]
    pub abort: AbortCode,
    /// The values of this row that the manual does not give: for readers of the file.
    #[serde(default)]
    pub assumed: ForPeople,
    /// The place in the manual: for readers of the file; the program does not use it.
    #[serde(default)]
    pub source: ForPeople,
}

/// The rules that a sheet can name. The rules of CiA 301 hold for every device; a row in a sheet sets the abort code of
/// its device.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// 6001h is at most 6002h.
    UnitsAtMostRange,
    /// The value is a position that the device can show.
    InsideActiveRange,
    /// Each node-ID is in one entry of 1016h only; an entry is erased before it gets another node-ID.
    OneConsumerPerNode,
    /// The CAN-ID of a PDO changes only while bit 31 of its COB-ID is set.
    CanIdWhileInvalid,
    /// Mapping entries change only while sub-index 0 is 0 and the PDO is not valid.
    MappingWhileDisabled,
    /// The value is at most the value of the object `of`.
    AtMost,
    /// The value is at least the value of the object `of`.
    AtLeast,
}

impl Rule {
    /// The abort code of CiA 301, for sheets that name none.
    pub(crate) const fn standard_abort(self) -> AbortCode {
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
    /// The sub-index; `None`: every sub-index except 0.
    sub: Option<SubIndex>,
}

impl Addresses {
    /// Whether the set contains the address.
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
