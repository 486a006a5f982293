//! The effect of the SYNC that a device produces on its own PDOs (CiA 301, 7.2.5).

use super::sync::produce;
use super::tpdo_events::{operational, subject};
use crate::bench::Bench;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, demand};
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// The case only records whether a TPDO of transmission type 1 follows each SYNC that the device itself produces,
/// because CiA 301 defines this only for received SYNC.
#[case(id = "301/sync/own", clause = "CiA 301 7.2.5.1", confidence = Cited, level = Open,
       needs = [SyncProducer, Changeable], catches = [SyncOwnUnheeded])]
fn own(bench: &mut Bench<'_>) -> Judged {
    let subject = subject(bench, 1)?;
    let id = produce(bench, 0)?;
    operational(bench)?;
    let from = bench.now();
    bench.listen(Duration::from_secs(1))?;
    let [syncs, tpdos] = [id, subject.can_id].map(|can_id| {
        let frames = bench.evidence().frames().map(|exhibit| &exhibit.record);
        frames.filter(|record| record.timestamp > from && record.frame.cob_id() == Some(can_id)).count() as u64
    });
    bench.check(demand(syncs > 0 && tpdos.abs_diff(syncs) <= 1, || {
        Breach::new(TPDO.subject(), "a TPDO of type 1 follows each SYNC of the device itself")
            .expected(Allowed::Count { least: syncs.saturating_sub(1), most: Some(syncs + 1) })
            .found(Observation::Count(tpdos))
    }))
}
