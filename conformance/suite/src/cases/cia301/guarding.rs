//! Node guarding: the master sends remote frames, the device answers with its state (CiA 301, 7.2.8.3.2.1).

use crate::bench::Bench;
use crate::bench::state::{GUARD_TIME, HEARTBEAT_TIME, LIFE_TIME_FACTOR, command_to};
use crate::case;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;
use canvass_traces::{CanId, Frame};

/// The frame that answers a guarding request, if any.
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

/// The toggle bit `0` or `1`, or `-` for no answer.
fn toggle_of(answer: Option<Frame>) -> char {
    match answer.and_then(|frame| ErrorControl::read(frame.data()).ok()) {
        Some(ErrorControl { toggle: false, .. }) => '0',
        Some(ErrorControl { toggle: true, .. }) => '1',
        None => '-',
    }
}

fn observed(answer: Option<Frame>) -> Observation {
    answer.map_or(Observation::Silence, |frame| Observation::Value(frame.data().to_vec()))
}

/// Makes guarding the device's error control: no heartbeat, and a life time that never passes.
fn prepare(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.prefer_guarding()?;
    bench.let_guarding_be_answered()
}

/// Bit 7 of the answers to guarding requests alternates, beginning with 0 in the first answer after a reset.
#[case(id = "301/guarding/toggle", clause = "CiA 301 7.2.8.3.2.1", confidence = Cited, level = Must,
       needs = [Guarding], catches = [GuardingToggleStuck], cct = "7.3")]
fn toggle(bench: &mut Bench<'_>) -> Judged {
    prepare(bench)?;
    let mut toggles = String::new();
    for _ in 0..5 {
        toggles.push(toggle_of(answer(bench)?));
    }
    let named = |toggles: &str| match toggles {
        "-----" => Observation::Silence,
        toggles => Observation::Named(format!("toggle bits {toggles}").into()),
    };
    bench.check(demand(toggles == "01010", || {
        let breach = Breach::new(Service::Guarding, "the toggle bit of five answers alternates from 0");
        breach.expected(named("01010")).found(named(&toggles))
    }))
}

/// Reset communication resets the toggle bit: it is 0 in the first guarding answer after the reset.
#[case(id = "301/guarding/toggle-reset", clause = "CiA 301 7.2.8.3.2.1", confidence = Cited, level = Must,
       needs = [Guarding], catches = [GuardingToggleNotReset])]
fn toggle_reset(bench: &mut Bench<'_>) -> Judged {
    prepare(bench)?;
    let before = answer(bench)?;
    demand(before.is_some(), || {
        let breach = Breach::new(Service::Guarding, "guarding is answered").expected("an answer");
        breach.found(observed(before))
    })
    .or_inconclusive()?;
    if toggle_of(before) == '1' {
        // This answer has toggle bit 0, so the next one has 1 if the reset does not clear the bit.
        answer(bench)?;
    }
    bench.reset(Command::RESET_COMMUNICATION)?;
    prepare(bench)?;
    let after = answer(bench)?;
    bench.check(demand(toggle_of(after) == '0', || {
        let duty = "the toggle bit of the first answer after reset communication is 0";
        Breach::new(Service::Guarding, duty).expected("toggle bit 0").found(observed(after))
    }))
}

/// The answer to a guarding request is one byte with the NMT state in bits 0 to 6: 7Fh pre-operational, 05h
/// operational, 04h stopped.
#[case(id = "301/guarding/state", clause = "CiA 301 7.2.8.3.2.1", confidence = Cited, level = Must,
       needs = [Guarding], catches = [GuardingWrongState, NmtStopWhenOperationalIgnored, NmtStartWhenStoppedIgnored],
       cct = "7.2")]
fn state(bench: &mut Bench<'_>) -> Judged {
    prepare(bench)?;
    let states = [State::PRE_OPERATIONAL, State::OPERATIONAL, State::STOPPED, State::OPERATIONAL];
    bench.each(states.into_iter().enumerate(), |bench, (n, state)| {
        // The device is pre-operational already: a command for this state would be a stimulus of its own.
        if let Some(command) = command_to(state).filter(|_| n > 0) {
            bench.command(command)?;
        }
        bench.listen(bench.timing().reaction)?;
        let found = answer(bench)?;
        let is_right = found.is_some_and(|frame| matches!(*frame.data(), [byte] if byte & 0x7F == state.0));
        bench.check(demand(is_right, || {
            let duty = format!("the guarding answer of a device that is {state} shows this state");
            let expected = format!("{:02X} or {:02X}", state.0, state.0 | 0x80);
            Breach::new(Service::Guarding, duty).expected(expected).found(observed(found))
        }))
    })
}

/// The case only records whether the device answers guarding requests while guard time and life time factor are 0:
/// these values disable life guarding, and the standard does not say whether the answers stop as well.
#[case(id = "301/guarding/unset", clause = "CiA 301 7.5.2.11", confidence = Cited, level = Open,
       needs = [Guarding], catches = [GuardingSilentWhenOff], cct = "7.1")]
fn unset(bench: &mut Bench<'_>) -> Judged {
    bench.prefer_guarding()?;
    for (multiplexer, zero) in [(GUARD_TIME, &[0, 0][..]), (LIFE_TIME_FACTOR, &[0][..])] {
        if bench.read_number(multiplexer)? != 0 {
            if !bench.can_write(multiplexer)? {
                let actual = format!("{multiplexer} can't be set to 0");
                return Err(Stop::NotApplicable(Reason::new("life guarding can be switched off", "0 or rw", actual)));
            }
            bench.write(multiplexer, zero)?;
        }
    }
    let answer = answer(bench)?;
    bench.check(demand(answer.is_some(), || {
        let breach = Breach::new(Service::Guarding, "with 100Ch = 0 and 100Dh = 0 guarding is answered");
        breach.expected("an answer").found(Observation::Silence)
    }))
}

/// A device uses either heartbeat or guarding, and heartbeat takes precedence: while 1017h is not 0, the device does
/// not answer guarding requests.
#[case(id = "301/guarding/heartbeat-wins", clause = "CiA 301 7.2.8.3.2.2", confidence = Cited, level = Must,
       needs = [Guarding, Heartbeat], catches = [GuardingBesideHeartbeat], cct = "7.205")]
fn heartbeat_wins(bench: &mut Bench<'_>) -> Judged {
    bench.let_guarding_be_answered()?;
    // Longer than the wait for the answer, so that no heartbeat is taken for the answer.
    bench.write(HEARTBEAT_TIME, &5_000_u16.to_le_bytes())?;
    let found = answer(bench)?;
    bench.check(demand(found.is_none(), || {
        let breach = Breach::new(Service::Guarding, "guarding is not answered while the heartbeat is on");
        breach.expected(Observation::Silence).found(observed(found))
    }))
}

/// Every device has a heartbeat producer (1017h) or node guarding (100Ch and 100Dh).
///
/// The case reads the objects from the device and does not rely on the description.
#[case(id = "301/guarding/error-control", clause = "CiA 301 7.2.8.2.2", confidence = Cited, level = Must,
       catches = [ErrorControlMissing])]
fn error_control(bench: &mut Bench<'_>) -> Judged {
    let mut found = Vec::new();
    for multiplexer in [HEARTBEAT_TIME, GUARD_TIME, LIFE_TIME_FACTOR] {
        if matches!(bench.upload(multiplexer)?.outcome, Outcome::Uploaded(_)) {
            found.push(multiplexer);
        }
    }
    bench.check(demand(found.contains(&HEARTBEAT_TIME) || found.len() == 2, || {
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        let breach = Breach::new(HEARTBEAT_TIME, "the device has error control");
        let breach = breach.expected("1017h:00, or 100Ch:00 and 100Dh:00");
        let told = if found.is_empty() { "none of them".to_owned() } else { format!("only {}", found.join(", ")) };
        breach.found(Observation::named("neither heartbeat nor guarding")).told(told)
    }))
}

/// A device without guard time (100Ch) does not answer remote frames for its error control message: 100Ch is mandatory
/// for guarding.
#[case(id = "301/guarding/not-supported", clause = "CiA 301 7.5.2.11", confidence = Cited, level = Should,
       needs = [Heartbeat, Description], catches = [GuardingAnsweredUnsupported])]
fn not_supported(bench: &mut Bench<'_>) -> Judged {
    if bench.has(GUARD_TIME)? {
        return Err(Stop::NotApplicable(Reason::new(
            "the device has no node guarding",
            "a device without guard time",
            "100Ch:00 exists",
        )));
    }
    bench.prefer_guarding()?;
    let answer = answer(bench)?;
    bench.check(demand(answer.is_none(), || {
        let breach = Breach::new(Service::Guarding, "without 100Ch a guarding request is not answered");
        breach.expected(Observation::Silence).found(observed(answer))
    }))
}
