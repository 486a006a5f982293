//! The device is left as it was found.

use super::Bench;
use super::rewrite::{Original, companions};
use crate::case::{Case, Touch};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::{Bytes, Mode, Outcome};
use canvass_bus::observation::Subject;

/// Writing these makes something happen (clears the error history, stores, restores, sets the clock, moves the position);
/// there is no value to put back. Cases that move the position put it back themselves.
pub(super) const fn is_trigger(multiplexer: Multiplexer) -> bool {
    matches!(multiplexer.index.0, 0x1003 | 0x1010 | 0x1011 | 0x1013 | 0x6003 | 0x6009)
}

impl Bench<'_> {
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
        if !known && let Outcome::Uploaded(value) = self.upload(multiplexer)?.outcome {
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

    /// Cleans up after a case that was cancelled, or could not go on: it has not come to what it does at its end. The
    /// node-ID and bit rate are the device's own again; what is stored follows in [`Bench::finish`].
    pub(crate) fn rescue(&mut self, case: &Case) {
        self.ended_early = true;
        let touches = case.touches.iter().any(|touch| matches!(touch, Touch::NodeId | Touch::BitRate | Touch::Nvm));
        let stored = self.watch.has_stored();
        let rescue = case.needs.iter().find_map(|need| need.rescue()).filter(|_| touches);
        // What can fail here shows in the answers of the device, which are compared after the run.
        let _ = self.uncancelled(|bench| rescue.map_or(Ok(()), |rescue| rescue(bench, stored)));
    }

    /// The values that are in use again are also those that are stored, if the case stored others.
    pub(super) fn store_again(&mut self) {
        const STORE: Multiplexer = Multiplexer::new(0x1010, 1);
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

    /// What the run could not put back, each with the command that would.
    pub(crate) fn left_behind(&self) -> Vec<String> {
        let node = self.node();
        let command = |original: &Original| {
            let Original { multiplexer, value } = original;
            let digits: String = value.iter().map(|byte| format!("{byte:02X}")).collect();
            let (index, sub) = (multiplexer.index.0, multiplexer.sub.0);
            format!(
                "{multiplexer} could not be set back; `canvass sdo write BUS {node} {index:04X}:{sub:02X} {digits} --type bytes` \
                 would do it"
            )
        };
        self.unrestored.iter().map(command).collect()
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
