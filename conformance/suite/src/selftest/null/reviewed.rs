//! The reviewed list of the passes on null devices.

use super::NullDevice;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The cases that pass on each null device, with the reasons why that is right.
pub(super) struct Reviewed(BTreeMap<String, Vec<Passes>>);

/// Cases that pass for the same reason.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Passes {
    reason: String,
    cases: Vec<String>,
}

/// The reason why the list can't be used.
#[derive(Debug, thiserror::Error)]
pub enum BadList {
    /// The list can't be read.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A section is named after no null device.
    #[error("no null device is called \"{0}\"")]
    Device(String),
    /// A case is listed twice in a section.
    #[error("{device}: \"{case}\" is listed twice")]
    Twice {
        /// The section.
        device: String,
        /// The case.
        case: String,
    },
    /// Passes have no reason.
    #[error("{0}: expected a reason, found none")]
    Reason(String),
}

impl Reviewed {
    pub fn read() -> Result<Self, BadList> {
        Self::parse(include_str!("passes.toml"))
    }

    fn parse(text: &str) -> Result<Self, BadList> {
        let list: BTreeMap<String, Vec<Passes>> = toml::from_str(text)?;
        for (device, groups) in &list {
            if !NullDevice::ALL.iter().any(|known| known.id() == device) {
                return Err(BadList::Device(device.clone()));
            }
            if groups.iter().any(|group| group.reason.trim().is_empty()) {
                return Err(BadList::Reason(device.clone()));
            }
            let mut ids: Vec<&String> = groups.iter().flat_map(|group| &group.cases).collect();
            ids.sort_unstable();
            if let Some(twice) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
                return Err(BadList::Twice { device: device.clone(), case: twice[0].clone() });
            }
        }
        Ok(Self(list))
    }

    /// The reason why it is right that the case passes on this null device.
    pub fn reason(&self, device: NullDevice, case: &str) -> Option<&str> {
        let groups = self.0.get(device.id())?;
        let group = groups.iter().find(|group| group.cases.iter().any(|id| id == case))?;
        Some(&group.reason)
    }

    /// The cases that pass on this null device.
    pub fn of(&self, device: NullDevice) -> impl Iterator<Item = &str> {
        self.0.get(device.id()).into_iter().flatten().flat_map(|group| &group.cases).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_list_must_not_have() {
        let error = |text| Reviewed::parse(text).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error("[[loud]]\nreason = \"r\"\ncases = []\n").contains("loud"));
        assert!(error("[[echo]]\nreason = \" \"\ncases = []\n").contains("expected a reason"));
        assert!(error("[[echo]]\nreason = \"r\"\ncases = [\"a\", \"b\", \"a\"]\n").contains("\"a\" is listed twice"));
        assert!(error("[[echo]]\nreason = \"r\"\nids = [\"a\"]\n").contains("ids"));
    }

    #[test]
    fn a_reason_is_that_of_its_device() {
        let list = Reviewed::parse("[[echo]]\nreason = \"r\"\ncases = [\"a\"]\n").unwrap();
        assert_eq!(list.reason(NullDevice::Echo, "a"), Some("r"));
        assert_eq!(list.reason(NullDevice::Silent, "a"), None);
        assert_eq!(list.of(NullDevice::Echo).collect::<Vec<_>>(), ["a"]);
    }
}
