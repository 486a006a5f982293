//! The transitions of the NMT state machine: each command in each state (CiA 301, 7.2.8.2.1.2 to 7.2.8.2.1.6).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::{Observation, Subject};

/// Brings the device into `from`, sends the command and requires that the device is then in `to`.
fn transition(bench: &mut Bench<'_>, from: State, command: Command, to: State) -> Judged {
    bench.reach(from)?;
    bench.command(command)?;
    bench.expect_state(to, &format!("{command} in {from}"))
}

/// Brings the device into `from`, resets it and requires a boot-up and then pre-operational; or operational, if the
/// device starts by itself, which is allowed ("by local control").
fn reset(bench: &mut Bench<'_>, from: State, command: Command) -> Judged {
    bench.reach(from)?;
    bench.command(command)?;
    let boot_up = bench.wait_for_boot_up()?;
    let timing = bench.timing();
    demand(boot_up.is_some(), || {
        let duty = format!("the device restarts within {} of {command} in {from}", timing.boot_up);
        Breach::new(Service::BootUp, duty).expected(Observation::BootUp).found(Observation::Silence)
    })?;
    bench.show_state()?;
    bench.listen(timing.reaction)?;
    let found = bench.state()?;
    let mut allowed = vec![Observation::State(State::PRE_OPERATIONAL)];
    if bench.starts_by_itself()? {
        allowed.push(Observation::State(State::OPERATIONAL));
    }
    let found = found.map_or(Observation::Silence, Observation::State);
    bench.check(demand(allowed.contains(&found), || {
        let duty = format!("the device is in its initial state after {command} in {from}");
        Breach::new(Subject::Device, duty).expected(Allowed::OneOf(allowed)).found(found)
    }))
}

/// Start remote node in pre-operational: the device becomes operational.
#[case(id = "301/nmt/pre-operational/start", clause = "CiA 301 7.2.8.2.1.2", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [HeartbeatWrongState, NmtStartRefusedInError], cct = "10.1")]
fn pre_operational_start(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::PRE_OPERATIONAL, Command::START, State::OPERATIONAL)
}

/// Stop remote node in pre-operational: the device becomes stopped.
#[case(id = "301/nmt/pre-operational/stop", clause = "CiA 301 7.2.8.2.1.3", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [HeartbeatWrongState], cct = "10.2")]
fn pre_operational_stop(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::PRE_OPERATIONAL, Command::STOP, State::STOPPED)
}

/// Enter pre-operational in pre-operational: the device stays pre-operational and does not restart.
#[case(id = "301/nmt/pre-operational/enter-pre-operational", clause = "CiA 301 7.2.8.2.1.4", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtRepeatedCommandResets], cct = "10.3")]
fn pre_operational_enter_pre_operational(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::PRE_OPERATIONAL, Command::ENTER_PRE_OPERATIONAL, State::PRE_OPERATIONAL)
}

/// Reset node in pre-operational: the device sends its boot-up message and is pre-operational.
#[case(id = "301/nmt/pre-operational/reset-node", clause = "CiA 301 7.2.8.2.1.5", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [BootUpMissing], cct = "10.4")]
fn pre_operational_reset_node(bench: &mut Bench<'_>) -> Judged {
    reset(bench, State::PRE_OPERATIONAL, Command::RESET_NODE)
}

/// Reset communication in pre-operational: the device sends its boot-up message and is pre-operational.
#[case(id = "301/nmt/pre-operational/reset-communication", clause = "CiA 301 7.2.8.2.1.6", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [BootUpMissing], cct = "10.4")]
fn pre_operational_reset_communication(bench: &mut Bench<'_>) -> Judged {
    reset(bench, State::PRE_OPERATIONAL, Command::RESET_COMMUNICATION)
}

/// Start remote node in operational: the device stays operational and does not restart.
#[case(id = "301/nmt/operational/start", clause = "CiA 301 7.2.8.2.1.2", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtRepeatedCommandResets], cct = "10.1")]
fn operational_start(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::OPERATIONAL, Command::START, State::OPERATIONAL)
}

/// Stop remote node in operational: the device becomes stopped.
#[case(id = "301/nmt/operational/stop", clause = "CiA 301 7.2.8.2.1.3", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtStopWhenOperationalIgnored], cct = "10.2")]
fn operational_stop(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::OPERATIONAL, Command::STOP, State::STOPPED)
}

/// Enter pre-operational in operational: the device becomes pre-operational.
#[case(id = "301/nmt/operational/enter-pre-operational", clause = "CiA 301 7.2.8.2.1.4", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtEnterPreOperationalIgnored], cct = "10.3")]
fn operational_enter_pre_operational(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::OPERATIONAL, Command::ENTER_PRE_OPERATIONAL, State::PRE_OPERATIONAL)
}

/// Reset node in operational: the device sends its boot-up message and is pre-operational.
#[case(id = "301/nmt/operational/reset-node", clause = "CiA 301 7.2.8.2.1.5", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [BootUpMissing], cct = "10.4")]
fn operational_reset_node(bench: &mut Bench<'_>) -> Judged {
    reset(bench, State::OPERATIONAL, Command::RESET_NODE)
}

/// Reset communication in operational: the device sends its boot-up message and is pre-operational.
#[case(id = "301/nmt/operational/reset-communication", clause = "CiA 301 7.2.8.2.1.6", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [BootUpMissing], cct = "10.4")]
fn operational_reset_communication(bench: &mut Bench<'_>) -> Judged {
    reset(bench, State::OPERATIONAL, Command::RESET_COMMUNICATION)
}

/// Start remote node in stopped: the device becomes operational.
#[case(id = "301/nmt/stopped/start", clause = "CiA 301 7.2.8.2.1.2", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtStartWhenStoppedIgnored], cct = "10.1")]
fn stopped_start(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::STOPPED, Command::START, State::OPERATIONAL)
}

/// Stop remote node in stopped: the device stays stopped and does not restart.
#[case(id = "301/nmt/stopped/stop", clause = "CiA 301 7.2.8.2.1.3", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtRepeatedCommandResets], cct = "10.2")]
fn stopped_stop(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::STOPPED, Command::STOP, State::STOPPED)
}

/// Enter pre-operational in stopped: the device becomes pre-operational.
#[case(id = "301/nmt/stopped/enter-pre-operational", clause = "CiA 301 7.2.8.2.1.4", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtEnterPreOperationalIgnored], cct = "10.3")]
fn stopped_enter_pre_operational(bench: &mut Bench<'_>) -> Judged {
    transition(bench, State::STOPPED, Command::ENTER_PRE_OPERATIONAL, State::PRE_OPERATIONAL)
}

/// Reset node in stopped: the device sends its boot-up message and is pre-operational.
#[case(id = "301/nmt/stopped/reset-node", clause = "CiA 301 7.2.8.2.1.5", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [BootUpMissing, NmtResetWhenStoppedIgnored, ResetWhenStoppedHangs], cct = "10.4")]
fn stopped_reset_node(bench: &mut Bench<'_>) -> Judged {
    reset(bench, State::STOPPED, Command::RESET_NODE)
}

/// Reset communication in stopped: the device sends its boot-up message and is pre-operational.
#[case(id = "301/nmt/stopped/reset-communication", clause = "CiA 301 7.2.8.2.1.6", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [BootUpMissing, NmtResetWhenStoppedIgnored, ResetWhenStoppedHangs],
       cct = "10.4")]
fn stopped_reset_communication(bench: &mut Bench<'_>) -> Judged {
    reset(bench, State::STOPPED, Command::RESET_COMMUNICATION)
}
