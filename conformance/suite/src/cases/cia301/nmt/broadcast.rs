//! Commands to node-ID 0 concern all nodes (CiA 301, 7.2.8.3.1.1 to 7.2.8.3.1.5).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;

fn transition(bench: &mut Bench<'_>, from: State, command: Command, to: State) -> Judged {
    bench.reach(from)?;
    bench.command_all(command)?;
    bench.expect_state(to, &format!("{command} to all nodes"))
}

fn reset(bench: &mut Bench<'_>, command: Command) -> Judged {
    bench.drain()?;
    bench.command_all(command)?;
    let boot_up = bench.wait_for_boot_up()?;
    let timing = bench.timing();
    bench.check(demand(boot_up.is_some(), || {
        let duty = format!("{command} to all nodes resets the device within {}", timing.boot_up);
        Breach::new(Service::BootUp, duty).expected(Observation::BootUp).found(Observation::Silence)
    }))
}

/// The device executes start remote node to node-ID 0 like the same command to its own node-ID.
#[case(id = "301/nmt/broadcast/start", clause = "CiA 301 7.2.8.3.1.1", confidence = Cited, level = Must,
       needs = [Alone, VisibleState], catches = [NmtBroadcastIgnored])]
fn start(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::PRE_OPERATIONAL, Command::START, State::OPERATIONAL)
}

/// The device executes stop remote node to node-ID 0 like the same command to its own node-ID.
#[case(id = "301/nmt/broadcast/stop", clause = "CiA 301 7.2.8.3.1.2", confidence = Cited, level = Must,
       needs = [Alone, VisibleState], catches = [NmtBroadcastIgnored])]
fn stop(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::OPERATIONAL, Command::STOP, State::STOPPED)
}

/// The device executes enter pre-operational to node-ID 0 like the same command to its own node-ID.
#[case(id = "301/nmt/broadcast/enter-pre-operational", clause = "CiA 301 7.2.8.3.1.3", confidence = Cited, level = Must,
       needs = [Alone, VisibleState], catches = [NmtBroadcastIgnored])]
fn enter_pre_operational(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::OPERATIONAL, Command::ENTER_PRE_OPERATIONAL, State::PRE_OPERATIONAL)
}

/// Reset node to node-ID 0 resets the device like the same command to its own node-ID.
#[case(id = "301/nmt/broadcast/reset-node", clause = "CiA 301 7.2.8.3.1.4", confidence = Cited, level = Must,
       needs = [Alone], catches = [NmtBroadcastIgnored])]
fn reset_node(bench: &mut Bench<'_>) -> Judged {
    reset(bench, Command::RESET_NODE)
}

/// Reset communication to node-ID 0 resets the device like the same command to its own node-ID.
#[case(id = "301/nmt/broadcast/reset-communication", clause = "CiA 301 7.2.8.3.1.5", confidence = Cited, level = Must,
       needs = [Alone], catches = [NmtBroadcastIgnored])]
fn reset_communication(bench: &mut Bench<'_>) -> Judged {
    reset(bench, Command::RESET_COMMUNICATION)
}
