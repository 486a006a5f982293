//! Reads from the device before the first sequence: its values, its optional services and its response times. It also
//! finds the frames of other nodes on the bus.

use super::baseline;
use super::execute::is_interrupted;
use super::stand::{Readiness, TestStand};
use super::time_limit::TimeLimit;
use super::{Knowledge, Known, Start};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss::{self, Part};
use canvass_analyzer::wire::sdo::{Payload, REQUEST_BASE, RESPONSE_BASE, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, BusError};
use canvass_traces::{Direction, Duration, Frame};
use std::ops::RangeInclusive;

/// Whether the device answered an SDO request at all.
pub(super) type Answers = bool;

/// Maximum length in bytes of a value in an expedited transfer.
const EXPEDITED: usize = 4;

/// Time for which the fuzzer listens to messages that the device sends unasked.
const LISTEN: Duration = Duration::from_millis(600);

/// Time for the first answer, when the speed of the device is not known yet.
const FIRST_ANSWER: Duration = Duration::from_secs(5);

/// Maximum number of attempts to read the device if each is interrupted on the way to the bus.
const MOST_INTERRUPTED: u32 = 5;

/// Reads the values after power-on: the identity and every number of the dictionary. `lss`: also finds the optional
/// services of LSS, for which all slaves on the bus are switched to configuration state and back. If the connection to
/// the bus was interrupted meanwhile, everything is read again.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub(super) fn learn(
    stand: &mut dyn TestStand,
    knowledge: &mut Knowledge,
    lss: bool,
    time: &TimeLimit,
) -> Result<Answers, BusError> {
    let described = knowledge.clone();
    for _ in 1..MOST_INTERRUPTED {
        let before = stand.bus().health();
        let answers = learn_once(stand, knowledge, lss, time)?;
        if !is_interrupted(stand, &before) || time.is_over() {
            return Ok(answers);
        }
        *knowledge = described.clone();
        stand.bus().wait_until_back()?;
    }
    learn_once(stand, knowledge, lss, time)
}

fn learn_once(
    stand: &mut dyn TestStand,
    knowledge: &mut Knowledge,
    lss: bool,
    time: &TimeLimit,
) -> Result<Answers, BusError> {
    if stand.begin(Start::Configured)? == Readiness::Dead {
        return Ok(false);
    }
    let node = knowledge.node;
    let first = knowledge.patience.answer.max(FIRST_ANSWER);
    let Some((_, slowest)) = ask(stand.bus(), node, first, Multiplexer::new(object::DEVICE_TYPE, 0))? else {
        return Ok(false);
    };
    let answer = knowledge.patience.answer.max(slowest.times(3));
    let mut times = vec![slowest];
    listen(stand.bus(), knowledge)?;
    let numbers = |lengths: RangeInclusive<usize>| -> Vec<Multiplexer> {
        let has_length = |known: &&Known| known.readable && known.size.is_some_and(|size| lengths.contains(&size));
        knowledge.entries().iter().filter(has_length).map(|known| known.at).collect()
    };
    let (short, mut long) = (numbers(1..=EXPEDITED), numbers(EXPEDITED + 1..=baseline::LONGEST));
    for at in short {
        if time.is_over() {
            return Ok(true);
        }
        let Some((response, took)) = ask(stand.bus(), node, answer, at)? else { continue };
        times.push(took);
        match value(response, at) {
            Some(raw) => knowledge.learn(at, raw),
            None if matches!(response, Response::InitiateUpload { .. }) => long.push(at),
            None => {}
        }
    }
    if !stand.is_repeatable() {
        knowledge.patience = knowledge.patience.measured(times, stand.restart_time());
        stand.attune(knowledge.patience);
    }
    for at in long {
        if time.is_over() {
            return Ok(true);
        }
        if let Some(raw) = baseline::read(stand.bus(), at, knowledge)? {
            knowledge.learn(at, raw);
        }
    }
    knowledge.address = address(stand.bus(), node, answer)?;
    if lss && knowledge.services.lss == Some(true) && !knowledge.services.lmt {
        learn_lss(stand, knowledge)?;
    }
    Ok(true)
}

/// Reads 1018h:01 to 04; `None` if one of them is missing.
fn address(bus: &mut dyn Bus, node: NodeId, answer: Duration) -> Result<Option<[u32; 4]>, BusError> {
    let mut address = [0; 4];
    for (sub, part) in (1..).zip(&mut address) {
        match read(bus, node, answer, Multiplexer::new(object::IDENTITY, sub))? {
            Some(raw) => *part = raw as u32,
            None => return Ok(None),
        }
    }
    Ok(Some(address))
}

/// Finds CAN-IDs of frames that are sent unasked and don't belong to the device's predefined connection set.
fn listen(bus: &mut dyn Bus, knowledge: &mut Knowledge) -> Result<(), BusError> {
    let own = u16::from(knowledge.node.raw());
    let deadline = bus.now() + LISTEN;
    while let Some(record) = bus.receive(deadline)? {
        let id =
            record.frame.id().as_standard().filter(|_| record.direction != Direction::Tx && !record.frame.is_error());
        if let Some(id) = id.filter(|id| id & 0x7F != own || *id >= REQUEST_BASE && *id < 0x700) {
            knowledge.bystanders.insert(id);
        }
    }
    Ok(())
}

/// Finds whether the slave supports the optional inquiry services and Fastscan, by its first answers.
fn learn_lss(stand: &mut dyn TestStand, knowledge: &mut Knowledge) -> Result<(), BusError> {
    let answer = knowledge.patience.answer;
    let bus = stand.bus();
    dialogue(bus, answer, lss::Request::SwitchGlobal { mode: 1 }, false)?;
    knowledge.services.lss_inquiry = Some(dialogue(bus, answer, lss::Request::Inquire { part: Part::VendorId }, true)?);
    dialogue(bus, answer, lss::Request::SwitchGlobal { mode: 0 }, false)?;
    if stand.has_unconfigured() {
        stand.begin(Start::Unconfigured)?;
        let begin = lss::Request::Fastscan { id: 0, bit_check: 128, sub: 0, next: 0 };
        knowledge.services.fastscan = Some(dialogue(stand.bus(), answer, begin, true)?);
    }
    Ok(())
}

/// Sends an LSS request. Returns whether it was answered.
fn dialogue(bus: &mut dyn Bus, answer: Duration, request: lss::Request, is_answered: bool) -> Result<bool, BusError> {
    bus.send(&request.to_frame(lss::MASTER_CAN_ID))?;
    let deadline = bus.now() + if is_answered { answer } else { Duration::from_millis(5) };
    while let Some(record) = bus.receive(deadline)? {
        if is_answered && record.frame.cob_id() == Some(lss::SLAVE_CAN_ID) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Reads a number of up to four bytes. `None` if the object can't be read.
pub(super) fn read(
    bus: &mut dyn Bus,
    node: NodeId,
    answer: Duration,
    at: Multiplexer,
) -> Result<Option<u64>, BusError> {
    Ok(ask(bus, node, answer, at)?.and_then(|(response, _)| value(response, at)))
}

fn value(response: Response, at: Multiplexer) -> Option<u64> {
    match response {
        Response::InitiateUpload { multiplexer, payload: Payload::Expedited(value) } if multiplexer == at => {
            Some(value.data().iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte)))
        }
        _ => None,
    }
}

/// Reads an object. Returns the response and its response time.
pub(super) fn ask(
    bus: &mut dyn Bus,
    node: NodeId,
    answer: Duration,
    at: Multiplexer,
) -> Result<Option<(Response, Duration)>, BusError> {
    request(bus, node, answer, Request::upload(at))
}

/// Sends a request. Returns the response and its response time.
pub(super) fn request(
    bus: &mut dyn Bus,
    node: NodeId,
    answer: Duration,
    request: Request,
) -> Result<Option<(Response, Duration)>, BusError> {
    let node = u16::from(node.raw());
    let request: Frame = request.to_frame(REQUEST_BASE + node);
    let begun = bus.now();
    bus.send(&request)?;
    let deadline = begun + answer;
    while let Some(record) = bus.receive(deadline)? {
        if record.frame.cob_id() == Some(RESPONSE_BASE + node) {
            let took = bus.now().since(begun);
            return Ok(Response::read(record.frame.data()).ok().map(|response| (response, took)));
        }
    }
    Ok(None)
}
