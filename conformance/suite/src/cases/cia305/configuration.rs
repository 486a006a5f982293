//! Configuration of node-ID and bit timing, and storing both (CiA 305, 6.4).

use super::dialogue::{configure, exchange, expect, node_id, shown, wait};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::lss::{BIT_RATES, ConfigureCommand, Request, Response};
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::Duration;

fn is_done(response: Response, wanted: ConfigureCommand) -> bool {
    matches!(response, Response::Configured { command, error: 0, .. } if command == wanted)
}

/// Sets the node-ID that the device will use.
fn set_node_id(bench: &mut Bench<'_>, node_id: u8) -> Result<Option<Response>, Stop> {
    exchange(bench, Request::ConfigureNodeId { node_id })
}

/// Gives the device its own node-ID back, as it was.
fn back_to_own(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let own = bench.node().raw();
    configure(bench)?;
    set_node_id(bench, own)?;
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    bench.listen(Duration::from_millis(1_000)).map(|_| ())
}

/// Gives the device its own node-ID and the bit rate of the bus back, and stores them where something else is stored.
pub(super) fn restore(bench: &mut Bench<'_>, stored: bool) -> Result<(), Stop> {
    let own = bench.node().raw();
    let rate = BIT_RATES.iter().position(|rate| rate.is_some() && *rate == bench.bit_rate());
    configure(bench)?;
    set_node_id(bench, own)?;
    if let Some(index) = rate.and_then(|index| u8::try_from(index).ok()) {
        exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    }
    if stored {
        exchange(bench, Request::StoreConfiguration)?;
        bench.listen(Duration::from_millis(200))?;
    }
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    bench.wait_for_boot_up().map(|_| ())
}

/// A message of that node, whatever its content, within the time that the device has to boot.
fn boots_as(bench: &mut Bench<'_>, node: u8) -> Result<bool, Stop> {
    let id = error_control::CAN_ID_BASE + u16::from(node);
    let seen = bench.wait_for(bench.timing().boot_up, |record| (record.frame.cob_id() == Some(id)).then_some(()))?;
    Ok(seen.is_some())
}

/// The node-IDs 1 and 127 and "not configured" (255) are confirmed.
#[case(id = "305/node-id/valid", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdRefused])]
fn valid(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let mut wrong = None;
    for node in [1, 127, 255] {
        let answer = set_node_id(bench, node)?;
        if !answer.is_some_and(|answer| is_done(answer, ConfigureCommand::NodeId)) {
            wrong = wrong.or(Some((node, answer)));
        }
    }
    let own = bench.node().raw();
    set_node_id(bench, own)?;
    wait(bench)?;
    match wrong {
        None => Ok(()),
        Some((node, answer)) => bench.check(expect(&format!("node-ID {node}"), "success", answer, |_| false)),
    }
}

/// A new node-ID is used from the next reset communication on: the device boots with it.
#[case(id = "305/node-id/takes-effect", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdWithoutEffect, NmtBroadcastIgnored])]
fn takes_effect(bench: &mut Bench<'_>) -> Judged {
    let Some(other) = bench.vacant_neighbour() else {
        return Err(Stop::NotApplicable(Reason::new("a node-ID is free", "one", "none")));
    };
    configure(bench)?;
    set_node_id(bench, other)?;
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    let booted = boots_as(bench, other)?;
    bench.listen(Duration::from_millis(100))?;
    back_to_own(bench)?;
    bench.check(demand(booted, || {
        let expected = format!("a boot-up message of node {other}");
        Reason::new("the device uses its new node-ID after reset communication", expected, "none")
    }))
}

/// Before a reset the device goes on with its old node-ID.
#[case(id = "305/node-id/pending", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdAtOnce])]
fn pending(bench: &mut Bench<'_>) -> Judged {
    let Some(other) = bench.vacant_neighbour() else {
        return Err(Stop::NotApplicable(Reason::new("a node-ID is free", "one", "none")));
    };
    configure(bench)?;
    set_node_id(bench, other)?;
    wait(bench)?;
    let restarted = bench.wait_for(Duration::from_millis(600), |record| {
        let id = record.frame.cob_id()?;
        (id & 0x780 == error_control::CAN_ID_BASE && record.frame.data() == [0]).then_some(id)
    })?;
    if restarted.is_some() {
        // Some devices restart as soon as configuration is over.
        back_to_own(bench)?;
        bench.note("a new node-ID restarts the device as soon as it is in waiting");
        let reason = Reason::new("a new node-ID waits for a reset", "no restart", "a restart after configuration");
        return Err(Stop::NotApplicable(reason));
    }
    let answers = bench.answers()?;
    back_to_own(bench)?;
    bench.check(demand(answers, || {
        let duty = "before a reset the device answers with its old node-ID";
        Reason::new(duty, "an SDO response", "no answer")
    }))
}

/// A stored node-ID is used after reset node; the old one is stored again afterwards.
#[case(id = "305/store/persists", clause = "CiA 305 6.4.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId, Nvm], catches = [LssStoreNotPersistent, NmtResetNodeKeepsParameters, NmtBroadcastIgnored])]
fn store_persists(bench: &mut Bench<'_>) -> Judged {
    let Some(other) = bench.vacant_neighbour() else {
        return Err(Stop::NotApplicable(Reason::new("a node-ID is free", "one", "none")));
    };
    configure(bench)?;
    set_node_id(bench, other)?;
    let answer = exchange(bench, Request::StoreConfiguration)?;
    if matches!(answer, Some(Response::Configured { command: ConfigureCommand::Store, error: 1, .. })) {
        let own = bench.node().raw();
        set_node_id(bench, own)?;
        wait(bench)?;
        let reason = Reason::new("the device stores what LSS configures", "success", "error 1: not supported");
        return Err(Stop::NotApplicable(reason));
    }
    bench.listen(Duration::from_millis(200))?;
    wait(bench)?;
    bench.watch_restart();
    bench.command_all(Command::RESET_NODE)?;
    boots_as(bench, other)?;
    bench.listen(Duration::from_millis(100))?;
    // Only a second reset tells what was stored from what was pending.
    bench.command_all(Command::RESET_NODE)?;
    let booted = boots_as(bench, other)?;
    bench.listen(Duration::from_millis(100))?;
    configure(bench)?;
    let own = bench.node().raw();
    set_node_id(bench, own)?;
    exchange(bench, Request::StoreConfiguration)?;
    bench.listen(Duration::from_millis(200))?;
    wait(bench)?;
    bench.command_all(Command::RESET_NODE)?;
    boots_as(bench, own)?;
    bench.listen(Duration::from_millis(100))?;
    bench.check(demand(booted, || {
        let expected = format!("a boot-up message of node {other}");
        Reason::new("a node-ID that was stored is used after reset node", expected, "none")
    }))
}

/// Store configuration is answered by success, "not supported" or a failure of the memory.
#[case(id = "305/store/answer", clause = "CiA 305 6.4.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [Nvm], catches = [LssStoreUnanswered])]
fn store_answer(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let answer = exchange(bench, Request::StoreConfiguration)?;
    bench.listen(Duration::from_millis(200))?;
    wait(bench)?;
    bench.check(expect("store configuration", "17h with error 0, 1, 2 or 255", answer, |answer| {
        matches!(answer, Response::Configured { command: ConfigureCommand::Store, error: 0 | 1 | 2 | 255, .. })
    }))
}

/// Bit rates of the standard table that the description names are confirmed; all others are refused with error 1.
#[case(id = "305/bit-timing/table", clause = "CiA 305 6.4.3", confidence = Attested, level = Must,
       needs = [Lss, Alone, Description], touches = [BitRate], catches = [LssBitTimingRefused])]
fn table(bench: &mut Bench<'_>) -> Judged {
    let rates: Vec<u32> = bench.target().description.as_ref().map_or_else(Vec::new, |description| {
        description.device.bit_rates.iter().map(|kbit| u32::from(*kbit) * 1_000).collect()
    });
    let current = bench.bit_rate();
    configure(bench)?;
    let (mut wrong, mut refused) = (None, 0);
    for index in (0..=8_u8).filter(|&index| index != 5) {
        let known = BIT_RATES.get(usize::from(index)).copied().flatten();
        let has = known.is_some_and(|rate| rates.contains(&rate));
        let answer = exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
        let right = match answer {
            Some(Response::Configured { command: ConfigureCommand::BitTiming, error, .. }) => {
                refused += usize::from(error == 1);
                if has { error == 0 } else { error == 1 }
            }
            _ => false,
        };
        if !right {
            wrong = wrong.or(Some((index, has, answer)));
        }
    }
    leave_bit_rate(bench, current)?;
    // Who has one bit rate only has nothing to configure, and may refuse that one too.
    let is_fixed = rates.len() == 1 && refused == 8;
    match wrong {
        None => Ok(()),
        Some(_) if is_fixed => Ok(()),
        Some((index, has, answer)) => {
            let expected = if has { "success" } else { "error 1" };
            bench.check(expect(&format!("bit timing {index} of table 0"), expected, answer, |_| false))
        }
    }
}

/// Reserved rows and tables of bit timings are refused with error 1.
#[case(id = "305/bit-timing/reserved", clause = "CiA 305 6.4.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [BitRate], catches = [LssBitTimingUnchecked, LssBitTimingWrongCode])]
fn reserved(bench: &mut Bench<'_>) -> Judged {
    let current = bench.bit_rate();
    configure(bench)?;
    let mut wrong = None;
    for (table, index) in [(0, 5), (0, 10), (0, 255), (1, 0), (127, 0)] {
        let answer = exchange(bench, Request::ConfigureBitTiming { table, index })?;
        let refused =
            matches!(answer, Some(Response::Configured { command: ConfigureCommand::BitTiming, error: 1, .. }));
        if !refused {
            wrong = wrong.or(Some((table, index, answer)));
        }
    }
    leave_bit_rate(bench, current)?;
    match wrong {
        None => Ok(()),
        Some((table, index, answer)) => {
            bench.check(expect(&format!("bit timing {index} of table {table}"), "error 1", answer, |_| false))
        }
    }
}

/// Replaces what is pending by the bit rate in use, and ends configuration.
fn leave_bit_rate(bench: &mut Bench<'_>, current: Option<u32>) -> Result<(), Stop> {
    let index = BIT_RATES.iter().position(|rate| rate.is_some() && *rate == current);
    if let Some(index) = index.and_then(|index| u8::try_from(index).ok()) {
        exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    }
    wait(bench)
}

/// The services of configuration are not answered in waiting.
#[case(id = "305/waiting/configuration", clause = "CiA 305 6.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId, BitRate, Nvm], catches = [LssAnsweredWhileWaiting])]
fn in_waiting(bench: &mut Bench<'_>) -> Judged {
    let own = bench.node().raw();
    let requests = [Request::ConfigureNodeId { node_id: own }, Request::ConfigureBitTiming { table: 0, index: 5 }];
    for request in requests {
        let answer = exchange(bench, request)?;
        super::dialogue::expect_silence(&format!("\"{request}\" in waiting"), answer)?;
    }
    configure(bench)?;
    wait(bench)?;
    Ok(())
}

/// Every response of the slave has eight bytes, and zeros where nothing is said.
#[case(id = "305/form", clause = "CiA 305", confidence = Unknown, level = Should,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssShortResponse])]
fn form(bench: &mut Bench<'_>) -> Judged {
    use canvass_analyzer::wire::lss;
    configure(bench)?;
    let own = bench.node().raw();
    let mut wrong = None;
    for request in [Request::InquireNodeId, Request::ConfigureNodeId { node_id: own }] {
        bench.drain()?;
        bench.send(&request.to_frame(lss::MASTER_CAN_ID))?;
        let frame = bench.wait_for(bench.timing().silence, |record| {
            (record.frame.cob_id() == Some(lss::SLAVE_CAN_ID)).then_some(record.frame)
        })?;
        let clean = frame.and_then(|frame| Response::read(frame.data()).ok());
        let clean = clean.map(|response| response.to_frame(lss::SLAVE_CAN_ID));
        if frame.is_none() || frame != clean {
            wrong = wrong.or(Some(frame));
        }
    }
    wait(bench)?;
    match wrong {
        None => Ok(()),
        Some(frame) => {
            let actual = frame.map_or_else(|| "no answer".to_owned(), |frame| frame.to_string());
            Err(Stop::from(Reason::new("LSS responses have a fixed form", "eight bytes, unused ones 0", actual)))
        }
    }
}

/// While a new node-ID is pending, the inquiry gives the one in use.
#[case(id = "305/node-id/inquired-pending", clause = "CiA 305 6.5.3", confidence = Attested, level = Should,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdAtOnce])]
fn inquired_pending(bench: &mut Bench<'_>) -> Judged {
    let Some(other) = bench.vacant_neighbour() else {
        return Err(Stop::NotApplicable(Reason::new("a node-ID is free", "one", "none")));
    };
    configure(bench)?;
    set_node_id(bench, other)?;
    let given = node_id(bench)?;
    let own = bench.node().raw();
    set_node_id(bench, own)?;
    wait(bench)?;
    bench.check(demand(given == Some(own), || {
        let actual = given.map_or_else(|| shown(None), |node| node.to_string());
        Reason::new("the node-ID in use is given while another one is pending", own.to_string(), actual)
    }))
}

/// Activate bit timing makes the slave silent for its delay, twice: before and after the change.
#[case(id = "305/bit-timing/activate", clause = "CiA 305 6.4.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [BitRate], catches = [LssActivatesAtOnce])]
fn activate(bench: &mut Bench<'_>) -> Judged {
    const DELAY: Duration = Duration::from_millis(300);
    let current = bench.bit_rate();
    let index = BIT_RATES.iter().position(|rate| rate.is_some() && *rate == current);
    let Some(index) = index.and_then(|index| u8::try_from(index).ok()) else {
        let reason = Reason::new("the bit rate of the bus is in table 0", "one of CiA 305", format!("{current:?}"));
        return Err(Stop::NotApplicable(reason));
    };
    // The rate that is in use: nobody has to follow.
    bench.show_state()?;
    configure(bench)?;
    let answer = exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    if !answer.is_some_and(|answer| is_done(answer, ConfigureCommand::BitTiming)) {
        wait(bench)?;
        return Err(Stop::NotApplicable(Reason::new("the bit rate can be set", "success", shown(answer))));
    }
    bench.watch_restart();
    bench.drain()?;
    let request = Request::ActivateBitTiming { delay: 300 };
    bench.send(&request.to_frame(canvass_analyzer::wire::lss::MASTER_CAN_ID))?;
    // What was on its way may still come.
    bench.listen(Duration::from_millis(20))?;
    let silence = bench.listen(Duration::from_millis(560))?;
    bench.listen(DELAY.times(2))?;
    wait(bench)?;
    let answers = bench.answers()?;
    demand(silence.is_empty(), || {
        let actual = silence.first().map(|record| record.frame.to_string()).unwrap_or_default();
        Reason::new("after activate bit timing the slave is silent for twice the delay", "600 ms of silence", actual)
    })?;
    bench.check(demand(answers, || {
        Reason::new("after activate bit timing the device works on", "an SDO response", "none")
    }))
}
