//! The behaviour of the device after a start and in operational, without further commands.

use super::Bench;
use super::traffic::is_tpdo;
use crate::behaviour::{Behaviour, Changed};
use crate::verdict::Stop;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy};
use canvass_analyzer::wire::error_control::{self, ErrorControl};
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::Duration;

/// Time for which the tester watches the device after a start, and again in operational.
const SHOWN: Duration = Duration::from_millis(250);

/// Restarts the device and records its behaviour.
pub(super) fn behaviour(bench: &mut Bench<'_>) -> Result<Behaviour, Stop> {
    bench.drain()?;
    bench.command(Command::RESET_NODE)?;
    let begun = bench.now();
    if bench.wait_for_boot_up()?.is_none() {
        bench.listen(SHOWN)?;
    }
    bench.listen(SHOWN)?;
    let started = bench.heard_since(begun);
    let operational = match bench.changes.baseline.has_operational {
        true => {
            bench.command(Command::START)?;
            bench.listen(SHOWN)?
        }
        false => Vec::new(),
    };
    let (mut found, node) = (Behaviour::default(), u16::from(bench.node().raw()));
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

/// The differences between the current behaviour and the one before the run.
pub(super) fn changed_behaviour(bench: &mut Bench<'_>) -> Vec<Changed> {
    let Some(before) = bench.changes.baseline.behaviour.clone() else { return Vec::new() };
    // Whether the device starts at all shows in the comparison of the dictionary.
    let after = bench.uncancelled(|bench| bench.unjudged(behaviour));
    after.map(|after| before.changed(&after)).unwrap_or_default()
}
