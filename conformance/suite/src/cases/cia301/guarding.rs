//! Node guarding: the master asks by remote frames, the device answers with its state (CiA 301, 7.2.8.3.2.1).

use crate::bench::Bench;
use crate::bench::state::{GUARD_TIME, HEARTBEAT_TIME, command_to};
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::Outcome;
use canvass_bus::client::sdo::Bytes;
use canvass_traces::{CanId, Frame};

/// The frame that answers a guarding request, if one does.
fn answer(bench: &mut Bench<'_>) -> Result<Option<Frame>, Stop> {
    let cob_id = error_control::CAN_ID_BASE + u16::from(bench.node().raw());
    bench.drain()?;
    if let Some(request) = Frame::remote(CanId::standard_masked(u32::from(cob_id)), 1) {
        bench.send(&request)?;
    }
    bench.wait_for(bench.timing().silence, |record| {
        let is_ours = record.frame.cob_id() == Some(cob_id) && !record.frame.is_remote();
        is_ours.then_some(record.frame)
    })
}

/// `0`, `1`, or `-` for no answer.
fn toggle_of(answer: Option<Frame>) -> char {
    match answer.and_then(|frame| ErrorControl::read(frame.data()).ok()) {
        Some(ErrorControl { toggle: false, .. }) => '0',
        Some(ErrorControl { toggle: true, .. }) => '1',
        None => '-',
    }
}

fn shown(answer: Option<Frame>) -> String {
    answer.map_or_else(|| "no answer".to_owned(), |frame| Bytes(frame.data()).to_string())
}

/// The answers to guarding requests alternate in bit 7, which is 0 in the first answer after a reset.
#[case(id = "301/guarding/toggle", clause = "CiA 301 7.2.8.3.2.1", confidence = Attested, level = Must,
       needs = [Guarding], catches = [GuardingToggleStuck, GuardingSilentWhenOff], cct = "7.3")]
fn toggle(bench: &mut Bench<'_>) -> Judged {
    bench.prefer_guarding()?;
    let mut toggles = String::new();
    for _ in 0..5 {
        toggles.push(toggle_of(answer(bench)?));
    }
    bench.check(demand(toggles == "01010", || {
        Reason::new("the toggle bit of five answers alternates from 0", "01010", toggles)
    }))
}

/// Reset communication sets the toggle bit back: it is 0 in the first answer after it.
#[case(id = "301/guarding/toggle-reset", clause = "CiA 301 7.2.8.3.2.1", confidence = Attested, level = Must,
       needs = [Guarding], catches = [GuardingToggleNotReset])]
fn toggle_reset(bench: &mut Bench<'_>) -> Judged {
    bench.prefer_guarding()?;
    let before = toggle_of(answer(bench)?);
    demand(before == '0', || Reason::new("guarding is answered", "toggle bit 0", before.to_string()))
        .or_inconclusive()?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    bench.prefer_guarding()?;
    let after = toggle_of(answer(bench)?);
    bench.check(demand(after == '0', || {
        Reason::new("the toggle bit of the first answer after reset communication is 0", "0", after.to_string())
    }))
}

/// The answer to a guarding request is one byte with the NMT state in bits 0 to 6: 7Fh pre-operational, 05h operational,
/// 04h stopped.
#[case(id = "301/guarding/state", clause = "CiA 301 7.2.8.3.2.1", confidence = Attested, level = Must,
       needs = [Guarding], catches = [GuardingWrongState, NmtStopWhenOperationalIgnored, NmtStartWhenStoppedIgnored],
       cct = "7.2")]
fn state(bench: &mut Bench<'_>) -> Judged {
    bench.prefer_guarding()?;
    let states = [State::PRE_OPERATIONAL, State::OPERATIONAL, State::STOPPED, State::OPERATIONAL];
    for (n, state) in states.into_iter().enumerate() {
        // It is pre-operational already: a command for that is a stimulus of its own.
        if let Some(command) = command_to(state).filter(|_| n > 0) {
            bench.command(command)?;
        }
        bench.listen(bench.timing().reaction)?;
        let found = answer(bench)?;
        let is_right = found.is_some_and(|frame| matches!(*frame.data(), [byte] if byte & 0x7F == state.0));
        demand(is_right, || {
            let duty = format!("a device that is {state} says so when it is guarded");
            Reason::new(duty, format!("{:02X} or {:02X}", state.0, state.0 | 0x80), shown(found))
        })?;
    }
    Ok(())
}

/// Heartbeat and guarding exclude each other, and heartbeat wins: with 1017h other than 0 guarding is not answered.
#[case(id = "301/guarding/heartbeat-wins", clause = "CiA 301 7.2.8.2.2", confidence = Known, level = Must,
       needs = [Guarding, Heartbeat], catches = [GuardingBesideHeartbeat], cct = "7.205")]
fn heartbeat_wins(bench: &mut Bench<'_>) -> Judged {
    // Longer than the wait for the answer, so that no heartbeat is taken for one.
    bench.write(HEARTBEAT_TIME, &5_000_u16.to_le_bytes())?;
    let found = answer(bench)?;
    bench.check(demand(found.is_none(), || {
        Reason::new("guarding is not answered while the heartbeat is on", "silence", shown(found))
    }))
}

/// Every device has a heartbeat producer (1017h) or node guarding (100Ch and 100Dh).
///
/// Asked is the device, not its description.
#[case(id = "301/guarding/error-control", clause = "CiA 301 7.2.8.2.2", confidence = Known, level = Must,
       catches = [ErrorControlMissing])]
fn error_control(bench: &mut Bench<'_>) -> Judged {
    let mut found = Vec::new();
    for multiplexer in [HEARTBEAT_TIME, GUARD_TIME, Multiplexer::new(0x100D, 0)] {
        if matches!(bench.upload(multiplexer)?.outcome, Outcome::Uploaded(_)) {
            found.push(multiplexer);
        }
    }
    bench.check(demand(found.contains(&HEARTBEAT_TIME) || found.len() == 2, || {
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        let actual = if found.is_empty() { "none of them".to_owned() } else { found.join(", ") };
        Reason::new("the device has error control", "1017h:00, or 100Ch:00 and 100Dh:00", actual)
    }))
}

/// A device without guard time, 100Ch, does not answer remote frames for its error control message.
#[case(id = "301/guarding/not-supported", clause = "CiA 301 7.2.8.3.2.1", confidence = Attested, level = Should,
       needs = [Heartbeat, Description], catches = [GuardingAnsweredUnsupported])]
fn not_supported(bench: &mut Bench<'_>) -> Judged {
    if bench.has(GUARD_TIME)? {
        return Err(Stop::NotApplicable(Reason::new(
            "the device has no node guarding",
            "a device without guard time",
            "100Ch:00 is there",
        )));
    }
    bench.prefer_guarding()?;
    let answer = answer(bench)?;
    bench.check(demand(answer.is_none(), || {
        Reason::new("without 100Ch a guarding request is not answered", "silence", shown(answer))
    }))
}
