//! Whether the device is still there: one that was switched off fails nothing.

use super::Bench;
use crate::verdict::{Reason, Verdict};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::Duration;

/// A device that is gone is looked for so long before each case, so that a run still comes to its end.
const LOOK: Duration = Duration::from_millis(250);

impl Bench<'_> {
    /// Whether the device has left the bus: it neither answers nor starts when it is reset.
    pub(crate) fn has_left(&mut self) -> bool {
        self.restoring = true;
        let there = matches!(self.answers(), Ok(true)) || self.reset(Command::RESET_NODE).is_ok();
        self.restoring = false;
        self.gone = !there;
        self.gone
    }

    /// Looks for a device that had left.
    ///
    /// # Errors
    /// [`Verdict::Inconclusive`] if it is still away.
    pub(crate) fn look_for_it(&mut self) -> Result<(), Verdict> {
        if !self.gone {
            return Ok(());
        }
        let node = self.node();
        let request = canvass_analyzer::wire::sdo::Request::upload(Multiplexer::new(0x1000, 0));
        self.send_request(&request)?;
        let sign = self.wait_for(LOOK, |record| super::traffic::is_from(node, &record.frame).then_some(()))?;
        self.gone = sign.is_none();
        match sign {
            Some(()) => Ok(()),
            None => {
                let actual = "it left the bus in an earlier case";
                Err(Verdict::Inconclusive(Reason::new("the device is on the bus", "a sign of the device", actual)))
            }
        }
    }
}
