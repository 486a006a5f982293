//! The whole object dictionary: read before a run, compared and put back afterwards.

use super::{Bench, profile, restore, rewrite};
use crate::comparison::{Change, Comparison, Nature};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::configuration::Download;
use canvass_analyzer::dictionary::{Access, DeviceDescription, Entry, names};
use canvass_analyzer::object::{self, Acting};
use canvass_bus::client::Outcome;
use std::collections::BTreeMap;

/// The index ranges that are read from a device without description: the communication objects that a master
/// configures.
const UNDESCRIBED: [(u16, u16); 7] = [
    (0x1000, 0x102A),
    (0x1200, 0x1201),
    (0x1400, 0x1403),
    (0x1600, 0x1603),
    (0x1800, 0x1803),
    (0x1A00, 0x1A03),
    (0x6000, 0x6003),
];

/// Maximum number of entries that are read from one object, whatever its sub-index 0 says.
const MOST_SUBS: u8 = 16;

/// The identity object.
const IDENTITY: u16 = object::IDENTITY;

/// Number of consecutive objects without a valid answer after which reading ends on a live bus: the rest would only
/// take time.
const MOST_UNANSWERED: u32 = 20;

/// Reads every object that the description calls readable; without a description, the communication objects that exist.
/// An object that returns no value is left out.
pub(crate) fn dump(bench: &mut Bench<'_>) -> Vec<(Multiplexer, Vec<u8>)> {
    bench.undisturbed(dump_once)
}

fn dump_once(bench: &mut Bench<'_>) -> Vec<(Multiplexer, Vec<u8>)> {
    let mut values = Vec::new();
    let mut unanswered = 0;
    let mut lost = Vec::new();
    for multiplexer in described_objects(bench) {
        match bench.upload(multiplexer).map(|attempt| attempt.outcome) {
            Ok(Outcome::Uploaded(value)) => values.push((multiplexer, value)),
            Ok(Outcome::Aborted(_)) => {}
            _ => lost.push(multiplexer),
        }
        unanswered = if lost.last() == Some(&multiplexer) { unanswered + 1 } else { 0 };
        if unanswered >= MOST_UNANSWERED && bench.is_live() {
            return values;
        }
    }
    dump_again(bench, &lost, &mut values);
    if bench.target.description.is_none() {
        for index in UNDESCRIBED.into_iter().flat_map(|(first, last)| first..=last) {
            dump_object(bench, index, &mut values);
        }
    }
    values
}

/// Reads unanswered objects again: a lost answer does not mean that the object is absent. If more are missing than a
/// bad connection loses, they are not read again.
fn dump_again(bench: &mut Bench<'_>, lost: &[Multiplexer], values: &mut Vec<(Multiplexer, Vec<u8>)>) {
    const MOST_LOST: usize = 20;
    if lost.is_empty() || lost.len() > MOST_LOST {
        return;
    }
    for &multiplexer in lost {
        if let Ok(Some(value)) = bench.value_at_last(multiplexer) {
            values.push((multiplexer, value));
        }
    }
    values.sort_by_key(|(multiplexer, _)| *multiplexer);
}

fn described_objects(bench: &Bench<'_>) -> Vec<Multiplexer> {
    let Some(description) = &bench.target.description else { return Vec::new() };
    let entries = description.dictionary.entries();
    let readable = entries.filter(|(_, entry)| entry.access.is_readable() && !entry.flags.refuses_read_on_scan());
    readable.map(|(multiplexer, _)| multiplexer).collect()
}

/// Reads an object of which only the index is known: its sub-index 0, and the sub-indexes that sub-index 0 counts, if
/// there are any.
fn dump_object(bench: &mut Bench<'_>, index: u16, values: &mut Vec<(Multiplexer, Vec<u8>)>) {
    let Some(first) = value_of(bench, Multiplexer::new(index, 0)) else { return };
    let highest = if let [highest] = first[..] { highest } else { 0 };
    values.push((Multiplexer::new(index, 0), first));
    for sub in 1..=highest.min(MOST_SUBS) {
        let multiplexer = Multiplexer::new(index, sub);
        match value_of(bench, multiplexer) {
            Some(value) => values.push((multiplexer, value)),
            // Sub-index 0 holds one byte that is no count.
            None => break,
        }
    }
}

pub(super) fn value_of(bench: &mut Bench<'_>, multiplexer: Multiplexer) -> Option<Vec<u8>> {
    match bench.upload(multiplexer).ok()?.outcome {
        Outcome::Uploaded(value) => Some(value),
        _ => None,
    }
}

/// Compares all objects with their values before the run, and writes back settings that differ: the first reset lost
/// values that were not stored. `bus` is the name of the bus in the user's commands.
///
/// Works after Ctrl-C too.
pub(crate) fn put_back_dictionary(bench: &mut Bench<'_>, bus: &str, before: &[(Multiplexer, Vec<u8>)]) -> Comparison {
    bench.uncancelled(|bench| bench.undisturbed(|bench| put_back_settings(bench, bus, before)))
}

fn put_back_settings(bench: &mut Bench<'_>, bus: &str, before: &[(Multiplexer, Vec<u8>)]) -> Comparison {
    if !answers_at_last(bench) {
        return Comparison { objects: before.len(), ..Comparison::default() };
    }
    let mut changes = changes_since(bench, before);
    if changes.iter().any(|change| is_put_back(bench, change.multiplexer)) {
        let configured = before.iter().filter(|(multiplexer, _)| is_put_back(bench, *multiplexer));
        let originals: Vec<Download> = configured.map(Download::from).collect();
        rewrite::write_back(bench, &originals);
        changes = changes_since(bench, before);
    }
    compared(bench, bus, before, changes)
}

fn compared(
    bench: &mut Bench<'_>,
    bus: &str,
    before: &[(Multiplexer, Vec<u8>)],
    mut changes: Vec<Change>,
) -> Comparison {
    changes.extend(restore::left_behind(bench, &changes));
    changes.sort_by_key(|change| change.multiplexer);
    // If the device has left the bus meanwhile, its objects have not disappeared.
    let is_complete = matches!(bench.answers(), Ok(true));
    let appeared = changes.iter().filter(|change| change.before.is_none()).count();
    let commands = restore::commands(bench, bus, before, &changes, &[]);
    Comparison { is_complete, objects: before.len() + appeared, changes, commands, ..Comparison::default() }
}

/// The changes that a second reading of the whole dictionary shows.
fn changes_since(bench: &mut Bench<'_>, before: &[(Multiplexer, Vec<u8>)]) -> Vec<Change> {
    let mut after: BTreeMap<Multiplexer, Vec<u8>> = dump(bench).into_iter().collect();
    let mut changes: Vec<Change> = Vec::new();
    for (multiplexer, value) in before {
        let mut now = after.remove(multiplexer);
        if now.is_none() {
            now = bench.value_at_last(*multiplexer).ok().flatten();
        }
        if now.as_ref() != Some(value) {
            changes.push(change(bench, *multiplexer, Some(value.clone()), now));
        }
    }
    changes.extend(after.into_iter().map(|(multiplexer, now)| change(bench, multiplexer, None, Some(now))));
    changes.iter_mut().for_each(|change| see_whether_it_moves(bench, change));
    changes
}

pub(super) fn change(
    bench: &Bench<'_>,
    multiplexer: Multiplexer,
    before: Option<Vec<u8>>,
    after: Option<Vec<u8>>,
) -> Change {
    let entry = described(bench, multiplexer);
    let name = entry.map(|entry| entry.name.clone());
    let profile = bench.target.description.as_ref().and_then(DeviceDescription::device_profile);
    let standard = || names::object_name(multiplexer, profile)?.entry?.data_type;
    let data_type = entry.map(|entry| entry.data_type).or_else(standard);
    Change { multiplexer, name, data_type, nature: nature(bench, multiplexer), before, after }
}

/// The described entry; `None` without a description, or if the description lacks it.
pub(super) fn described<'b>(bench: &'b Bench<'_>, at: Multiplexer) -> Option<&'b Entry> {
    bench.target.description.as_ref()?.dictionary.entry(at).ok()
}

/// How the value of an object can change.
pub(super) fn nature(bench: &Bench<'_>, at: Multiplexer) -> Nature {
    let is_constant = described(bench, at).is_some_and(|entry| entry.access == Access::Const);
    match at.index.0 {
        _ if is_put_back(bench, at) => Nature::Setting,
        object::DEVICE_TYPE | object::MANUFACTURER_DEVICE_NAME..=object::MANUFACTURER_SOFTWARE_VERSION | IDENTITY => {
            Nature::Constant
        }
        _ if is_constant || profile::is_scaling(bench, at) => Nature::Constant,
        _ if is_commanded(bench, at) => Nature::Acting,
        _ => Nature::Own,
    }
}

/// Whether the object acts when it is written, and keeps the value of the last write: a preset or another command.
/// Histories, signatures and clocks have values of their own.
fn is_commanded(bench: &Bench<'_>, at: Multiplexer) -> bool {
    let described = bench.target.description.as_ref();
    let entry = described.and_then(|description| description.dictionary.entry(at).ok());
    let is_written = entry.is_none_or(|entry| entry.access.is_writable());
    is_written && matches!(bench.acting(at), Some(Acting::Commands | Acting::MovesZeroPoint))
}

/// Attributes a value that differs between two readings to the device itself, whatever its description says.
pub(super) fn see_whether_it_moves(bench: &mut Bench<'_>, change: &mut Change) {
    if change.is_left() && change.after.is_some() && value_of(bench, change.multiplexer) != change.after {
        change.nature = Nature::Own;
    }
}

/// Whether the device answers, even if it is still starting: the tester repeats a reset that was interrupted, and the
/// boot-up message of the first reset does not prove that the second start is over.
fn answers_at_last(bench: &mut Bench<'_>) -> bool {
    (0..3).any(|_| {
        let answers = matches!(bench.answers(), Ok(true));
        if !answers {
            // A failure of the bus here shows in the next attempt.
            let _ = bench.listen(bench.timing().boot_up);
        }
        answers
    })
}

/// Whether a run must leave an object as it was, because the object is configuration.
pub(super) fn is_put_back(bench: &Bench<'_>, multiplexer: Multiplexer) -> bool {
    let described = bench.target.description.is_some() && bench.is_described_as_writable(multiplexer);
    (described || is_configuration(multiplexer)) && !bench.acts(multiplexer)
}

/// Whether an object changes on any device only when it is written.
const fn is_configuration(multiplexer: Multiplexer) -> bool {
    matches!(
        multiplexer.index.0,
        object::COB_ID_SYNC..=object::SYNCHRONOUS_WINDOW_LENGTH
            | object::GUARD_TIME
            | object::LIFE_TIME_FACTOR
            | object::COB_ID_TIME..=object::PRODUCER_HEARTBEAT_TIME
            | object::SYNCHRONOUS_COUNTER_OVERFLOW
            | object::ERROR_BEHAVIOR
            | 0x1200..=0x1BFF
    )
}
