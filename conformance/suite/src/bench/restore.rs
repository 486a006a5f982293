//! The device is left as it was found.

use super::Bench;
use crate::case::{Case, Touch};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::{Bytes, Mode, Outcome};

/// A value as it was before the case wrote to it.
#[derive(Debug)]
pub struct Change {
    multiplexer: Multiplexer,
    original: Vec<u8>,
}

/// Writing these makes something happen (clears the error history, stores, restores, moves the position); there is no value
/// to put back. Cases that move the position put it back themselves.
pub(super) const fn is_trigger(multiplexer: Multiplexer) -> bool {
    matches!(multiplexer.index.0, 0x1003 | 0x1010 | 0x1011 | 0x6003 | 0x6009)
}

impl Bench<'_> {
    /// Keeps the value of an object that is about to be written. What can't be read can't be put back.
    pub(super) fn remember(&mut self, multiplexer: Multiplexer) -> Result<(), Stop> {
        let known = self.changes.iter().any(|change| change.multiplexer == multiplexer);
        if known || is_trigger(multiplexer) {
            return Ok(());
        }
        if let Outcome::Uploaded(original) = self.upload(multiplexer)?.outcome {
            self.changes.push(Change { multiplexer, original });
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

    /// Puts back what the case changed, the last change first; also after a failure and after Ctrl-C.
    pub(super) fn restore(&mut self) {
        let before = std::mem::replace(&mut self.restoring, true);
        let changes = std::mem::take(&mut self.changes);
        if !changes.is_empty()
            && let Err(verdict) = self.wake()
        {
            self.notes.push(format!("not restored: {}", verdict.reason()));
        }
        let mut stuck: Vec<Change> =
            changes.into_iter().rev().filter(|change| self.put_back(change).is_some()).collect();
        // Some values can only be written in a certain order, such as those of a PDO that is valid again by now. What
        // was not stored is back after a reset.
        if !stuck.is_empty() && self.reset(Command::RESET_NODE).is_ok() {
            stuck.retain(|change| self.put_back(change).is_some());
        }
        for change in stuck {
            let value = Bytes(&change.original);
            self.notes.push(format!("{} could not be set back to {value}", change.multiplexer));
        }
        self.restoring = before;
    }

    /// Only in stopped the SDO server must not answer.
    fn wake(&mut self) -> Result<(), Stop> {
        if !self.answers()? {
            self.command(Command::ENTER_PRE_OPERATIONAL)?;
            self.listen(self.timing().reaction)?;
        }
        Ok(())
    }

    /// What stands against it, if the value could not be put back.
    fn put_back(&mut self, change: &Change) -> Option<String> {
        let now = match self.upload(change.multiplexer) {
            Ok(attempt) => attempt.outcome,
            Err(verdict) => return Some(verdict.reason().to_string()),
        };
        if now == Outcome::Uploaded(change.original.clone()) {
            return None;
        }
        match self.download_as(change.multiplexer, &change.original, Mode::Shortest) {
            Ok(attempt) if attempt.outcome == Outcome::Downloaded => None,
            Ok(attempt) => Some(attempt.outcome.to_string()),
            Err(verdict) => Some(verdict.reason().to_string()),
        }
    }
}
