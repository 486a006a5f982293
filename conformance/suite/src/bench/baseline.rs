//! The device before the run: the values in use, and the values that a start loads. At the end the tester compares the
//! device with them.

use super::{Bench, dictionary, restore, rewrite, start};
use crate::behaviour::{Behaviour, Changed};
use crate::comparison::{Change, Comparison, Nature};
use crate::journal::Interrupted;
use crate::touch::Touch;
use crate::verdict::Stop;
use crate::zero_point::{Moved, ZeroPoint};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::configuration::Download;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::Mode;
use canvass_traces::Duration;
use std::fmt;

/// Wait after the confirmation of "save": some devices go on writing their memory, and a reset would interrupt that.
const WRITTEN: Duration = Duration::from_millis(200);

/// A loss that a reset of the device would cause.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Harm {
    /// A zero point that may not be stored, named by the object that moved it.
    ZeroPoint(Multiplexer),
    /// An object that a reset sets to its default. Only power-on loads its stored value.
    Defaults(Multiplexer),
}

impl fmt::Display for Harm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ZeroPoint(at) => write!(
                f,
                "its zero point was moved ({at}), and the first reset would lose a zero point that is not stored: \
                 store it, and confirm that with --zero-point-stored"
            ),
            Self::Defaults(at) => write!(
                f,
                "its manual says that a reset sets {at} to its default until the next power-on, even if \
                 another value is stored: set {at} to its default before the test, as a run that is killed can't \
                 restore it"
            ),
        }
    }
}

/// The device before the first case.
#[derive(Clone, Debug, Default)]
pub(crate) struct Baseline {
    /// The zero point in use before the first reset.
    pub zero_point: Option<ZeroPoint>,
    /// The values after a start: stored settings or defaults. `None` if they are not known yet.
    pub stored: Option<Vec<Download>>,
    /// Objects in `stored` that a reset sets to their defaults and that only power-on loads: their stored values can't
    /// be read. The tester assumes the values that were in use.
    pub unseen: Vec<Multiplexer>,
    /// The zero point after a start.
    pub stored_zero_point: Option<ZeroPoint>,
    /// The behaviour of the device after a start.
    pub behaviour: Option<Behaviour>,
    /// Whether the device was operational before the run, or becomes operational in it. If so, its behaviour in
    /// operational is compared too.
    pub has_operational: bool,
}

/// The differences between the device's memory and its memory before the run.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(crate) struct MemoryLeft {
    pub changes: Vec<Change>,
    pub zero_point: Option<Moved>,
    pub behaviour: Vec<Changed>,
}

impl Baseline {
    /// The baseline that the journal of an interrupted run holds.
    pub fn of(run: &Interrupted) -> Self {
        let stored: Vec<Download> = run.memory.iter().map(Download::from).collect();
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
    /// Runs `act` with the permission to move a zero point back to its place.
    pub(crate) fn with_leave_to_move<T>(&mut self, act: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.changes.moving_zero_point, true);
        let result = self.uncancelled(act);
        self.changes.moving_zero_point = before;
        result
    }
}

/// Reads the zero point before the first reset. `has_operational`: the device is operational before the run or in it.
pub(crate) fn note_zero_point(bench: &mut Bench<'_>, has_operational: bool) {
    bench.changes.baseline.has_operational = has_operational;
    // A device that does not show its zero point has none that could be compared.
    bench.changes.baseline.zero_point = bench.unjudged(Bench::look_at_zero_point).ok().flatten();
}

/// Restarts the device once, and reads the values that a start loads from its memory. `known`: the objects of
/// the device with the values in use.
///
/// # Errors
/// [`Stop::Inconclusive`] if the run was cancelled or the device does not start; [`Stop::Error`] if the journal can't
/// be written.
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
        stored.extend(value.map(|value| Download { at: *at, value }));
    }
    bench.changes.baseline.stored_zero_point = bench.unjudged(Bench::look_at_zero_point).ok().flatten();
    bench.changes.learn_memory(stored)?;
    bench.changes.baseline.behaviour = Some(bench.unjudged(start::behaviour)?);
    Ok(())
}

/// Whether reset node sets an object to its default although another value is stored, according to the manual of the
/// device. Power-on loads the stored value.
pub(super) fn is_unseen(bench: &Bench<'_>, at: Multiplexer) -> bool {
    resets_to_defaults(bench) && !can_power_cycle(bench) && at.index.0 >= 0x6000
}

/// Starts the device for the last time. If reset node loads defaults instead of the stored values, only switching the
/// supply loads these.
///
/// # Errors
/// The errors of [`Bench::reset`] and [`Bench::power_cycle`].
pub(super) fn restart_at_last(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if resets_to_defaults(bench) { restart(bench) } else { bench.reset(Command::RESET_NODE) }
}

/// Whether reset node sets objects of the profile to their defaults, according to the manual of the device; power-on
/// does not.
fn resets_to_defaults(bench: &Bench<'_>) -> bool {
    bench.manual().is_some_and(|model| model.sheet().quirks.reset_node_restores_profile)
}

fn can_power_cycle(bench: &Bench<'_>) -> bool {
    may_store(bench) && bench.options.power_cycle.is_some()
}

/// Starts the device as at power-on: by the user's own command if there is one, otherwise by reset node.
fn restart(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let was_switched = can_power_cycle(bench) && bench.power_cycle()?;
    if was_switched { Ok(()) } else { bench.reset(Command::RESET_NODE) }
}

/// Ends a case that may have stored values, after its settings are put back: checks the memory and puts it back if it
/// has changed.
pub(crate) fn settle_memory(bench: &mut Bench<'_>, touches: &[Touch]) {
    let stores = touches.iter().any(|touch| matches!(touch, Touch::Nvm | Touch::FactoryDefaults | Touch::Preset));
    let wrote = std::mem::take(&mut bench.changes.wrote_memory);
    let is_suspect = stores || bench.traffic.watch.has_stored() || wrote;
    if is_suspect && !bench.knowledge.has_gone() && bench.changes.baseline.stored.is_some() {
        let may_store = may_store(bench);
        let may_preset = bench.options.allow.contains(&Touch::Preset)
            && touches.iter().any(|touch| matches!(touch, Touch::Preset | Touch::FactoryDefaults));
        // The end of the run reports the differences that remain.
        let _ = bench.uncancelled(|bench| put_back_memory(bench, may_store, may_preset));
    }
}

/// Whether restoring the defaults would lose the zero point: it is not as delivered, and either the user has not
/// allowed presets, or a preset can't put it back from every position.
pub(crate) fn would_lose_zero_point(bench: &Bench<'_>) -> bool {
    let moved = bench.changes.baseline.stored_zero_point.filter(|zero_point| !zero_point.is_as_delivered());
    let may_preset = bench.options.allow.contains(&Touch::Preset);
    moved.is_some_and(|zero_point| !(may_preset && zero_point.takes_position()))
}

/// Restarts the device, compares the loaded values with those before the run, and puts back the values that the
/// user allows: settings by writing and storing them, the zero point by a preset at rest.
pub(crate) fn put_back_memory(bench: &mut Bench<'_>, may_store: bool, may_preset: bool) -> Result<MemoryLeft, Stop> {
    bench.unjudged(|bench| {
        restart(bench)?;
        let mut left = memory_left(bench)?;
        // Values that can't be read may have changed. Some devices use restored defaults until power-off and do not
        // store them, which hides the values that a case has stored before.
        let is_hidden = bench.traffic.watch.has_loaded() || !bench.changes.baseline.unseen.is_empty();
        if may_store && (is_hidden || !left.changes.is_empty()) {
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

/// The differences between the values after this start and those before the run. The device has just started.
fn memory_left(bench: &mut Bench<'_>) -> Result<MemoryLeft, Stop> {
    let mut changes = Vec::new();
    for original in bench.changes.baseline.stored.clone().unwrap_or_default() {
        if bench.changes.baseline.unseen.contains(&original.at) {
            continue;
        }
        let now = bench.value_at_last(original.at)?;
        if now.as_ref() != Some(&original.value) {
            let change = dictionary::change(bench, original.at, Some(original.value), now);
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
    // The device has just started, so all other settings have their stored values.
    if may_store {
        save(bench)?;
    }
    restart(bench)?;
    let now = bench.look_at_zero_point()?;
    Ok(now.and_then(|now| before.moved(&now)).map(|moved| Moved { is_stored: true, ..moved }))
}

/// Writes the settings that a start loaded before the run, and stores them.
fn store_settings(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let originals = bench.changes.baseline.stored.clone().unwrap_or_default();
    rewrite::write_back(bench, &originals);
    save(bench)
}

fn save(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if bench.has(super::restore::STORE)? {
        // If the device refuses, the values after the next start show it.
        bench.download_as(super::restore::STORE, b"save", Mode::Shortest)?;
        bench.listen(WRITTEN)?;
    }
    Ok(())
}

/// Ends the run: reads the memory, writes back the values from before the run, and compares all of them.
pub(crate) fn put_back_device(
    bench: &mut Bench<'_>,
    bus: &str,
    operational: bool,
    before: &[(Multiplexer, Vec<u8>)],
) -> Comparison {
    let memory = match bench.changes.baseline.stored {
        // A failure here shows in the comparison of the dictionary.
        // Each case has put back the values that it stored: any remaining value was stored without a command.
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

/// Compares the values in use, the stored values, and both zero points.
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

/// The distance between the zero point in use now and the one before the run.
fn moved_in_use(bench: &mut Bench<'_>) -> Option<Moved> {
    let before = bench.changes.baseline.zero_point?;
    // The comparison states separately whether the device answers.
    let now = bench.uncancelled(|bench| bench.unjudged(Bench::look_at_zero_point)).ok().flatten()?;
    before.moved(&now)
}

/// The loss that the reset at the begin of each case would cause, and that no case puts right; `None` if no loss is
/// known.
pub fn harm_of_a_reset(bench: &mut Bench<'_>, known: &[(Multiplexer, Vec<u8>)]) -> Option<Harm> {
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
    // The loss is assumed even if the supply can be switched: after a killed run, `restore` can't switch it.
    let is_lost =
        |at: Multiplexer| resets_to_defaults(bench) && at.index.0 >= 0x6000 && dictionary::is_put_back(bench, at);
    let lost = known.iter().find(|(at, value)| is_lost(*at) && !is_default(*at, value));
    lost.map(|(at, _)| Harm::Defaults(*at))
}
