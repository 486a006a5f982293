//! TPDOs as delivered, without any configuration.

use crate::bench::Bench;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Duration;

/// A TPDO that is synchronous as delivered is not sent without SYNC, not even when the device starts.
#[case(id = "301/tpdo/synchronous-as-delivered", clause = "CiA 301 7.2.2.2", confidence = Cited, level = Must,
       needs = [Tpdo, Sync], catches = [SynchronousTpdoAtStart])]
fn synchronous_as_delivered(bench: &mut Bench<'_>) -> Judged {
    bench.stop_sync_period()?;
    // The time before the reset: some devices become operational by themselves after it.
    let begun = bench.now();
    bench.reset(Command::RESET_NODE)?;
    let synchronous = synchronous(bench)?;
    if synchronous.is_empty() {
        let reason = Reason::new("a TPDO is synchronous as delivered", "type 0 to 240 in 1800h:02 to 1803h:02", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let sync = bench.sync_id()?;
    bench.command(Command::START)?;
    bench.listen(Duration::from_millis(300))?;
    let heard = bench.heard_since(begun);
    if heard.iter().any(|record| record.frame.cob_id() == Some(sync)) {
        return Err(Stop::Inconclusive(Reason::new("no other node sends SYNC", "none", "SYNC on the bus")));
    }
    bench.each(synchronous, |bench, (number, can_id)| {
        let sent = heard.iter().filter(|record| record.frame.cob_id() == Some(can_id)).count() as u64;
        bench.check(demand(sent == 0, || {
            let breach = Breach::new(Subject::Pdo { transmit: true, number }, "a synchronous TPDO waits for SYNC");
            breach.expected(Allowed::Count { least: 0, most: Some(0) }).found(Observation::Count(sent))
        }))
    })
}

/// The first four TPDOs that are valid and synchronous, by number, with their CAN-IDs.
fn synchronous(bench: &mut Bench<'_>) -> Result<Vec<(u16, u16)>, Stop> {
    let mut found = Vec::new();
    for number in 1..=4 {
        let pdo = TPDO.numbered(number);
        if !bench.has(pdo.parameter(1))? || !bench.has(pdo.parameter(2))? {
            continue;
        }
        let cob_id = bench.pdo_cob_id(pdo)?;
        if cob_id.is_valid() && !cob_id.is_extended() && bench.read_number(pdo.parameter(2))? <= 240 {
            found.push((number, (cob_id.can_id() & 0x7FF) as u16));
        }
    }
    Ok(found)
}
