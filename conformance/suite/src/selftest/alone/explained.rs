//! The reviewed list of the verdicts that differ because a defect outlives the reset between two cases.

use crate::{catalogue, glob};
use canvass_device::{Fault, Firmware};
use serde::Deserialize;

/// The differences that a defect of the device explains, with the reasons.
pub(super) struct Explained(Vec<(Vec<Fault>, Group)>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    explained: Vec<Group>,
}

/// Differences with the same reason.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Group {
    /// The faults, each of which explains the differences.
    faults: Vec<String>,
    /// Patterns of the cases whose verdicts differ.
    cases: Vec<String>,
    reason: String,
}

/// The reason why the list can't be used.
#[derive(Debug, thiserror::Error)]
pub enum BadList {
    /// The list can't be read.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// No fault has this name.
    #[error("no fault is called \"{0}\"")]
    Fault(String),
    /// A pattern matches no case.
    #[error("{0}")]
    Case(String),
    /// A difference has no reason.
    #[error("{0}: expected a reason, found none")]
    Reason(String),
}

impl Explained {
    pub fn read() -> Result<Self, BadList> {
        Self::parse(include_str!("explained.toml"))
    }

    fn parse(text: &str) -> Result<Self, BadList> {
        let list: List = toml::from_str(text)?;
        let checked = |group: Group| {
            if group.reason.trim().is_empty() {
                return Err(BadList::Reason(group.faults.join(", ")));
            }
            group.cases.iter().try_for_each(|pattern| catalogue::expect(pattern)).map_err(BadList::Case)?;
            let fault = |name: &String| name.parse().map_err(|_| BadList::Fault(name.clone()));
            Ok((group.faults.iter().map(fault).collect::<Result<_, _>>()?, group))
        };
        list.explained.into_iter().map(checked).collect::<Result<_, _>>().map(Self)
    }

    /// The reason why the verdict of a case differs on this firmware; `None` if none is listed.
    pub fn reason(&self, firmware: Firmware, case: &str) -> Option<&str> {
        let explains = |(faults, group): &&(Vec<Fault>, Group)| {
            faults.iter().any(|fault| firmware.has(*fault))
                && group.cases.iter().any(|pattern| glob::matches(pattern, case))
        };
        self.0.iter().find(explains).map(|(_, group)| group.reason.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_list_must_not_have() {
        let error = |fields: &str| {
            let text = format!("[[explained]]\n{fields}\n");
            Explained::parse(&text).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(error("faults = [\"loud\"]\ncases = [\"*\"]\nreason = \"r\"").contains("no fault is called \"loud\""));
        assert!(error("faults = [\"boot-up-missing\"]\ncases = [\"x/*\"]\nreason = \"r\"").contains("x/*"));
        let nameless = error("faults = [\"boot-up-missing\"]\ncases = [\"*\"]\nreason = \" \"");
        assert!(nameless.contains("boot-up-missing: expected a reason"), "{nameless}");
    }

    #[test]
    fn a_reason_is_that_of_its_fault_and_its_cases() {
        let text = "[[explained]]\nfaults = [\"boot-up-missing\"]\ncases = [\"301/boot-up/*\"]\nreason = \"r\"\n";
        let list = Explained::parse(text).unwrap();
        let reason = |fault: Fault, case| list.reason(fault.into(), case);
        assert_eq!(reason(Fault::BootUpMissing, "301/boot-up/reset-node"), Some("r"));
        assert_eq!(reason(Fault::BootUpMissing, "301/sdo/upload/no-object"), None);
        assert_eq!(reason(Fault::BootUpTwice, "301/boot-up/reset-node"), None);
    }
}
