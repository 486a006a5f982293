//! The behaviour of a device after a start, as far as no object shows it: its EMCYs, its state and its PDOs. A run
//! compares this behaviour before and after its cases.

use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::error_control::State;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Minimum number of frames of a PDO in one observation that proves that the PDO has stopped or begun, if the other
/// observation has none. Fewer frames may come from a value that changed.
const CERTAIN: u32 = 3;

/// The behaviour of a device after a start, and after the following command to become operational.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(crate) struct Behaviour {
    /// The errors that the device reported while it started.
    pub emergencies: BTreeSet<EmcyCode>,
    /// The state that the device entered by itself; `None` if it showed no state.
    pub state: Option<State>,
    /// Number of frames of each PDO while the device was operational.
    pub pdos: BTreeMap<u16, u32>,
}

/// A difference in the behaviour of the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Changed {
    /// The device reports this error as it starts.
    Emergency(EmcyCode),
    /// The device enters another state by itself.
    State {
        /// The state before the run.
        before: State,
        /// The state after the run.
        after: State,
    },
    /// The device no longer sends a PDO that it sent in operational.
    PdoStopped(u16),
    /// The device sends a PDO in operational that it did not send before.
    PdoBegan(u16),
}

impl Behaviour {
    /// The differences between this behaviour and the one after the run.
    pub fn changed(&self, after: &Self) -> Vec<Changed> {
        let new = after.emergencies.difference(&self.emergencies).filter(|code| !code.is_reset());
        let emergencies = new.map(|code| Changed::Emergency(*code));
        let states = self.state.zip(after.state).filter(|(before, after)| before != after);
        let states = states.map(|(before, after)| Changed::State { before, after });
        let gone = |one: &Self, other: &Self| {
            let certain = one.pdos.iter().filter(|(_, count)| **count >= CERTAIN);
            certain.map(|(pdo, _)| *pdo).filter(|pdo| !other.pdos.contains_key(pdo)).collect::<Vec<u16>>()
        };
        let stopped = gone(self, after).into_iter().map(Changed::PdoStopped);
        let began = gone(after, self).into_iter().map(Changed::PdoBegan);
        emergencies.chain(states).chain(stopped).chain(began).collect()
    }
}

impl fmt::Display for Changed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Emergency(code) => {
                write!(f, "after a start the device reports EMCY {code}, which it did not report before the run")
            }
            Self::State { before, after } => {
                write!(f, "after a start the device is {after}, and was {before} before the run")
            }
            Self::PdoStopped(pdo) => {
                write!(f, "in operational the device no longer sends the PDO {pdo:03X}h, which it sent before the run")
            }
            Self::PdoBegan(pdo) => {
                write!(f, "in operational the device sends the PDO {pdo:03X}h, which it did not send before the run")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn behaviour(emergencies: &[u16], state: Option<State>, pdos: &[(u16, u32)]) -> Behaviour {
        Behaviour {
            emergencies: emergencies.iter().map(|code| EmcyCode(*code)).collect(),
            state,
            pdos: pdos.iter().copied().collect(),
        }
    }

    #[test]
    fn what_a_device_does_otherwise_is_told() {
        let before = behaviour(&[0x8100], Some(State::PRE_OPERATIONAL), &[(0x181, 9), (0x281, 1)]);
        let after = behaviour(&[0x8100, 0x5000, 0], Some(State::OPERATIONAL), &[(0x381, 3), (0x481, 2)]);
        let told: Vec<String> = before.changed(&after).iter().map(ToString::to_string).collect();
        assert_eq!(told.len(), 4, "{told:?}");
        assert!(told[0].starts_with("after a start the device reports EMCY 5000h"), "{told:?}");
        assert_eq!(told[1], "after a start the device is operational, and was pre-operational before the run");
        assert!(
            told[2].contains("no longer sends the PDO 181h")
                && told[3].contains("sends the PDO 381h, which it did not"),
            "{told:?}"
        );
    }

    /// An error that is gone, a state that the device no longer shows, and a PDO with fewer than [`CERTAIN`] frames are
    /// no change.
    #[test]
    fn what_only_did_not_show_is_no_change() {
        let before = behaviour(&[0x8100], None, &[(0x181, 2)]);
        let after = behaviour(&[], Some(State::OPERATIONAL), &[]);
        assert_eq!(before.changed(&after), []);
        assert_eq!(after.changed(&before).len(), 1, "that one is new");
        assert_eq!(before.changed(&before), []);
    }
}
