//! What the device does by itself after a start, and in operational.

use super::Bench;
use super::traffic::is_tpdo;
use crate::behaviour::{Behaviour, Changed};
use crate::verdict::Stop;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy};
use canvass_analyzer::wire::error_control::{self, ErrorControl};
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::Duration;

/// A device shows what it does by itself for this long after a start, and once more in operational.
const SHOWN: Duration = Duration::from_millis(250);

impl Bench<'_> {
    /// What the device does after a start, now.
    pub(super) fn behaviour(&mut self) -> Result<Behaviour, Stop> {
        self.drain()?;
        self.command(Command::RESET_NODE)?;
        let begun = self.now();
        if self.wait_for_boot_up()?.is_none() {
            self.listen(SHOWN)?;
        }
        self.listen(SHOWN)?;
        let started = self.heard_since(begun);
        let operational = match self.changes.baseline.has_operational {
            true => {
                self.command(Command::START)?;
                self.listen(SHOWN)?
            }
            false => Vec::new(),
        };
        let (mut found, node) = (Behaviour::default(), u16::from(self.node().raw()));
        for record in &started {
            match record.frame.cob_id() {
                Some(id) if id == emcy::CAN_ID_BASE + node => {
                    found.emergencies.extend(Emcy::read(record.data()).ok().and_then(|emcy| emcy.code()));
                }
                Some(id) if id == error_control::CAN_ID_BASE + node => {
                    let message = ErrorControl::read(record.data()).ok().filter(|message| !message.is_boot_up());
                    found.state = message.map(|message| message.state).or(found.state);
                }
                _ => {}
            }
        }
        for id in operational.iter().filter_map(|record| record.frame.cob_id()).filter(|id| is_tpdo(*id)) {
            *found.pdos.entry(id).or_default() += 1;
        }
        Ok(found)
    }

    /// What it does otherwise than before the run.
    pub(super) fn changed_behaviour(&mut self) -> Vec<Changed> {
        let Some(before) = self.changes.baseline.behaviour.clone() else { return Vec::new() };
        // Whether the device starts at all shows in the dictionary.
        let after = self.uncancelled(|bench| bench.unjudged(Self::behaviour));
        after.map(|after| before.changed(&after)).unwrap_or_default()
    }
}
