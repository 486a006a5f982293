//! Objects that act when they are written. Writing the former value does not undo the action, so no tool restores
//! them, downloads them as a configuration, or tells its user to write them.

use crate::identity::Multiplexer;

/// The action that a device carries out when an object is written.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Acting {
    /// Clears a history or a counter: 1003h (CiA 301, 7.5.2.3).
    Clears,
    /// Takes a signature, and stores or restores parameters: 1010h, 1011h (CiA 301, 7.5.2.13, 7.5.2.14).
    Stores,
    /// Sets a running clock: 1013h (CiA 301, 7.5.2.16).
    SetsClock,
    /// Carries out a command: an operating system command, a program download, an NMT request to other nodes.
    Commands,
    /// Moves the zero point of a position or an angle.
    MovesZeroPoint,
}

impl Acting {
    /// The action of an object of the communication profile (CiA 301, 7.5.2; CiA 302).
    pub(crate) const fn of_communication(at: Multiplexer) -> Option<Self> {
        Some(match at.index.0 {
            super::PREDEFINED_ERROR_FIELD => Self::Clears,
            super::STORE_PARAMETERS | super::RESTORE_DEFAULT_PARAMETERS => Self::Stores,
            super::HIGH_RESOLUTION_TIME_STAMP => Self::SetsClock,
            super::OS_COMMAND..=super::OS_PROMPT
            | super::CONFIGURE_SLAVE
            | super::PROGRAM_DATA..=super::PROGRAM_CONTROL
            | super::REQUEST_NMT..=super::REQUEST_GUARDING => Self::Commands,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One object of each kind, and the objects next to them, which are settings.
    #[test]
    fn what_acts_is_no_setting() {
        let of = |index| Acting::of_communication(Multiplexer::new(index, 1));
        let acting = [0x1003, 0x1010, 0x1011, 0x1013, 0x1023, 0x1F25, 0x1F50, 0x1F51, 0x1F82, 0x1F83];
        assert!(acting.into_iter().all(|index| of(index).is_some()));
        let settings = [0x1002, 0x1005, 0x1012, 0x1014, 0x1017, 0x1020, 0x1029, 0x1600, 0x1F22, 0x1F80, 0x1F81, 0x1F84];
        assert!(settings.into_iter().all(|index| of(index).is_none()));
    }
}
