//! Actions of a case that the user must allow first.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// An action on a device or a bus that the user must allow.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Touch {
    /// Writes non-volatile memory, which wears out.
    Nvm,
    /// Changes the node-ID.
    NodeId,
    /// Changes the bit rate.
    BitRate,
    /// Commands other nodes than the device under test.
    OtherNodes,
    /// Restores the factory defaults: the user's configuration is lost.
    FactoryDefaults,
    /// Moves the zero point of a position or an angle, and puts it back at rest.
    Preset,
    /// Tests a device that others use at the same time.
    OtherClients,
}

impl Touch {
    /// All actions.
    pub const ALL: [Self; 7] = [
        Self::Nvm,
        Self::NodeId,
        Self::BitRate,
        Self::OtherNodes,
        Self::FactoryDefaults,
        Self::Preset,
        Self::OtherClients,
    ];

    /// The name by which the user allows the action.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nvm => "nvm",
            Self::NodeId => "node-id",
            Self::BitRate => "bit-rate",
            Self::OtherNodes => "other-nodes",
            Self::FactoryDefaults => "factory-defaults",
            Self::Preset => "preset",
            Self::OtherClients => "other-clients",
        }
    }

    /// Whether the device may become unreachable, or lose the user's configuration, if the case goes wrong.
    pub(crate) const fn can_lose_the_device(self) -> bool {
        matches!(self, Self::NodeId | Self::BitRate | Self::FactoryDefaults)
    }

    /// Whether the tester itself carries out the action; otherwise others do.
    pub const fn is_by_the_tester(self) -> bool {
        !matches!(self, Self::OtherClients)
    }

    /// The action in words.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Nvm => "writes non-volatile memory",
            Self::NodeId => "changes the node-ID",
            Self::BitRate => "changes the bit rate",
            Self::OtherNodes => "commands other nodes",
            Self::FactoryDefaults => "restores the factory defaults",
            Self::Preset => "moves the zero point",
            Self::OtherClients => "tests a device that others use meanwhile",
        }
    }
}

impl fmt::Display for Touch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The error for a name that no action has.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "nothing to allow is called \"{0}\": there are nvm, node-id, bit-rate, other-nodes, factory-defaults, preset and \
     other-clients"
)]
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
    fn names_to_allow_are_found() {
        for touch in Touch::ALL {
            assert_eq!(touch.name().parse(), Ok(touch));
        }
        assert!("everything".parse::<Touch>().is_err());
    }
}
