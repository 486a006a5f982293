//! What the device was before the run: its values while nothing was reset, and what a start brings. What a run leaves is
//! compared with that.

use super::rewrite::Original;
use super::{Bench, dictionary, restore, rewrite, start};
use crate::behaviour::{Behaviour, Changed};
use crate::comparison::{Change, Comparison, Nature};
use crate::journal::Interrupted;
use crate::touch::Touch;
use crate::verdict::Stop;
use crate::zero_point::{Moved, ZeroPoint};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::Mode;
use canvass_traces::Duration;
use std::fmt;

/// After "save" was confirmed: some devices go on writing their memory, and a reset meanwhile would tear it.
const WRITTEN: Duration = Duration::from_millis(200);

/// What a reset would take from the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Harm {
    /// A zero point that may not be stored: the object that has moved it.
    ZeroPoint(Multiplexer),
    /// An object that a reset sets to its default, and only power-on brings back.
    Defaults(Multiplexer),
}

impl fmt::Display for Harm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ZeroPoint(at) => write!(
                f,
                "its zero point was moved ({at}), and the first reset would lose one that is not stored: store it, and say so by \
                 --zero-point-stored"
            ),
            Self::Defaults(at) => write!(
                f,
                "its manual says that a reset sets {at} to its default until the next power-on, whatever is stored, and a run that \
                 is killed could not bring it back: give it its default before"
            ),
        }
    }
}

/// The device before the first case.
#[derive(Clone, Debug, Default)]
pub(crate) struct Baseline {
    /// Where the zero point was while nothing was reset.
    pub zero_point: Option<ZeroPoint>,
    /// What a start brings: settings that are stored, or the defaults. `None`: not known yet.
    pub stored: Option<Vec<Original>>,
    /// Of these, objects that a reset sets to their defaults and only power-on loads: what is stored does not show. The values
    /// that were in use are taken for it.
    pub unseen: Vec<Multiplexer>,
    /// Where the zero point is after a start.
    pub stored_zero_point: Option<ZeroPoint>,
    /// What the device does after a start.
    pub behaviour: Option<Behaviour>,
    /// Whether it was operational before the run, or becomes so in it: its behaviour is looked at there, too.
    pub has_operational: bool,
}

/// What is not in the device's memory as it was.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(crate) struct MemoryLeft {
    pub changes: Vec<Change>,
    pub zero_point: Option<Moved>,
    pub behaviour: Vec<Changed>,
}

impl Baseline {
    /// What the journal of an interrupted run tells.
    pub fn of(run: &Interrupted) -> Self {
        let stored: Vec<Original> = run.memory.iter().map(Original::from).collect();
        Self {
            zero_point: run.zero_point,
            stored: (!stored.is_empty()).then_some(stored),
            stored_zero_point: run.stored_zero_point,
            unseen: Vec::new(),
            behaviour: None,
            has_operational: run.operational,
        }
    }
}

impl Bench<'_> {
    /// Acts to the end, with leave to move a zero point back to where it was.
    pub(crate) fn with_leave_to_move<T>(&mut self, act: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.changes.moving_zero_point, true);
        let result = self.uncancelled(act);
        self.changes.moving_zero_point = before;
        result
    }
}

/// Looks where the zero point is, before anything is reset. `has_operational`: the device is operational at some time, before
/// the run or in it.
pub(crate) fn note_zero_point(bench: &mut Bench<'_>, has_operational: bool) {
    bench.changes.baseline.has_operational = has_operational;
    // A device that does not tell it has none that could be compared.
    bench.changes.baseline.zero_point = bench.unjudged(Bench::look_at_zero_point).ok().flatten();
}

/// Restarts the device once, and learns what a start brings: what it has stored. `known`: its objects.
///
/// # Errors
/// [`Stop::Inconclusive`] if the run was cancelled or the device does not start; [`Stop::Error`] if the journal can't be
/// written.
pub(crate) fn learn_memory(bench: &mut Bench<'_>, known: &[(Multiplexer, Vec<u8>)]) -> Result<(), Stop> {
    bench.unjudged(|bench| restart(bench))?;
    let mut stored = Vec::new();
    for (at, in_use) in known {
        if !dictionary::is_put_back(bench, *at) {
            continue;
        }
        let value = if is_unseen(bench, *at) {
            bench.changes.baseline.unseen.push(*at);
            Some(in_use.clone())
        } else {
            bench.unjudged(|bench| bench.value_at_last(*at))?
        };
        stored.extend(value.map(|value| Original { multiplexer: *at, value }));
    }
    bench.changes.baseline.stored_zero_point = bench.unjudged(Bench::look_at_zero_point).ok().flatten();
    bench.changes.learn_memory(stored)?;
    bench.changes.baseline.behaviour = Some(bench.unjudged(start::behaviour)?);
    Ok(())
}

/// Whether reset node gives an object its default, whatever is stored, as the manual of the device says; power-on does not.
pub(super) fn is_unseen(bench: &Bench<'_>, at: Multiplexer) -> bool {
    resets_to_defaults(bench) && !can_power_cycle(bench) && at.index.0 >= 0x6000
}

/// The start after which the device is left. Where reset node brings defaults, and not what is stored, only the supply helps.
///
/// # Errors
/// Those of the start.
pub(super) fn restart_at_last(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if resets_to_defaults(bench) { restart(bench) } else { bench.reset(Command::RESET_NODE) }
}

/// Whether reset node gives objects of the profile their defaults, as the manual of the device says; power-on does not.
fn resets_to_defaults(bench: &Bench<'_>) -> bool {
    bench.manual().is_some_and(|model| model.sheet().quirks.reset_node_restores_profile)
}

fn can_power_cycle(bench: &Bench<'_>) -> bool {
    may_store(bench) && bench.options.power_cycle.is_some()
}

/// A start as at power-on: by the user's own command where there is one, else by reset node.
fn restart(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let was_switched = can_power_cycle(bench) && bench.power_cycle()?;
    if was_switched { Ok(()) } else { bench.reset(Command::RESET_NODE) }
}

/// A case that may have stored has ended and its settings are put back: sees that the memory is as it was, and puts it back
/// where it is not.
pub(crate) fn settle_memory(bench: &mut Bench<'_>, touches: &[Touch]) {
    let stores = touches.iter().any(|touch| matches!(touch, Touch::Nvm | Touch::FactoryDefaults | Touch::Preset));
    let wrote = std::mem::take(&mut bench.changes.wrote_memory);
    let is_suspect = stores || bench.traffic.watch.has_stored() || wrote;
    if is_suspect && !bench.knowledge.has_gone() && bench.changes.baseline.stored.is_some() {
        let may_store = may_store(bench);
        let may_preset = bench.options.allow.contains(&Touch::Preset)
            && touches.iter().any(|touch| matches!(touch, Touch::Preset | Touch::FactoryDefaults));
        // What is left is told at the end of the run.
        let _ = bench.uncancelled(|bench| put_back_memory(bench, may_store, may_preset));
    }
}

/// Whether restoring the defaults would move the zero point, which only the leave to preset lets a case put back: it is not
/// that of the delivery, or the device does not tell.
pub(crate) fn would_lose_zero_point(bench: &Bench<'_>) -> bool {
    let moved = bench.changes.baseline.stored_zero_point.filter(|zero_point| !zero_point.is_as_delivered());
    let may_preset = bench.options.allow.contains(&Touch::Preset);
    moved.is_some_and(|zero_point| !(may_preset && zero_point.takes_position()))
}

/// Restarts the device, compares what that brings with what it brought before the run, and puts back what may be: settings
/// by writing and storing them, the zero point by a preset at rest.
pub(crate) fn put_back_memory(bench: &mut Bench<'_>, may_store: bool, may_preset: bool) -> Result<MemoryLeft, Stop> {
    bench.unjudged(|bench| {
        restart(bench)?;
        let mut left = memory_left(bench)?;
        // What does not show may have changed.
        if may_store && !(left.changes.is_empty() && bench.changes.baseline.unseen.is_empty()) {
            store_settings(bench)?;
            restart(bench)?;
            left = memory_left(bench)?;
        }
        if left.zero_point.is_some() && may_preset {
            left.zero_point = put_back_stored_zero_point(bench, may_store)?;
        }
        Ok(left)
    })
}

/// What a start has brought that is not as before the run. The device has just started.
fn memory_left(bench: &mut Bench<'_>) -> Result<MemoryLeft, Stop> {
    let mut changes = Vec::new();
    for original in bench.changes.baseline.stored.clone().unwrap_or_default() {
        if bench.changes.baseline.unseen.contains(&original.multiplexer) {
            continue;
        }
        let now = bench.value_at_last(original.multiplexer)?;
        if now.as_ref() != Some(&original.value) {
            let change = dictionary::change(bench, original.multiplexer, Some(original.value), now);
            changes.push(Change { nature: Nature::Setting, ..change });
        }
    }
    changes.iter_mut().for_each(|change| dictionary::see_whether_it_moves(bench, change));
    changes.retain(Change::is_left);
    let zero_point = match bench.changes.baseline.stored_zero_point {
        Some(before) => bench.look_at_zero_point()?.and_then(|now| before.moved(&now)),
        None => None,
    };
    let zero_point = zero_point.map(|moved| Moved { is_stored: true, ..moved });
    Ok(MemoryLeft { changes, zero_point, behaviour: Vec::new() })
}

fn put_back_stored_zero_point(bench: &mut Bench<'_>, may_store: bool) -> Result<Option<Moved>, Stop> {
    let Some(before) = bench.changes.baseline.stored_zero_point else { return Ok(None) };
    bench.put_back_zero_point(&before)?;
    // The other settings are those that are stored: the device has just started.
    if may_store {
        save(bench)?;
    }
    restart(bench)?;
    let now = bench.look_at_zero_point()?;
    Ok(now.and_then(|now| before.moved(&now)).map(|moved| Moved { is_stored: true, ..moved }))
}

/// Writes the settings that a start brought before the run, and stores them.
fn store_settings(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let originals = bench.changes.baseline.stored.clone().unwrap_or_default();
    rewrite::write_back(bench, &originals);
    save(bench)
}

fn save(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if bench.has(super::restore::STORE)? {
        // A device that refuses it shows that in what the next start brings.
        bench.download_as(super::restore::STORE, b"save", Mode::Shortest)?;
        bench.listen(WRITTEN)?;
    }
    Ok(())
}

/// The run is over: sees what the memory holds, gives the device the values again that it had, and compares all of it.
pub(crate) fn put_back_device(
    bench: &mut Bench<'_>,
    bus: &str,
    operational: bool,
    before: &[(Multiplexer, Vec<u8>)],
) -> Comparison {
    let memory = match bench.changes.baseline.stored {
        // What fails here shows in the dictionary.
        // Each case has put back what it stored: what is left here was stored unasked.
        Some(_) => {
            let may_store = may_store(bench) && (bench.stores() > 0 || !bench.changes.baseline.unseen.is_empty());
            let left = bench.uncancelled(|bench| put_back_memory(bench, may_store, false)).unwrap_or_default();
            MemoryLeft { behaviour: start::changed_behaviour(bench), ..left }
        }
        None => MemoryLeft::default(),
    };
    bench.leave(operational);
    let comparison = dictionary::put_back_dictionary(bench, bus, before);
    with_memory(bench, comparison, bus, before, memory)
}

fn may_store(bench: &Bench<'_>) -> bool {
    bench.options.allow.contains(&Touch::Nvm)
}

/// The whole comparison: what is in use, what is stored, and the zero point of both.
pub(crate) fn with_memory(
    bench: &mut Bench<'_>,
    comparison: Comparison,
    bus: &str,
    before: &[(Multiplexer, Vec<u8>)],
    memory: MemoryLeft,
) -> Comparison {
    if !comparison.is_complete {
        return comparison;
    }
    let zero_points: Vec<Moved> = moved_in_use(bench).into_iter().chain(memory.zero_point).collect();
    let commands = restore::commands(bench, bus, before, &comparison.changes, &memory.changes);
    Comparison { stored: memory.changes, zero_points, behaviour: memory.behaviour, commands, ..comparison }
}

/// By how much the zero point is moved that was in use before the run.
fn moved_in_use(bench: &mut Bench<'_>) -> Option<Moved> {
    let before = bench.changes.baseline.zero_point?;
    // Whether the device answers is told apart from this.
    let now = bench.uncancelled(|bench| bench.unjudged(Bench::look_at_zero_point)).ok().flatten()?;
    before.moved(&now)
}

/// Why a reset, with which each case begins, would take something from the device that no case puts back; `None`: it would
/// not, as far as is known.
pub(crate) fn harm_of_a_reset(bench: &mut Bench<'_>, known: &[(Multiplexer, Vec<u8>)]) -> Option<Harm> {
    let zero_point = bench.changes.baseline.zero_point.filter(|_| !bench.options.zero_point_is_stored);
    if let Some(zero_point) = zero_point.filter(|zero_point| !zero_point.is_as_delivered()) {
        let is_stored = bench.stores_at_once(zero_point.preset());
        if !is_stored {
            return Some(Harm::ZeroPoint(zero_point.preset()));
        }
    }
    let is_default = |at: Multiplexer, value: &[u8]| {
        let description = bench.target.description.as_ref();
        let entry = description.and_then(|description| description.dictionary.entry(at).ok());
        let default = entry.and_then(|entry| entry.start_value(bench.target.node)?.encode(entry.data_type).ok());
        default.is_none_or(|default| default == value)
    };
    // Also where the supply can be switched: who puts back after a run that was killed can't switch it.
    let is_lost =
        |at: Multiplexer| resets_to_defaults(bench) && at.index.0 >= 0x6000 && dictionary::is_put_back(bench, at);
    let lost = known.iter().find(|(at, value)| is_lost(*at) && !is_default(*at, value));
    lost.map(|(at, _)| Harm::Defaults(*at))
}
