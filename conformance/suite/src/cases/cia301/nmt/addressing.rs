//! Commands that do not concern the device (CiA 301, 7.2.8.3.1.1).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::{self, Command};
use canvass_traces::{CanId, Frame};

/// Demands that the device is still operational and sent no boot-up.
fn undisturbed(bench: &mut Bench<'_>, by: &str) -> Judged {
    let heard = bench.listen(bench.timing().silence)?;
    let boot_ups = heard.iter().filter(|record| bench.is_boot_up(&record.frame)).count();
    demand(boot_ups == 0, || {
        Reason::new(format!("the device ignores {by}"), "no boot-up message", format!("{boot_ups}"))
    })?;
    bench.expect_state(State::OPERATIONAL, by)
}

/// Commands to another node-ID change nothing: no state, no restart.
///
/// The node-ID beside the device's own is used, unless a node was heard there.
#[case(id = "301/nmt/other-node", clause = "CiA 301 7.2.8.3.1.1", confidence = Known, level = Must,
       needs = [VisibleState], catches = [NmtNodeIdIgnored])]
fn other_node(bench: &mut Bench<'_>) -> Judged {
    bench.look_for_others()?;
    let Some(other) = bench.vacant_neighbour() else {
        let reason = Reason::new("a node-ID beside that of the device is free", "no node", "nodes on both sides");
        return Err(Stop::NotApplicable(reason));
    };
    for command in Command::ALL {
        bench.reach(State::OPERATIONAL)?;
        bench.command_to(other, command)?;
        undisturbed(bench, &format!("{command} to node {other}"))?;
    }
    Ok(())
}

/// A node-ID byte of 128 to 255 addresses nobody.
#[case(id = "301/nmt/reserved-node-id", clause = "CiA 301", confidence = Unknown, level = Must,
       needs = [VisibleState], catches = [NmtNodeIdIgnored])]
fn reserved_node_id(bench: &mut Bench<'_>) -> Judged {
    let masked = bench.node().raw() | 0x80;
    for node in [0x80, masked, 0xFF] {
        for command in [Command::STOP, Command::RESET_NODE] {
            bench.reach(State::OPERATIONAL)?;
            bench.command_to(node, command)?;
            undisturbed(bench, &format!("{command} to node-ID {node}"))?;
        }
    }
    Ok(())
}

/// Command specifiers that CiA 301 does not define are ignored.
#[case(id = "301/nmt/reserved-command", clause = "CiA 301 7.2.8.3.1.1", confidence = Known, level = Must,
       needs = [VisibleState], catches = [NmtUnknownCommandStops])]
fn reserved_command(bench: &mut Bench<'_>) -> Judged {
    for specifier in [0x00, 0x03, 0x04, 0x7F, 0x83, 0xFF] {
        bench.reach(State::OPERATIONAL)?;
        bench.command(Command(specifier))?;
        undisturbed(bench, &format!("the reserved command specifier {specifier:02X}h"))?;
    }
    Ok(())
}

/// NMT commands as 29-bit or remote frames, or too short to name a node, are ignored.
#[case(id = "301/nmt/malformed", clause = "CiA 301", confidence = Unknown, level = Must,
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
    for (what, frame) in frames {
        bench.reach(State::OPERATIONAL)?;
        if let Some(frame) = frame {
            bench.send(&frame)?;
        }
        undisturbed(bench, what)?;
    }
    Ok(())
}

/// Of several commands in quick succession the last one decides, and none is lost.
#[case(id = "301/nmt/back-to-back", clause = "CiA 301 7.3.2.2", confidence = Attested, level = Must,
       needs = [VisibleState], catches = [NmtStartWhenStoppedIgnored, NmtCommandLost])]
fn back_to_back(bench: &mut Bench<'_>) -> Judged {
    bench.show_state()?;
    for _ in 0..10 {
        bench.command(Command::STOP)?;
        bench.command(Command::START)?;
    }
    bench.expect_state(State::OPERATIONAL, "20 commands back to back, the last of which was start remote node")
}

/// An NMT frame of more than two bytes is obeyed or ignored, but its surplus bytes are not taken for a command. Which of
/// the two is noted: CiA 301 does not say.
#[case(id = "301/nmt/long-frame", clause = "CiA 301", confidence = Unknown, level = Should, needs = [VisibleState],
       catches = [NmtLongFrameMisread])]
fn long_frame(bench: &mut Bench<'_>) -> Judged {
    let node = bench.node().raw();
    let mut seen = Vec::new();
    for length in 3..=8_usize {
        bench.reach(State::PRE_OPERATIONAL)?;
        // Start, and then the command that resets this node.
        let bytes = [Command::START.0, node, Command::RESET_NODE.0, node, 0x81, node, 0x81, node];
        bench.send_bytes(0, bytes.get(..length).unwrap_or(&bytes))?;
        bench.listen(bench.timing().reaction)?;
        let state = bench.state()?;
        demand(matches!(state, Some(State::PRE_OPERATIONAL | State::OPERATIONAL)), || {
            let duty = format!("an NMT frame of {length} bytes does what its first two say, or nothing");
            let actual = state.map_or_else(|| "no sign of a state".to_owned(), |state| state.to_string());
            Reason::new(duty, "operational or pre-operational", actual)
        })?;
        if state == Some(State::OPERATIONAL) {
            seen.push(length.to_string());
        }
    }
    bench.note(match seen.is_empty() {
        true => "NMT frames of 3 to 8 bytes are ignored".to_owned(),
        false => format!("NMT frames of {} bytes are obeyed", seen.join(", ")),
    });
    Ok(())
}
