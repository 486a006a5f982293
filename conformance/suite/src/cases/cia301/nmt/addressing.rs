//! Commands that do not concern the device (CiA 301, 7.2.8.3.1.1).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::{self, Command};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{CanId, Duration, Frame};

/// Requires that the device is still operational and sent no boot-up.
fn undisturbed(bench: &mut Bench<'_>, by: &str) -> Judged {
    let heard = bench.listen(bench.silence())?;
    let restarts = heard.iter().any(|record| bench.is_boot_up(&record.frame));
    demand(!restarts, || {
        let breach = Breach::new(Subject::Device, format!("the device ignores {by}"));
        breach.expected("no boot-up message").found(Observation::BootUp)
    })?;
    bench.expect_state(State::OPERATIONAL, by)
}

/// NMT commands to another node-ID do not affect the device: its NMT state stays the same, and it does not restart.
///
/// The case uses the node-ID next to that of the device, unless a node was heard there.
#[case(id = "301/nmt/other-node", clause = "CiA 301 7.2.8.3.1.1", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtNodeIdIgnored])]
fn other_node(bench: &mut Bench<'_>) -> Judged {
    bench.look_for_others()?;
    let Some(other) = bench.vacant_neighbour() else {
        let reason = Reason::new("a neighbouring node-ID is free", "no node", "nodes on both sides");
        return Err(Stop::NotApplicable(reason));
    };
    bench.each(Command::ALL, |bench, command| {
        bench.reach(State::OPERATIONAL)?;
        bench.command_to(other, command)?;
        undisturbed(bench, &format!("{command} to node {other}"))
    })
}

/// NMT commands with a node-ID byte of 128 to 255 address no device: node-IDs are 1 to 127, and 0 addresses all
/// devices.
#[case(id = "301/nmt/reserved-node-id", clause = "CiA 301 7.2.8.1", confidence = Cited, level = Should,
       needs = [VisibleState], catches = [NmtNodeIdIgnored])]
fn reserved_node_id(bench: &mut Bench<'_>) -> Judged {
    let masked = bench.node().raw() | 0x80;
    let commands = [0x80, masked, 0xFF]
        .into_iter()
        .flat_map(|node| [Command::STOP, Command::RESET_NODE].map(|command| (node, command)));
    bench.each(commands, |bench, (node, command)| {
        bench.reach(State::OPERATIONAL)?;
        bench.command_to(node, command)?;
        undisturbed(bench, &format!("{command} to node-ID {node}"))
    })
}

/// The device ignores NMT command specifiers that CiA 301 does not define.
///
/// Annex A of CiA 301, which is a recommendation, says that messages with invalid content are ignored.
#[case(id = "301/nmt/reserved-command", clause = "CiA 301 7.2.8.3.1.1", confidence = Cited, level = Should,
       needs = [VisibleState], catches = [NmtUnknownCommandStops])]
fn reserved_command(bench: &mut Bench<'_>) -> Judged {
    bench.each([0x00, 0x03, 0x04, 0x7F, 0x83, 0xFF], |bench, specifier| {
        bench.reach(State::OPERATIONAL)?;
        bench.command(Command(specifier))?;
        undisturbed(bench, &format!("the reserved command specifier {specifier:02X}h"))
    })
}

/// The device ignores NMT commands that are 29-bit frames, remote frames or too short to contain a node-ID: an NMT
/// command is a data frame of two bytes with the 11-bit CAN-ID 0.
#[case(id = "301/nmt/malformed", clause = "CiA 301 7.3.3", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtShortFrameObeyed, ExtendedFrameObeyed])]
fn malformed(bench: &mut Bench<'_>) -> Judged {
    let stop = [Command::STOP.0, bench.node().raw()];
    let id = CanId::standard_masked(u32::from(nmt::CAN_ID));
    let frames = [
        ("an NMT frame without node-ID", Frame::new(id, &stop[..1])),
        ("an empty NMT frame", Frame::new(id, &[])),
        ("an NMT command in a 29-bit frame", Frame::new(CanId::extended_masked(0), &stop)),
        ("an NMT remote frame", Frame::remote(id, 2)),
    ];
    bench.each(frames, |bench, (what, frame)| {
        bench.reach(State::OPERATIONAL)?;
        if let Some(frame) = frame {
            bench.send(&frame)?;
        }
        undisturbed(bench, what)
    })
}

/// The device executes all of several NMT commands that follow each other without a pause: its final NMT state is that
/// of the last command.
#[case(id = "301/nmt/back-to-back", clause = "CiA 301 7.2.8.2.1.2", confidence = Cited, level = Must,
       needs = [VisibleState], catches = [NmtStartWhenStoppedIgnored, NmtCommandLost])]
fn back_to_back(bench: &mut Bench<'_>) -> Judged {
    /// Some devices send a heartbeat for each state change, one after the other: the last one counts.
    const SETTLED: Duration = Duration::from_millis(300);
    bench.show_state()?;
    for _ in 0..10 {
        bench.command(Command::STOP)?;
        bench.command(Command::START)?;
    }
    bench.listen(SETTLED)?;
    bench.expect_state(State::OPERATIONAL, "20 commands back to back, the last of which was start remote node")
}

/// The device executes or ignores an NMT frame of more than two bytes, but never takes the additional bytes for a
/// command. The case notes which of the two it does, because CiA 301 does not say.
#[case(id = "301/nmt/long-frame", clause = "CiA 301 7.2.8.3.1.1", confidence = Cited, level = Should,
       needs = [VisibleState], catches = [NmtLongFrameMisread])]
fn long_frame(bench: &mut Bench<'_>) -> Judged {
    let node = bench.node().raw();
    let mut obeyed = Vec::new();
    bench.each(3..=8_usize, |bench, length| {
        bench.reach(State::PRE_OPERATIONAL)?;
        // A start command, followed by a command with a lasting effect.
        let stop = Command::STOP.0;
        let bytes = [Command::START.0, node, stop, node, stop, node, stop, node];
        bench.send_bytes(0, bytes.get(..length).unwrap_or(&bytes))?;
        bench.listen(bench.timing().reaction)?;
        let state = bench.state()?;
        bench.command(Command::ENTER_PRE_OPERATIONAL)?;
        let allowed = [State::PRE_OPERATIONAL, State::OPERATIONAL];
        demand(state.is_some_and(|state| allowed.contains(&state)), || {
            let duty = format!("an NMT frame of {length} bytes has the effect of its first two bytes, or none");
            let found = state.map_or(Observation::Silence, Observation::State);
            let allowed = Allowed::OneOf(allowed.map(Observation::State).to_vec());
            Breach::new(Subject::Device, duty).expected(allowed).found(found)
        })?;
        if state == Some(State::OPERATIONAL) {
            obeyed.push(length.to_string());
        }
        Ok(())
    })?;
    bench.note(match obeyed.is_empty() {
        true => "NMT frames of 3 to 8 bytes are ignored".to_owned(),
        false => format!("NMT frames of {} bytes are obeyed", obeyed.join(", ")),
    });
    Ok(())
}
