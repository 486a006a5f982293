//! The states of a drive by its statusword, the commands by its controlword, and the modes of operation.
//!
//! Source: the tables of state coding and of commands in the manuals of drives (Faulhaber MC 5010, Novanta), and
//! `cia402.h` of Synapticon, whose masks are the same.

use std::fmt;

/// A state of the drive's state machine.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum State {
    /// The drive initialises itself.
    NotReadyToSwitchOn,
    /// No voltage may be applied.
    SwitchOnDisabled,
    /// Voltage may be applied.
    ReadyToSwitchOn,
    /// Voltage is applied, without a function.
    SwitchedOn,
    /// The drive follows its set-points.
    OperationEnabled,
    /// The quick stop function is active.
    QuickStopActive,
    /// A fault has occurred, and the drive reacts to it.
    FaultReactionActive,
    /// The drive is off because of a fault, until a reset.
    Fault,
}

impl State {
    /// The state in a statusword: bits 0 to 3, 5 and 6; `None` for a combination that no state has.
    pub const fn of(statusword: u16) -> Option<Self> {
        match (statusword & 0x4F, statusword & 0x6F) {
            (0x00, _) => Some(Self::NotReadyToSwitchOn),
            (0x40, _) => Some(Self::SwitchOnDisabled),
            (0x0F, _) => Some(Self::FaultReactionActive),
            (0x08, _) => Some(Self::Fault),
            (_, 0x21) => Some(Self::ReadyToSwitchOn),
            (_, 0x23) => Some(Self::SwitchedOn),
            (_, 0x27) => Some(Self::OperationEnabled),
            (_, 0x07) => Some(Self::QuickStopActive),
            _ => None,
        }
    }

    /// Whether the drive has a fault, or reacts to one.
    pub const fn is_fault(self) -> bool {
        matches!(self, Self::FaultReactionActive | Self::Fault)
    }

    /// The usual name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotReadyToSwitchOn => "not ready to switch on",
            Self::SwitchOnDisabled => "switch on disabled",
            Self::ReadyToSwitchOn => "ready to switch on",
            Self::SwitchedOn => "switched on",
            Self::OperationEnabled => "operation enabled",
            Self::QuickStopActive => "quick stop active",
            Self::FaultReactionActive => "fault reaction active",
            Self::Fault => "fault",
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A command in a controlword.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Command {
    /// Switch the voltage off.
    DisableVoltage,
    /// Stop by the quick stop function.
    QuickStop,
    /// Go to ready to switch on.
    Shutdown,
    /// Go to switched on; from operation enabled too.
    SwitchOn,
    /// Go to operation enabled.
    EnableOperation,
    /// Acknowledge a fault. Only the rising edge of the bit counts.
    FaultReset,
}

impl Command {
    /// The command in a controlword: bits 0 to 3 and 7. The quick stop bit is active if it is 0.
    pub const fn of(controlword: u16) -> Self {
        match controlword & 0x8F {
            0x80.. => Self::FaultReset,
            bits if bits & 0x02 == 0 => Self::DisableVoltage,
            bits if bits & 0x04 == 0 => Self::QuickStop,
            bits if bits & 0x01 == 0 => Self::Shutdown,
            bits if bits & 0x08 == 0 => Self::SwitchOn,
            _ => Self::EnableOperation,
        }
    }

    /// The usual name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DisableVoltage => "disable voltage",
            Self::QuickStop => "quick stop",
            Self::Shutdown => "shutdown",
            Self::SwitchOn => "switch on",
            Self::EnableOperation => "enable operation",
            Self::FaultReset => "fault reset",
        }
    }
}

/// The name of a mode of operation; modes of manufacturers, which are negative, have none.
pub const fn mode(mode: i8) -> Option<&'static str> {
    Some(match mode {
        0 => "no mode",
        1 => "profile position",
        2 => "velocity",
        3 => "profile velocity",
        4 => "profile torque",
        6 => "homing",
        7 => "interpolated position",
        8 => "cyclic synchronous position",
        9 => "cyclic synchronous velocity",
        10 => "cyclic synchronous torque",
        11 => "cyclic synchronous torque with commutation angle",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Statuswords of drives in operation, with bits beside the state.
    #[test]
    fn the_state_is_in_the_statusword() {
        let state = |word| State::of(word).map(State::name);
        assert_eq!(state(0x0237), Some("operation enabled"));
        assert_eq!(state(0x1637), Some("operation enabled"));
        assert_eq!(state(0x0218), Some("fault"));
        assert_eq!(state(0x0638), Some("fault"));
        assert_eq!(state(0x0250), Some("switch on disabled"));
        assert_eq!(state(0x0270), Some("switch on disabled"));
        assert_eq!(state(0x0231), Some("ready to switch on"));
        assert_eq!(state(0x0233), Some("switched on"));
        assert_eq!(state(0x0217), Some("quick stop active"));
        assert_eq!(state(0x021F), Some("fault reaction active"));
        assert_eq!(state(0x0000), Some("not ready to switch on"));
        assert_eq!(state(0x0277), None);
    }

    #[test]
    fn the_command_is_in_the_controlword() {
        let names =
            [0x0000, 0x0002, 0x0006, 0x0007, 0x000F, 0x001F, 0x0080, 0x010F].map(|word| Command::of(word).name());
        let expected = [
            "disable voltage",
            "quick stop",
            "shutdown",
            "switch on",
            "enable operation",
            "enable operation",
            "fault reset",
            "enable operation",
        ];
        assert_eq!(names, expected);
    }
}
