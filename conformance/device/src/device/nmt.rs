//! The NMT slave: the NMT states, the commands, and the services that each state allows (CiA 301, 7.3.2).

use super::context::Context;
use super::routes::{Route, Routes};
use super::service;
use crate::{Fault, Firmware};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt;
use canvass_analyzer::wire::nmt::{Command, Nmt};
use canvass_traces::{Duration, Frame, Timestamp};

/// An NMT state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Phase {
    /// The device has no node-ID: only LSS works.
    Unconfigured,
    /// Initialisation: no service works until the boot-up message.
    Initialising {
        until: Timestamp,
    },
    PreOperational,
    Operational,
    Stopped,
}

/// A service that an NMT state allows or forbids.
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

/// A request of a service to the device as a whole.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Order {
    Enter(Phase),
    ResetNode,
    ResetCommunication,
    /// Restart with this node-ID, or without one, and with this bit rate of the model's table, if there is one: the
    /// master has ended LSS configuration.
    Restart {
        node: Option<NodeId>,
        bit_timing: Option<u8>,
    },
    /// Use a new node-ID of LMT without a restart.
    MoveTo(NodeId),
    /// Change to this bit rate of the model's table; the device is silent for this time before and after.
    ActivateBitRate {
        bit_timing: Option<u8>,
        delay: Duration,
    },
    /// Hang, in a faulty firmware.
    Hang,
}

impl Phase {
    /// The state as error control messages show it.
    pub const fn state(self) -> State {
        match self {
            Self::Unconfigured | Self::Initialising { .. } => State::BOOT_UP,
            Self::PreOperational => State::PRE_OPERATIONAL,
            Self::Operational => State::OPERATIONAL,
            Self::Stopped => State::STOPPED,
        }
    }

    /// Whether the device processes RPDOs.
    pub(crate) const fn receives_pdos(self, firmware: &Firmware) -> bool {
        match self {
            Self::Operational => true,
            Self::PreOperational => firmware.has(Fault::RpdoInPreOperational),
            Self::Stopped => firmware.has(Fault::RpdoWhenStopped),
            _ => false,
        }
    }

    /// Whether the device obeys NMT commands.
    pub const fn is_running(self) -> bool {
        matches!(self, Self::PreOperational | Self::Operational | Self::Stopped)
    }

    /// Whether the state allows the service, by the table of CiA 301, 7.3.2.2.5.
    pub const fn serves(self, service: Service, firmware: &Firmware) -> bool {
        match (self, service) {
            (_, Service::Lss) => true,
            (Self::Initialising { .. }, Service::Sdo) => firmware.has(Fault::SdoAnsweredBeforeBootUp),
            (Self::Initialising { .. }, Service::Emcy) => firmware.has(Fault::EmcyBeforeBootUp),
            (Self::Unconfigured | Self::Initialising { .. }, _) => false,
            (Self::Operational, Service::Sdo) => !firmware.has(Fault::SdoSilentWhenOperational),
            (_, Service::ErrorControl) | (Self::Operational, _) => true,
            (Self::PreOperational, Service::Pdo) => firmware.has(Fault::TpdoInPreOperational),
            (Self::PreOperational, _) => true,
            (Self::Stopped, Service::Sdo) => firmware.has(Fault::SdoAnsweredWhenStopped),
            (Self::Stopped, Service::Emcy) => firmware.has(Fault::EmcyWhenStopped),
            (Self::Stopped, Service::Pdo) => firmware.has(Fault::TpdoWhenStopped),
            (Self::Stopped, Service::Broadcast) => firmware.has(Fault::SyncWhenStopped),
        }
    }
}

/// The meaning of an NMT message for the node; `None` if it is for other nodes or has no meaning.
fn order(message: Nmt, node: NodeId, phase: Phase, firmware: &Firmware) -> Option<Order> {
    let addressed = match message.node {
        0 => !firmware.has(Fault::NmtBroadcastIgnored),
        id => id == node.raw() || firmware.has(Fault::NmtNodeIdIgnored),
    };
    if !addressed || !phase.is_running() {
        return None;
    }
    let ignores_reset = phase == Phase::Stopped && firmware.has(Fault::NmtResetWhenStoppedIgnored);
    let target = match message.command {
        Command::START => Some(Phase::Operational),
        Command::STOP => Some(Phase::Stopped),
        Command::ENTER_PRE_OPERATIONAL => Some(Phase::PreOperational),
        _ => None,
    };
    if target == Some(phase) && firmware.has(Fault::NmtRepeatedCommandResets) {
        return Some(Order::ResetNode);
    }
    Some(match message.command {
        Command::ENTER_PRE_OPERATIONAL if firmware.has(Fault::NmtEnterPreOperationalIgnored) => return None,
        Command::STOP if phase == Phase::Operational && firmware.has(Fault::NmtStopWhenOperationalIgnored) => {
            return None;
        }
        Command::START if phase == Phase::Stopped && firmware.has(Fault::NmtStartWhenStoppedIgnored) => return None,
        Command::START => Order::Enter(Phase::Operational),
        Command::STOP => Order::Enter(Phase::Stopped),
        Command::ENTER_PRE_OPERATIONAL => Order::Enter(Phase::PreOperational),
        Command::RESET_NODE | Command::RESET_COMMUNICATION if ignores_reset => return None,
        Command::RESET_NODE => Order::ResetNode,
        Command::RESET_COMMUNICATION => Order::ResetCommunication,
        _ if firmware.has(Fault::NmtUnknownCommandStops) => Order::Enter(Phase::Stopped),
        _ => return None,
    })
}

/// Minimum interval between the NMT commands that a firmware with one command buffer obeys.
const ONE_COMMAND: Duration = Duration::from_millis(1);

/// Handles the commands of the NMT master.
#[derive(Clone, Copy, Debug)]
pub(super) struct NmtSlave {
    /// Time of the last command.
    last: Option<Timestamp>,
}

impl NmtSlave {
    /// The state before the first command.
    pub const fn new() -> Self {
        Self { last: None }
    }
}

impl service::Service for NmtSlave {
    fn handle(&mut self, now: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        let Some(node) = context.node else { return };
        // An NMT message has two bytes (CiA 301); the device ignores messages of other lengths.
        let message = match *frame.data() {
            [command] if context.has(Fault::NmtShortFrameObeyed) => Nmt { command: Command(command), node: node.raw() },
            [command, node] => Nmt { command: Command(command), node },
            _ => return,
        };
        let before = self.last.replace(now);
        let too_fast = before.is_some_and(|before| now < before + ONE_COMMAND);
        if too_fast && context.has(Fault::NmtCommandLost) {
            return;
        }
        if message.command == Command::START && context.refuses_operational {
            return;
        }
        if let Some(order) = order(message, node, context.phase, context.firmware()) {
            context.order(order);
        }
    }

    fn find_routes(&self, context: &Context, routes: &mut Routes) {
        if context.node.is_some() {
            routes.set(nmt::CAN_ID, Route::Nmt);
        }
    }
}
