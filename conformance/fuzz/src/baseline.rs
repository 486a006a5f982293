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
use canvass_traces::Timestamp;
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

/// Reads what those frames may have changed, and writes back what the reset has not. What can't be written back is told.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub(super) fn restore(bus: &mut dyn Bus, sent: &[Stimulus], knowledge: &Knowledge) -> Result<Vec<Kept>, BusError> {
    let mut changed = Vec::new();
    for entry in touched(sent, knowledge) {
        let Some((known, power_on)) = restorable(knowledge, entry) else { continue };
        let value = read(bus, known.at, knowledge)?;
        if value.is_some_and(|value| value != power_on) {
            changed.push((known, power_on));
        }
    }
    write_back(bus, &mut changed, knowledge)?;
    if sent.iter().any(|stimulus| stimulus.frame.cob_id() == Some(lss::MASTER_CAN_ID)) {
        // A reset may leave the slave in configuration; the command is the same for LSS and LMT.
        bus.send(&lss::Request::SwitchGlobal { mode: 0 }.to_frame(lss::MASTER_CAN_ID))?;
        let until = bus.now() + knowledge.patience.quiet;
        while bus.receive(until)?.is_some() {}
    }
    let mut kept = Vec::new();
    for (known, power_on) in changed {
        match read(bus, known.at, knowledge)? {
            Some(value) if value != power_on => kept.push(Kept { at: known.at, value, power_on }),
            _ => {}
        }
    }
    Ok(kept)
}

/// The longest value that is a number.
const LONGEST: usize = 8;

/// Reads a number; `None`: it can't be read.
fn read(bus: &mut dyn Bus, at: Multiplexer, knowledge: &Knowledge) -> Result<Option<u64>, BusError> {
    let number = |value: Vec<u8>| value.iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte));
    Ok(match transfer(bus, Transfer::upload(at), knowledge)? {
        Outcome::Uploaded(value) if value.len() <= LONGEST => Some(number(value)),
        _ => None,
    })
}

fn transfer(bus: &mut dyn Bus, what: (Transfer, Request), knowledge: &Knowledge) -> Result<Outcome, BusError> {
    let mut exchange = Exchange { bus, observe: &mut |_| (), ends: Timestamp::MAX };
    exchange.transfer(knowledge.node, what, knowledge.patience.answer)
}

/// The objects that those frames name, and those that an RPDO may write.
fn touched(sent: &[Stimulus], knowledge: &Knowledge) -> BTreeSet<usize> {
    let request = REQUEST_BASE + u16::from(knowledge.node.raw());
    let mut touched = BTreeSet::new();
    let mut outputs = false;
    for stimulus in sent {
        match (stimulus.frame.cob_id(), stimulus.frame.data()) {
            (Some(id), &[_, low, high, sub, ..]) if id == request => {
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

/// An object whose value of power-on is known and may be written.
fn restorable(knowledge: &Knowledge, entry: usize) -> Option<(&Known, u64)> {
    let known = knowledge.entries().get(entry)?;
    let is_free = limits::writing(known.at, knowledge, &BTreeSet::new()).is_none();
    let is_plain = known.stable && known.readable && known.writable && known.size.is_some_and(|size| size <= LONGEST);
    Some((known, known.power_on?)).filter(|_| is_free && is_plain)
}

/// Writes values of power-on in the order in which a device takes them: what is valid is made invalid, parameters and
/// mapping are written, the number of mapped objects, and last what makes it valid again.
fn write_back(bus: &mut dyn Bus, changed: &mut [(&Known, u64)], knowledge: &Knowledge) -> Result<(), BusError> {
    let mut write = |known: &Known, value: u64| -> Result<bool, BusError> {
        let bytes = value.to_le_bytes();
        let value = bytes.get(..known.size.unwrap_or(0)).unwrap_or_default();
        let download = Transfer::download(known.at, value, Mode::Shortest);
        Ok(transfer(bus, download, knowledge)? == Outcome::Downloaded)
    };
    for (known, power_on) in changed.iter().filter(|(known, _)| is_cob_id(known.at)) {
        write(known, power_on | u64::from(CobId::INVALID))?;
    }
    changed.sort_by_key(|(known, _)| (is_cob_id(known.at), is_mapping(known.at) && known.at.sub.0 == 0, known.at));
    for (known, power_on) in &*changed {
        if write(known, *power_on)? {
            continue;
        }
        // The PDO of a parameter that is refused is valid, or its mapping in use.
        let others = switches(known.at).into_iter().filter_map(|at| knowledge.position(at));
        let others: Vec<(&Known, u64)> = others.filter_map(|other| restorable(knowledge, other)).collect();
        for (switch, usual) in &others {
            write(switch, if is_cob_id(switch.at) { usual | u64::from(CobId::INVALID) } else { 0 })?;
        }
        write(known, *power_on)?;
        for (switch, usual) in others.iter().rev() {
            write(switch, *usual)?;
        }
    }
    Ok(())
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
