//! Leaves the device as it was found.

use super::{Bench, dictionary, rewrite};
use crate::comparison::{Change, Nature};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::configuration::{Download, companions, is_cob_id, ordered};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::{Bytes, Outcome};
use canvass_traces::hex;

/// The object that stores all parameters.
pub(super) const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);

/// Brings a device back to its normal operation after a case that could not go on. The flag says whether the case
/// stored something.
pub type Rescue = fn(&mut Bench<'_>, bool) -> Result<(), Stop>;

impl Bench<'_> {
    /// Whether the device stores written values without a command: bit 1 of 1010h:01 (CiA 301, 7.5.2.13). A reset then
    /// brings no earlier value back. Only a value whose other bits are 0 says how the device stores (table 51): some
    /// devices return the value that was written last.
    ///
    /// # Errors
    /// A breach if 1010h:01 can't be read though it is there.
    pub fn stores_by_itself(&mut self) -> Result<bool, Stop> {
        Ok(self.has(STORE)? && matches!(self.read_number(STORE)?, 0b10 | 0b11))
    }

    /// Keeps the value of an object before it is written. An object that can't be read can't be put back.
    pub(super) fn remember(&mut self, multiplexer: Multiplexer) -> Result<(), Stop> {
        if self.changes.knows(multiplexer) || self.acts(multiplexer) {
            return Ok(());
        }
        // A PDO is switched off while its mapping is put back, and then on again: that needs its COB-ID, too.
        companions(multiplexer).into_iter().flatten().try_for_each(|companion| keep(self, companion))?;
        keep(self, multiplexer)
    }

    /// Runs `act` to its end even if the user has cancelled, so that putting the device back does not stop half-way.
    pub(crate) fn uncancelled<T>(&mut self, act: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.traffic.restoring, true);
        let result = act(self);
        self.traffic.restoring = before;
        result
    }

    /// Cleans up after a case that was cancelled or could not go on, and so has not run its own end. `rescue` restores
    /// the node-ID and bit rate; `settle_memory` restores the memory.
    pub fn end_early(&mut self, rescue: Option<Rescue>) {
        let stored = self.traffic.watch.has_stored();
        // A failure here shows in the comparison after the run.
        let _ = self.uncancelled(|bench| rescue.map_or(Ok(()), |rescue| rescue(bench, stored)));
    }

    /// Puts back the changes of the case, and earlier changes that could not be put back; also after a failure and
    /// after Ctrl-C. Values that the device refuses are kept for the next attempt.
    pub(super) fn restore(&mut self) {
        let originals = self.changes.take();
        // If the device has gone, no write can succeed: the bench tries again after the first case in which the device
        // is back.
        let unrestored = if self.knowledge.has_gone() {
            originals
        } else {
            self.uncancelled(|bench| put_back_values(bench, &originals))
        };
        self.changes.leave(unrestored);
    }
}

fn keep(bench: &mut Bench<'_>, multiplexer: Multiplexer) -> Result<(), Stop> {
    if !bench.changes.knows(multiplexer)
        && let Outcome::Uploaded(value) = bench.undisturbed(|bench| bench.upload(multiplexer))?.outcome
    {
        bench.changes.keep(Download { at: multiplexer, value })?;
    }
    Ok(())
}

fn put_back_values(bench: &mut Bench<'_>, originals: &[Download]) -> Vec<Download> {
    if !originals.is_empty()
        && let Err(stop) = wake(bench)
    {
        bench.note(format!("not restored: {}", stop.reason()));
    }
    let mut stuck = rewrite::write_back(bench, originals);
    // A measured value that has changed meanwhile is none that the tester has changed.
    stuck.retain(|original| !bench.changes_by_itself(original.at));
    // A reset brings back values that were not stored.
    if !stuck.is_empty() && bench.reset(Command::RESET_NODE).is_ok() {
        stuck = rewrite::write_back(bench, originals);
    }
    for Download { at: multiplexer, value } in &stuck {
        bench.note(format!("{multiplexer} could not be set back to {}", Bytes(value)));
    }
    stuck
}

/// Changes that cases could not put back and that are not in `known`: objects without a description.
pub(super) fn left_behind(bench: &mut Bench<'_>, known: &[Change]) -> Vec<Change> {
    let is_told = |original: &Download| known.iter().any(|change| change.multiplexer == original.at);
    let stuck: Vec<Download> =
        bench.changes.unrestored().iter().filter(|original| !is_told(original)).cloned().collect();
    let stuck = rewrite::write_back(bench, &stuck);
    let change = |Download { at: multiplexer, value }| {
        let after = dictionary::value_of(bench, multiplexer);
        Change { nature: Nature::Setting, ..dictionary::change(bench, multiplexer, Some(value), after) }
    };
    stuck.into_iter().map(change).collect()
}

/// The commands that give the device these values again, in an order in which it accepts them. Objects that act are
/// left out: writing them restores nothing.
///
/// `before`: the values that were in use. If `stored` differs from them, the memory comes first: a restart loads the
/// other stored values, so that the command to store changes only the values of `stored`. The values that were in use
/// are written afterwards.
pub(super) fn commands(
    bench: &Bench<'_>,
    bus: &str,
    before: &[(Multiplexer, Vec<u8>)],
    changes: &[Change],
    stored: &[Change],
) -> Vec<String> {
    let can_store = before.iter().any(|(multiplexer, _)| *multiplexer == STORE);
    if stored.is_empty() || !can_store {
        return writing(bench, bus, before, changes);
    }
    let known = bench.changes.baseline.stored.clone().unwrap_or_default();
    let known: Vec<(Multiplexer, Vec<u8>)> = known.into_iter().map(|one| (one.at, one.value)).collect();
    let mut commands = vec![format!("canvass nmt {} reset-node {}", quoted(bus), bench.node())];
    commands.extend(writing(bench, bus, &known, stored));
    commands.push(command_to_write(bench, bus, (STORE, b"save".to_vec())));
    let unlike = |(at, value): &&(Multiplexer, Vec<u8>)| known.iter().any(|(of, other)| of == at && other != value);
    let in_use =
        before.iter().filter(unlike).map(|(at, value)| dictionary::change(bench, *at, Some(value.clone()), None));
    let in_use: Vec<Change> = in_use.chain(changes.iter().cloned()).collect();
    commands.extend(writing(bench, bus, before, &in_use));
    commands
}

fn writing(bench: &Bench<'_>, bus: &str, before: &[(Multiplexer, Vec<u8>)], changes: &[Change]) -> Vec<String> {
    let settings = changes.iter().filter(|change| change.nature == Nature::Setting && !bench.acts(change.multiplexer));
    let mut originals: Vec<Download> = Vec::new();
    for change in settings {
        let known = originals.iter().any(|original| original.at == change.multiplexer);
        if let (false, Some(value)) = (known, change.before.clone()) {
            originals.push(Download { at: change.multiplexer, value });
        }
    }
    let companions: Vec<Multiplexer> =
        originals.iter().flat_map(|original| companions(original.at)).flatten().collect();
    for known in before.iter().filter(|(multiplexer, _)| companions.contains(multiplexer)).map(Download::from) {
        if !originals.iter().any(|original| original.at == known.at) {
            originals.push(known);
        }
    }
    let held: Vec<(Multiplexer, u32)> = settings_now(changes).collect();
    ordered(&originals, &held).into_iter().map(|write| command_to_write(bench, bus, (write.at, write.value))).collect()
}

fn command_to_write(bench: &Bench<'_>, bus: &str, (at, value): (Multiplexer, Vec<u8>)) -> String {
    let digits = hex::compact(&value).to_string();
    let digits = if digits.is_empty() { "''" } else { &digits };
    let (index, sub) = (at.index.0, at.sub.0);
    format!("canvass sdo write {} {} {index:04X}:{sub:02X} {digits} --type bytes", quoted(bus), bench.node())
}

/// Brings a stopped device to pre-operational: only in stopped an SDO server must not answer.
fn wake(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if !bench.answers()? {
        bench.command(Command::ENTER_PRE_OPERATIONAL)?;
        bench.listen(bench.timing().reaction)?;
    }
    Ok(())
}

/// The current COB-IDs of the device that the run has changed.
fn settings_now(changes: &[Change]) -> impl Iterator<Item = (Multiplexer, u32)> {
    let cob_ids = changes.iter().filter(|change| is_cob_id(change.multiplexer));
    cob_ids.filter_map(|change| Some((change.multiplexer, super::sdo::number(change.after.as_ref()?))))
}

/// The name of a bus, quoted for a shell.
fn quoted(bus: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.:/@+,".contains(c);
    if !bus.is_empty() && bus.chars().all(is_plain) {
        bus.to_owned()
    } else {
        format!("'{}'", bus.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::Download;
    use crate::scripted::{table, with_bench};
    use canvass_analyzer::Multiplexer;
    use canvass_analyzer::object;
    use canvass_traces::Duration;

    #[test]
    fn a_device_that_is_gone_is_not_written_to_after_each_case() {
        let (took, left) = with_bench(table(&[]), |bench| {
            bench.knowledge.gone = Some("301/a/case");
            let multiplexer = Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0);
            bench.changes.keep(Download { at: multiplexer, value: vec![0, 0] }).unwrap();
            let begun = bench.now();
            bench.restore();
            bench.restore();
            (bench.now().since(begun), bench.changes.unrestored().to_vec())
        });
        assert_eq!(took, Duration::ZERO);
        let left: Vec<_> = left.into_iter().map(|Download { at: multiplexer, value }| (multiplexer, value)).collect();
        assert_eq!(
            left,
            [(Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), vec![0, 0])],
            "it is tried again once the device is back"
        );
    }
}
