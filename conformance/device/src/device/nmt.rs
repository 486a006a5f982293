//! The NMT slave: states, commands, and which service works in which state (CiA 301, 7.3.2).

use crate::{Fault, Faults};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::{Command, Nmt};
use canvass_traces::Timestamp;

/// An NMT state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Phase {
    /// Without a node-ID: only LSS works.
    Unconfigured,
    /// Initialisation: nothing works until the boot-up message.
    Initialising {
        until: Timestamp,
    },
    PreOperational,
    Operational,
    Stopped,
}

/// What a state allows or not.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Service {
    Sdo,
    Pdo,
    Emcy,
    ErrorControl,
    Lss,
    /// SYNC and TIME.
    Broadcast,
}

/// What a command makes the device do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Order {
    Enter(Phase),
    ResetNode,
    ResetCommunication,
}

impl Phase {
    /// As error control messages say it.
    pub const fn state(self) -> State {
        match self {
            Self::Unconfigured | Self::Initialising { .. } => State::BOOT_UP,
            Self::PreOperational => State::PRE_OPERATIONAL,
            Self::Operational => State::OPERATIONAL,
            Self::Stopped => State::STOPPED,
        }
    }

    /// Whether RPDOs act.
    pub const fn receives_pdos(self, faults: Faults) -> bool {
        match self {
            Self::Operational => true,
            Self::PreOperational => faults.has(Fault::RpdoInPreOperational),
            Self::Stopped => faults.has(Fault::RpdoWhenStopped),
            _ => false,
        }
    }

    /// Whether NMT commands are obeyed.
    pub const fn is_running(self) -> bool {
        matches!(self, Self::PreOperational | Self::Operational | Self::Stopped)
    }

    /// The table of CiA 301, 7.3.2.2.5.
    pub const fn serves(self, service: Service, faults: Faults) -> bool {
        match (self, service) {
            (_, Service::Lss) => true,
            (Self::Initialising { .. }, Service::Sdo) => faults.has(Fault::SdoAnsweredBeforeBootUp),
            (Self::Initialising { .. }, Service::Emcy) => faults.has(Fault::EmcyBeforeBootUp),
            (Self::Unconfigured | Self::Initialising { .. }, _) => false,
            (Self::Operational, Service::Sdo) => !faults.has(Fault::SdoSilentWhenOperational),
            (_, Service::ErrorControl) | (Self::Operational, _) => true,
            (Self::PreOperational, Service::Pdo) => faults.has(Fault::TpdoInPreOperational),
            (Self::PreOperational, _) => true,
            (Self::Stopped, Service::Sdo) => faults.has(Fault::SdoAnsweredWhenStopped),
            (Self::Stopped, Service::Emcy) => faults.has(Fault::EmcyWhenStopped),
            (Self::Stopped, Service::Pdo) => faults.has(Fault::TpdoWhenStopped),
            (Self::Stopped, Service::Broadcast) => faults.has(Fault::SyncWhenStopped),
        }
    }
}

/// What an NMT message means to the node; `None` if it is for others or has no meaning.
pub(super) fn order(message: Nmt, node: NodeId, phase: Phase, faults: Faults) -> Option<Order> {
    let addressed = match message.node {
        0 => !faults.has(Fault::NmtBroadcastIgnored),
        id => id == node.raw() || faults.has(Fault::NmtNodeIdIgnored),
    };
    if !addressed || !phase.is_running() {
        return None;
    }
    let ignores_reset = phase == Phase::Stopped && faults.has(Fault::NmtResetWhenStoppedIgnored);
    let target = match message.command {
        Command::START => Some(Phase::Operational),
        Command::STOP => Some(Phase::Stopped),
        Command::ENTER_PRE_OPERATIONAL => Some(Phase::PreOperational),
        _ => None,
    };
    if target == Some(phase) && faults.has(Fault::NmtRepeatedCommandResets) {
        return Some(Order::ResetNode);
    }
    Some(match message.command {
        Command::ENTER_PRE_OPERATIONAL if faults.has(Fault::NmtEnterPreOperationalIgnored) => return None,
        Command::STOP if phase == Phase::Operational && faults.has(Fault::NmtStopWhenOperationalIgnored) => {
            return None;
        }
        Command::START if phase == Phase::Stopped && faults.has(Fault::NmtStartWhenStoppedIgnored) => return None,
        Command::START => Order::Enter(Phase::Operational),
        Command::STOP => Order::Enter(Phase::Stopped),
        Command::ENTER_PRE_OPERATIONAL => Order::Enter(Phase::PreOperational),
        Command::RESET_NODE | Command::RESET_COMMUNICATION if ignores_reset => return None,
        Command::RESET_NODE => Order::ResetNode,
        Command::RESET_COMMUNICATION => Order::ResetCommunication,
        _ if faults.has(Fault::NmtUnknownCommandStops) => Order::Enter(Phase::Stopped),
        _ => return None,
    })
}
