//! Configuration of the node-ID (CiA 305, 6.4.2).

use super::dialogue::{breach, configure, exchange, expect_error, observed, set_node_id, shown, wait};
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::RESTART;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lss::{ConfigureCommand, Lss, Request, Response};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;
use std::collections::BTreeSet;

/// Wait after a boot-up: the first further frames of the device belong to its start.
const AFTER_BOOT_UP: Duration = Duration::from_millis(100);

/// A node-ID that nobody uses.
pub(super) fn vacant(bench: &Bench<'_>) -> Result<u8, Stop> {
    let none = || Stop::NotApplicable(Reason::new("a neighbouring node-ID is free", "one", "none"));
    bench.vacant_neighbour().ok_or_else(none)
}

/// The node-ID with which the device starts, within its boot-up time: the expected one, with any data in the boot-up
/// message, otherwise a node-ID that was never heard before.
pub(super) fn boots(bench: &mut Bench<'_>, expected: u8) -> Result<Option<u8>, Stop> {
    let others: BTreeSet<NodeId> = bench.others().clone();
    let mut elsewhere = None;
    let there = bench.wait_for(bench.timing().boot_up, |record| {
        let cob_id = record.frame.cob_id().filter(|id| id & 0x780 == error_control::CAN_ID_BASE)?;
        let node = NodeId::of_cob_id(cob_id)?;
        if node.raw() == expected {
            return Some(());
        }
        if record.frame.data() == [0] && !others.contains(&node) {
            elsewhere = Some(node.raw());
        }
        None
    })?;
    if let Some(node) = elsewhere {
        bench.gives_node_id(node);
    }
    bench.listen(AFTER_BOOT_UP)?;
    Ok(if there.is_some() { Some(expected) } else { elsewhere })
}

/// The breach if the device did not start with the expected node-ID.
pub(super) fn started_elsewhere(duty: impl Into<String>, expected: u8, booted: Option<u8>) -> Breach {
    let found = booted.map_or(Observation::Silence, |node| Observation::Number(node.into()));
    let told =
        booted.map_or_else(|| "no boot-up message".to_owned(), |node| format!("a boot-up message of node {node}"));
    breach(duty).expected(Observation::Number(expected.into())).found(found).told(told)
}

/// Configures the device's own node-ID, which is in use after a reset. If the device refuses it, reset node loads the
/// stored node-ID.
pub(super) fn back_to_own(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let own = bench.node().raw();
    configure(bench)?;
    set_node_id(bench, own)?;
    wait(bench)?;
    bench.listen(RESTART)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    if boots(bench, own)? != Some(own) && !bench.answers()? {
        bench.command_all(Command::RESET_NODE)?;
        boots(bench, own)?;
    }
    Ok(())
}

/// Configures the device's own node-ID and the bit rate of the bus, and stores them if other values are stored.
pub(super) fn restore(bench: &mut Bench<'_>, stored: bool) -> Result<(), Stop> {
    let own = bench.node().raw();
    let rate = bench.bit_rate().and_then(Lss::bit_rate_index);
    // A device may be delivered without bit rate, a state that no command restores. Without a store the bit rate is only
    // pending: some devices restart with it at the end of configuration.
    let keeps_bit_rate = stored && bench.keeps_bit_rate();
    configure(bench)?;
    set_node_id(bench, own)?;
    if let Some(index) = rate.filter(|_| !keeps_bit_rate) {
        exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    }
    if stored {
        exchange(bench, Request::StoreConfiguration)?;
        bench.listen(bench.timing().silence)?;
    }
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    bench.wait_for_boot_up().map(|_| ())
}

/// The slave confirms the node-IDs 1 and 127 and the value 255 (not configured).
#[case(id = "305/node-id/valid", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdRefused])]
fn valid(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    bench.each([1, 127, 255], |bench, node| {
        let answer = exchange(bench, Request::ConfigureNodeId { node_id: node })?;
        bench.check(expect_error(&format!("node-ID {node}"), ConfigureCommand::NodeId, &[0], answer))
    })?;
    own_again(bench)
}

/// The slave refuses node-IDs that do not exist, 0 and 128 to 254, with error code 1.
#[case(id = "305/node-id/invalid", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdUnchecked])]
fn invalid(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    bench.each([0, 128, 129, 200, 254], |bench, node_id| {
        let answer = exchange(bench, Request::ConfigureNodeId { node_id })?;
        bench.check(expect_error(&format!("node-ID {node_id}"), ConfigureCommand::NodeId, &[1], answer))
    })?;
    let own = bench.node().raw();
    let answer = set_node_id(bench, own)?;
    bench.check(expect_error("its own node-ID after those", ConfigureCommand::NodeId, &[0], answer))?;
    wait(bench)
}

/// Replaces the pending node-ID by the current one before it can take effect.
fn own_again(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let own = bench.node().raw();
    set_node_id(bench, own)?;
    wait(bench)
}

/// A new node-ID takes effect at the next reset communication: the device starts with it.
#[case(id = "305/node-id/takes-effect", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdWithoutEffect, NmtBroadcastIgnored, LssNodeIdMistaken])]
fn takes_effect(bench: &mut Bench<'_>) -> Judged {
    let other = vacant(bench)?;
    configure(bench)?;
    set_node_id(bench, other)?;
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    let booted = boots(bench, other)?;
    let duty = "the device uses its new node-ID after reset communication";
    bench.check(demand(booted == Some(other), || started_elsewhere(duty, other, booted)))?;
    bench.uncancelled(back_to_own)
}

/// Until a reset the device keeps its old node-ID.
#[case(id = "305/node-id/pending", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdAtOnce])]
fn pending(bench: &mut Bench<'_>) -> Judged {
    let other = vacant(bench)?;
    configure(bench)?;
    let taken = set_node_id(bench, other)?;
    expect_error("another node-ID", ConfigureCommand::NodeId, &[0], taken).or_inconclusive()?;
    wait(bench)?;
    let restarted = bench.wait_for(RESTART, |record| {
        let id = record.frame.cob_id()?;
        (id & 0x780 == error_control::CAN_ID_BASE && record.frame.data() == [0]).then_some(id)
    })?;
    if restarted.is_some() {
        // Some devices restart as soon as configuration ends.
        bench.uncancelled(back_to_own)?;
        bench.note("a new node-ID restarts the device as soon as it is in waiting");
        let reason = Reason::new("a new node-ID waits for a reset", "no restart", "a restart after configuration");
        return Err(Stop::NotApplicable(reason));
    }
    let answers = bench.answers()?;
    bench.check(demand(answers, || {
        let breach = breach("before a reset the device answers with its old node-ID");
        breach.expected("an SDO response").found(Observation::Silence)
    }))?;
    bench.uncancelled(back_to_own)
}

/// While a new node-ID is pending, the inquiry returns the node-ID in use.
#[case(id = "305/node-id/inquired-pending", clause = "CiA 305 6.5.3", confidence = Attested, level = Should,
       needs = [Lss, LssInquiry, Alone], touches = [NodeId], catches = [LssNodeIdAtOnce])]
fn inquired_pending(bench: &mut Bench<'_>) -> Judged {
    let other = vacant(bench)?;
    configure(bench)?;
    set_node_id(bench, other)?;
    let given = exchange(bench, Request::InquireNodeId)?;
    let own = bench.node().raw();
    let is_own = given.is_some_and(|given| given == Response::NodeId(own));
    bench.check(demand(is_own, || {
        breach("the inquiry returns the node-ID in use while another one is pending")
            .expected(Observation::Number(own.into()))
            .found(observed(given))
            .told(shown(given))
    }))?;
    own_again(bench)
}

/// A node-ID that was configured but not stored is lost at reset node: the device has its old node-ID again.
#[case(id = "305/node-id/not-stored", clause = "CiA 305 6.4.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdStoredAtOnce])]
fn not_stored(bench: &mut Bench<'_>) -> Judged {
    let (own, other) = (bench.node().raw(), vacant(bench)?);
    configure(bench)?;
    let answer = set_node_id(bench, other)?;
    wait(bench)?;
    if let Err(breach) = expect_error(&format!("node-ID {other}"), ConfigureCommand::NodeId, &[0], answer) {
        return Err(Stop::from(breach).unreached());
    }
    bench.listen(RESTART)?;
    bench.command_all(Command::RESET_NODE)?;
    let booted = boots(bench, own)?;
    let is_back = booted == Some(own) || bench.answers()?;
    bench.check(demand(is_back, || {
        started_elsewhere("after reset node a node-ID that was not stored is lost", own, booted)
    }))?;
    if is_back { Ok(()) } else { bench.uncancelled(back_to_own) }
}
