//! The device is left as it was found.

use super::Bench;
use super::rewrite::{Original, companions, is_cob_id, writes};
use crate::comparison::{Change, Nature};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::object::encoder;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::{Bytes, Mode, Outcome};
use canvass_bus::observation::Subject;
use canvass_traces::hex;

/// Writing these makes something happen (clears the error history, stores, restores, sets the clock, moves the position);
/// there is no value to put back. Cases that move the position put it back themselves.
pub(super) const fn is_trigger(multiplexer: Multiplexer) -> bool {
    matches!(
        multiplexer.index.0,
        object::PREDEFINED_ERROR_FIELD
            | object::STORE_PARAMETERS
            | object::RESTORE_DEFAULT_PARAMETERS
            | object::HIGH_RESOLUTION_TIME_STAMP
            | encoder::PRESET_VALUE
            | encoder::HIGH_PRECISION_PRESET
    )
}

/// Stores all parameters.
pub(super) const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);

/// What puts a device right after a case that could not go on; `true` if the case stored something.
pub type Rescue = fn(&mut Bench<'_>, bool) -> Result<(), Stop>;

impl Bench<'_> {
    /// Whether the device stores what is written without a command: bit 1 of 1010h:01 (CiA 301, 7.5.2.13). A reset then brings
    /// no earlier value back. Only a value whose other bits are 0 says how the device stores (table 51): some give back what
    /// was written last.
    ///
    /// # Errors
    /// A breach if 1010h:01 can't be read though it is there.
    pub fn stores_by_itself(&mut self) -> Result<bool, Stop> {
        Ok(self.has(STORE)? && matches!(self.read_number(STORE)?, 0b10 | 0b11))
    }

    /// Keeps the value of an object that is about to be written. What can't be read can't be put back.
    pub(super) fn remember(&mut self, multiplexer: Multiplexer) -> Result<(), Stop> {
        let known = self.changes.iter().any(|change| change.multiplexer == multiplexer);
        if known || is_trigger(multiplexer) {
            return Ok(());
        }
        // A PDO is switched off before its mapping is put back, and on again: its COB-ID is needed, too.
        companions(multiplexer).into_iter().flatten().try_for_each(|companion| self.keep(companion))?;
        self.keep(multiplexer)
    }

    fn keep(&mut self, multiplexer: Multiplexer) -> Result<(), Stop> {
        let known = self.changes.iter().any(|change| change.multiplexer == multiplexer);
        if !known && let Outcome::Uploaded(value) = self.undisturbed(|bench| bench.upload(multiplexer))?.outcome {
            self.journal_value(multiplexer, &value)?;
            self.changes.push(Original { multiplexer, value });
        }
        Ok(())
    }

    /// Acts to the end, even if the user has cancelled: what a case puts back is not left half-way.
    pub(crate) fn uncancelled<T>(&mut self, act: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.restoring, true);
        let result = act(self);
        self.restoring = before;
        result
    }

    /// Notes that the case was cancelled, or could not go on: it has not come to what it does at its end. What it stored
    /// is put right in [`Bench::finish`], its node-ID and bit rate by `rescue`.
    pub(crate) fn end_early(&mut self, rescue: Option<Rescue>) {
        self.ended_early = true;
        let stored = self.watch.has_stored();
        // What can fail here shows in the answers of the device, which are compared after the run.
        let _ = self.uncancelled(|bench| rescue.map_or(Ok(()), |rescue| rescue(bench, stored)));
    }

    /// The values that are in use again are also those that are stored, if the case stored others.
    pub(super) fn store_again(&mut self) {
        if !self.watch.has_stored() {
            return;
        }
        self.uncancelled(|bench| {
            if matches!(bench.answers(), Ok(true)) && matches!(bench.has(STORE), Ok(true)) {
                // A device that refuses it has refused the case's own, too.
                let _ = bench.download_as(STORE, b"save", Mode::Shortest);
                let _ = bench.listen(bench.timing().reaction);
            }
        });
    }

    /// Puts back what the case changed, and what could not be put back before; also after a failure and after Ctrl-C. What
    /// the device does not have again is kept: it is tried anew after the next case, and told at the end of the run.
    pub(super) fn restore(&mut self) {
        let before = std::mem::replace(&mut self.restoring, true);
        let mut originals = std::mem::take(&mut self.unrestored);
        for change in std::mem::take(&mut self.changes) {
            if !originals.iter().any(|known| known.multiplexer == change.multiplexer) {
                originals.push(change);
            }
        }
        if self.has_gone() {
            // There is nobody to write to: it is tried after the first case in which the device is back.
            self.unrestored = originals;
            self.restoring = before;
            return;
        }
        if !originals.is_empty()
            && let Err(stop) = self.wake()
        {
            self.notes.push(format!("not restored: {}", stop.reason()));
        }
        let mut stuck = self.write_back(&originals);
        // What was not stored is back after a reset.
        if !stuck.is_empty() && self.reset(Command::RESET_NODE).is_ok() {
            stuck = self.write_back(&originals);
        }
        for Original { multiplexer, value } in &stuck {
            self.notes.push(format!("{multiplexer} could not be set back to {}", Bytes(value)));
        }
        self.unrestored = stuck;
        self.restoring = before;
    }

    /// Whether an earlier case has left an object behind with a value that is not the device's own.
    pub(crate) fn is_left_behind(&self, subject: Subject) -> bool {
        self.unrestored.iter().any(|original| subject.covers(original.multiplexer.into()))
    }

    /// What cases could not put back and the dictionary does not show: objects that nobody described.
    pub(super) fn left_behind(&mut self, known: &[Change]) -> Vec<Change> {
        let is_told = |original: &Original| known.iter().any(|change| change.multiplexer == original.multiplexer);
        let stuck: Vec<Original> = self.unrestored.iter().filter(|original| !is_told(original)).cloned().collect();
        let stuck = self.write_back(&stuck);
        let change = |Original { multiplexer, value }| {
            let after = self.value_of(multiplexer);
            Change { nature: Nature::Setting, ..self.change(multiplexer, Some(value), after) }
        };
        stuck.into_iter().map(change).collect()
    }

    /// The commands that would write these values back, each object's before those that can only follow it.
    pub(super) fn commands(&self, bus: &str, before: &[(Multiplexer, Vec<u8>)], changes: &[Change]) -> Vec<String> {
        let settings = changes.iter().filter(|change| change.nature == Nature::Setting);
        let mut originals: Vec<Original> = settings
            .filter_map(|change| Some(Original { multiplexer: change.multiplexer, value: change.before.clone()? }))
            .collect();
        let companions: Vec<Multiplexer> =
            originals.iter().flat_map(|original| companions(original.multiplexer)).flatten().collect();
        for known in before.iter().filter(|(multiplexer, _)| companions.contains(multiplexer)).map(Original::from) {
            if !originals.iter().any(|original| original.multiplexer == known.multiplexer) {
                originals.push(known);
            }
        }
        let node = self.node();
        let command = |(at, value): (Multiplexer, Vec<u8>)| {
            let digits = hex::compact(&value).to_string();
            let digits = if digits.is_empty() { "''" } else { &digits };
            format!(
                "canvass sdo write {} {node} {:04X}:{:02X} {digits} --type bytes",
                quoted(bus),
                at.index.0,
                at.sub.0
            )
        };
        let held: Vec<(Multiplexer, u32)> = settings_now(changes).collect();
        let mut commands: Vec<String> = writes(&originals, &held).into_iter().map(command).collect();
        let has_store = before.iter().any(|(multiplexer, _)| *multiplexer == STORE);
        if !commands.is_empty() && self.stores() > 0 && has_store {
            // What is wrong may be what is stored.
            commands.push(command((STORE, b"save".to_vec())));
        }
        commands
    }

    /// Only in stopped the SDO server must not answer.
    fn wake(&mut self) -> Result<(), Stop> {
        if !self.answers()? {
            self.command(Command::ENTER_PRE_OPERATIONAL)?;
            self.listen(self.timing().reaction)?;
        }
        Ok(())
    }
}

/// The COB-IDs that the device has now, where a run has changed them.
fn settings_now(changes: &[Change]) -> impl Iterator<Item = (Multiplexer, u32)> {
    let cob_ids = changes.iter().filter(|change| is_cob_id(change.multiplexer));
    cob_ids.filter_map(|change| Some((change.multiplexer, super::sdo::number(change.after.as_ref()?))))
}

/// A bus as it can be typed into a shell.
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
    use super::Original;
    use crate::scripted::{table, with_bench};
    use canvass_analyzer::Multiplexer;
    use canvass_analyzer::object;
    use canvass_traces::Duration;

    #[test]
    fn a_device_that_is_gone_is_not_written_to_after_each_case() {
        let (took, left) = with_bench(table(&[]), |bench| {
            bench.gone = Some("301/a/case");
            bench.changes.push(Original {
                multiplexer: Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0),
                value: vec![0, 0],
            });
            let begun = bench.now();
            bench.restore();
            bench.restore();
            (bench.now().since(begun), bench.unrestored.clone())
        });
        assert_eq!(took, Duration::ZERO);
        let left: Vec<_> = left.into_iter().map(|Original { multiplexer, value }| (multiplexer, value)).collect();
        assert_eq!(
            left,
            [(Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), vec![0, 0])],
            "it is tried again once the device is back"
        );
    }
}
