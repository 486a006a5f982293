//! The state in which a sequence finds a device that goes on: what a reset has not brought back is written back, and what
//! can't be is known.

use super::stimulus::Stimulus;
use super::{Knowledge, Known, limits};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{REQUEST_BASE, Request};
use canvass_analyzer::wire::{lss, nmt};
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::Exchange;
use canvass_bus::client::sdo::{Mode, Outcome, Transfer};
use canvass_bus::{Bus, BusError};
use canvass_traces::{Duration, Record, Timestamp};
use std::collections::BTreeSet;

/// An object that has not its value of power-on, though the device was reset and the value written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Kept {
    /// The object.
    pub at: Multiplexer,
    /// Its value.
    pub value: u64,
    /// That of power-on.
    pub power_on: u64,
}

/// Reads what those frames may have changed, and writes back what the reset has not. What can't be written back is reported.
/// `earlier`: what could not be written back before, and is looked at again. `observe` sees every frame of it.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub(super) fn restore(
    bus: &mut dyn Bus,
    sent: &[Stimulus],
    earlier: &[Kept],
    knowledge: &Knowledge,
    observe: &mut dyn FnMut(&Record),
) -> Result<Vec<Kept>, BusError> {
    let mut client = Client { exchange: Exchange { bus, observe, ends: Timestamp::MAX }, knowledge };
    let mut changed = Vec::new();
    let mut entries = touched(sent, knowledge);
    entries.extend(earlier.iter().filter_map(|kept| knowledge.position(kept.at)));
    for entry in entries {
        let Some((known, power_on)) = restorable(knowledge, entry) else { continue };
        let value = client.read(known.at)?;
        if value.is_some_and(|value| value != power_on) {
            changed.push((known, power_on));
        }
    }
    client.write_back(&mut changed)?;
    if sent.iter().any(|stimulus| stimulus.frame.cob_id() == Some(lss::MASTER_CAN_ID)) {
        // The slave may be in configuration; the command is the same for LSS and LMT.
        client.exchange.bus.send(&lss::Request::SwitchGlobal { mode: 0 }.to_frame(lss::MASTER_CAN_ID))?;
        client.exchange.wait_for(knowledge.patience.quiet, |_| None::<()>)?;
    }
    let mut kept = Vec::new();
    for (known, power_on) in changed {
        match client.read(known.at)? {
            Some(value) if value != power_on => kept.push(Kept { at: known.at, value, power_on }),
            _ => {}
        }
    }
    Ok(kept)
}

/// What the settings of a device hold at the end of a run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FinalState {
    /// Number of settings that were read before the run.
    pub settings: usize,
    /// Number of these settings that were also read after the run.
    pub compared: usize,
    /// Those that hold another value than before. What moves by itself is not among them.
    pub different: Vec<Kept>,
}

/// Number of unanswered requests after which the fuzzer stops asking the device.
const MOST_SILENT: u32 = 3;

/// What differs is read once more after that time: a clock has gone on by then.
const MOVES: Duration = Duration::from_millis(1_100);

/// Maximum time for reading the settings, so that a run ends in its time on a slow device, too.
const LONGEST_LOOK: Duration = Duration::from_secs(5);

/// Reads the settings again, whether or not a frame has named them, and writes nothing; `None`: the device does not answer.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub(super) fn compare(bus: &mut dyn Bus, knowledge: &Knowledge) -> Result<Option<FinalState>, BusError> {
    let mut client = Client { exchange: Exchange { bus, observe: &mut |_| (), ends: Timestamp::MAX }, knowledge };
    let until = client.exchange.bus.now() + LONGEST_LOOK;
    let settings: Vec<_> = (0..knowledge.entries().len()).filter_map(|entry| restorable(knowledge, entry)).collect();
    let (mut compared, mut silent, mut different) = (0, 0, Vec::new());
    for &(known, power_on) in &settings {
        if client.exchange.bus.now() >= until {
            break;
        }
        match client.transfer(Transfer::upload(known.at))? {
            Outcome::Silent if silent + 1 >= MOST_SILENT => return Ok(None),
            Outcome::Silent => silent += 1,
            Outcome::Uploaded(value) if value.len() <= LONGEST => {
                compared += 1;
                let kept = Kept { at: known.at, value: number(&value), power_on };
                different.extend(Some(kept).filter(|kept| kept.value != power_on));
            }
            _ => {}
        }
    }
    if !different.is_empty() {
        client.exchange.wait_for(MOVES, |_| None::<()>)?;
    }
    let mut settled = Vec::new();
    for kept in different {
        if client.read(kept.at)? == Some(kept.value) {
            settled.push(kept);
        }
    }
    Ok(Some(FinalState { settings: settings.len(), compared, different: settled }))
}

fn number(value: &[u8]) -> u64 {
    value.iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte))
}

/// The longest value that is a number.
pub(super) const LONGEST: usize = 8;

/// Reads a number of up to eight bytes; `None`: it can't be read.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub(super) fn read(bus: &mut dyn Bus, at: Multiplexer, knowledge: &Knowledge) -> Result<Option<u64>, BusError> {
    let exchange = Exchange { bus, observe: &mut |_| (), ends: Timestamp::MAX };
    Client { exchange, knowledge }.read(at)
}

/// Reads and writes objects of the device.
struct Client<'a> {
    exchange: Exchange<'a>,
    knowledge: &'a Knowledge,
}

impl Client<'_> {
    /// Reads a number; `None`: it can't be read.
    fn read(&mut self, at: Multiplexer) -> Result<Option<u64>, BusError> {
        Ok(match self.transfer(Transfer::upload(at))? {
            Outcome::Uploaded(value) if value.len() <= LONGEST => Some(number(&value)),
            _ => None,
        })
    }

    /// Writes a number; whether it was confirmed.
    fn write(&mut self, known: &Known, value: u64) -> Result<bool, BusError> {
        let bytes = value.to_le_bytes();
        let value = bytes.get(..known.size.unwrap_or(0)).unwrap_or_default();
        Ok(self.transfer(Transfer::download(known.at, value, Mode::Shortest))? == Outcome::Downloaded)
    }

    fn transfer(&mut self, what: (Transfer, Request)) -> Result<Outcome, BusError> {
        self.exchange.transfer(self.knowledge.node, what, self.knowledge.patience.answer)
    }

    /// Writes values of power-on in the order in which a device takes them: what is valid is made invalid, parameters and
    /// mapping are written, the number of mapped objects, and last what makes it valid again.
    fn write_back(&mut self, changed: &mut [(&Known, u64)]) -> Result<(), BusError> {
        for (known, power_on) in changed.iter().filter(|(known, _)| is_cob_id(known.at)) {
            // Off with the identifier that it has, as a valid one must not change; then with its own.
            if let Some(now) = self.read(known.at)? {
                self.write(known, now | u64::from(CobId::INVALID))?;
            }
            self.write(known, power_on | u64::from(CobId::INVALID))?;
        }
        changed.sort_by_key(|(known, _)| (is_cob_id(known.at), is_mapping(known.at) && known.at.sub.0 == 0, known.at));
        for (known, power_on) in &*changed {
            if self.write(known, *power_on)? {
                continue;
            }
            // The PDO of a parameter that is refused is valid, or its mapping in use.
            let knowledge = self.knowledge;
            let others = switches(known.at).into_iter().filter_map(|at| knowledge.position(at));
            let others: Vec<(&Known, u64)> = others.filter_map(|other| restorable(knowledge, other)).collect();
            for (switch, usual) in &others {
                self.write(switch, if is_cob_id(switch.at) { usual | u64::from(CobId::INVALID) } else { 0 })?;
            }
            self.write(known, *power_on)?;
            for (switch, usual) in others.iter().rev() {
                self.write(switch, *usual)?;
            }
        }
        Ok(())
    }
}

/// The objects that those frames may write: those with which a download begins, and those that an RPDO may carry.
fn touched(sent: &[Stimulus], knowledge: &Knowledge) -> BTreeSet<usize> {
    let request = REQUEST_BASE + u16::from(knowledge.node.raw());
    let mut touched = BTreeSet::new();
    let mut outputs = false;
    for stimulus in sent {
        match (stimulus.frame.cob_id(), stimulus.frame.data()) {
            (Some(id), &[0x20..=0x3F | 0xC0..=0xDF, low, high, sub, ..]) if id == request => {
                touched.extend(knowledge.position(Multiplexer::from_bytes([low, high, sub])));
            }
            (None | Some(nmt::CAN_ID | 0x80 | lss::MASTER_CAN_ID), _) => {}
            (Some(id), _) => outputs |= id != request,
        }
    }
    let is_output = |known: &Known| known.at.index.0 >= 0x2000 && known.writable;
    let entries = knowledge.entries().iter().enumerate();
    touched.extend(entries.filter(|(_, known)| outputs && is_output(known)).map(|(entry, _)| entry));
    touched
}

/// An object whose value of power-on was read and may be written.
fn restorable(knowledge: &Knowledge, entry: usize) -> Option<(&Known, u64)> {
    let known = knowledge.entries().get(entry).filter(|known| known.was_read)?;
    let is_free = limits::writing(known.at, knowledge, &BTreeSet::new()).is_none();
    let is_plain = known.stable
        && known.acting.is_none()
        && known.readable
        && known.writable
        && known.size.is_some_and(|size| size <= LONGEST);
    Some((known, known.power_on?)).filter(|_| is_free && is_plain)
}

fn is_cob_id(at: Multiplexer) -> bool {
    matches!((at.index.0, at.sub.0), (object::COB_ID_EMCY, 0) | (0x1400..0x1600 | 0x1800..0x1A00, 1))
}

fn is_mapping(at: Multiplexer) -> bool {
    matches!(at.index.0, 0x1600..0x1800 | 0x1A00..0x1C00)
}

/// What has to be off while that object is written.
fn switches(at: Multiplexer) -> Vec<Multiplexer> {
    match at.index.0 {
        object::INHIBIT_TIME_EMCY => vec![Multiplexer::new(object::COB_ID_EMCY, 0)],
        0x1400..0x1600 | 0x1800..0x1A00 => vec![Multiplexer::new(at.index.0, 1)],
        0x1600..0x1800 | 0x1A00..0x1C00 => {
            vec![Multiplexer::new(at.index.0 - 0x200, 1), Multiplexer::new(at.index.0, 0)]
        }
        _ => Vec::new(),
    }
}
