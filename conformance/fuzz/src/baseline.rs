//! The state of a device that is not made anew for each sequence. The fuzzer writes back the values that a reset has
//! not restored, and remembers the values that it can't write back.

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

/// An object whose value differs from its power-on value even after a reset and a write.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Kept {
    /// The address of the object.
    pub at: Multiplexer,
    /// The current value.
    pub value: u64,
    /// The value after power-on.
    pub power_on: u64,
}

/// Reads the objects that the frames in `sent` may have changed, and writes back the power-on values that the reset has
/// not restored. Returns the objects that keep another value. `earlier`: objects that could not be written back before;
/// they are checked again. `observe` sees every frame of these transfers.
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
        // The slave may be in configuration state. "Switch state global" is the same for LSS and LMT.
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

/// The values of a device's settings at the end of a run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FinalState {
    /// Number of settings that were read before the run.
    pub settings: usize,
    /// Number of these settings that were also read after the run.
    pub compared: usize,
    /// Settings whose value differs from the value before the run. Values that change by themselves are left out.
    pub different: Vec<Kept>,
}

/// Number of unanswered requests after which the fuzzer stops asking the device.
const MOST_SILENT: u32 = 3;

/// Time after which a different value is read again. A value that has changed by then changes by itself, such as a
/// clock.
const MOVES: Duration = Duration::from_millis(1_100);

/// Maximum time for reading the settings. The run ends in time even if the device is slow.
const LONGEST_LOOK: Duration = Duration::from_secs(5);

/// Reads all settings again, even settings that no frame has named, and writes none. `None`: the device does not
/// answer.
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

/// Maximum length of a number in bytes.
pub(super) const LONGEST: usize = 8;

/// Reads a number of up to eight bytes; `None` if the object can't be read as one.
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
    /// Reads a number; `None` if the object can't be read as one.
    fn read(&mut self, at: Multiplexer) -> Result<Option<u64>, BusError> {
        Ok(match self.transfer(Transfer::upload(at))? {
            Outcome::Uploaded(value) if value.len() <= LONGEST => Some(number(&value)),
            _ => None,
        })
    }

    /// Writes a number. Returns whether the device confirmed the download.
    fn write(&mut self, known: &Known, value: u64) -> Result<bool, BusError> {
        let bytes = value.to_le_bytes();
        let value = bytes.get(..known.size.unwrap_or(0)).unwrap_or_default();
        Ok(self.transfer(Transfer::download(known.at, value, Mode::Shortest))? == Outcome::Downloaded)
    }

    fn transfer(&mut self, what: (Transfer, Request)) -> Result<Outcome, BusError> {
        self.exchange.transfer(self.knowledge.node, what, self.knowledge.patience.answer)
    }

    /// Writes power-on values in the order that a device accepts: first the PDOs and services are made invalid, then
    /// parameters and mappings are written, then the numbers of mapped objects, and last the COB-IDs.
    fn write_back(&mut self, changed: &mut [(&Known, u64)]) -> Result<(), BusError> {
        for (known, power_on) in changed.iter().filter(|(known, _)| is_cob_id(known.at)) {
            // A valid COB-ID must not change its identifier: the first write makes it invalid, the second sets the
            // identifier.
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
            // A device refuses a parameter while its PDO is valid, and a mapping while it is in use.
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

/// The objects that the frames in `sent` may write: by an SDO download, or by an RPDO.
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

/// The object with this number and its power-on value, if that value was read and may be written back.
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

/// The COB-IDs and mappings that must be disabled while the object at `at` is written.
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
