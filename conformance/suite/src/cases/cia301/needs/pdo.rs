//! PDOs, and SYNC, which triggers them.

use crate::bench::Bench;
use crate::bench::Met;
use crate::bench::objects::{EVENT_TIMER as TIMER, TPDO_COB_ID, TPDO_FIRST_ENTRY, TPDO_MAPPED};
use crate::bench::pdo::RPDO as FIRST_RPDO;
use crate::bench::sdo::number;
use crate::need::Need;
use crate::situation::Situation;
use crate::verdict::{Grade, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_bus::client::Outcome;

const SYNC_ID: Multiplexer = Multiplexer::new(object::COB_ID_SYNC, 0);

/// Bit 30 of 1005h: the device produces SYNC.
const PRODUCES: u32 = 1 << 30;

/// TPDO 1, switched on: 1800h and 1A00h. A TPDO that is delivered off or empty is mapped and switched on for the case.
pub static TPDO: Need =
    Need::new("tpdo", "a TPDO that is switched on, or can be (1800h, 1A00h)", tpdo).provided_by(tpdo);

fn tpdo(bench: &mut Bench<'_>) -> Result<Met, Stop> {
    bench.provide_tpdo()
}

/// A TPDO with an event timer, 1800h:05.
pub static EVENT_TIMER: Need = Need::new("event-timer", "a TPDO with an event timer (1800h:05)", |bench| {
    if bench.has(TPDO_COB_ID)? && !bench.has(TIMER)? {
        return Ok(Err(format!("the device has no {TIMER}")));
    }
    tpdo(bench)
})
.provided_by(tpdo);

/// TPDO 1 with a mapping that can be changed: 1800h:01 and 1A00h.
pub(crate) static DYNAMIC_MAPPING: Need =
    Need::new("dynamic-mapping", "a TPDO 1 whose mapping can be changed (1800h:01, 1A00h)", dynamic_mapping);

fn dynamic_mapping(bench: &mut Bench<'_>) -> Result<Met, Stop> {
    bench.can_write_all(&[TPDO_COB_ID, TPDO_MAPPED, TPDO_FIRST_ENTRY])
}

/// The first RPDO, 1400h and 1600h.
pub static RPDO: Need =
    Need::new("rpdo", "an RPDO (1400h, 1600h)", |bench| bench.has_all(&[FIRST_RPDO.parameter(1), FIRST_RPDO.entry(0)]));

/// RPDO 1 with a mapping that can be changed, and an object for it that SDO can read.
pub(crate) static RPDO_MAPPING: Need = Need::new(
    "rpdo-mapping",
    "an RPDO 1 whose mapping can be changed, and an object for it that SDOs can read",
    |bench| {
        let parameters = [FIRST_RPDO.parameter(1), FIRST_RPDO.entry(0), FIRST_RPDO.entry(1)];
        Ok(match bench.can_write_all(&parameters)? {
            Ok(()) if bench.rpdo_objects().is_empty() => {
                Err("the description names no object that an RPDO can carry and an SDO can read".to_owned())
            }
            met => met,
        })
    },
);

/// TPDO 1 with a mapping that can be changed, and an object for it that SDO can write.
pub(crate) static CHANGEABLE: Need = Need::new(
    "changeable",
    "a TPDO 1 whose mapping can be changed, and an object for it that SDOs can write",
    |bench| match dynamic_mapping(bench)? {
        Ok(()) => bench.changeable().map(|_| Ok(())),
        unmet => Ok(unmet),
    },
);

/// SYNC, 1005h.
pub static SYNC: Need = Need::new("sync", "SYNC (1005h)", |bench| bench.has_all(&[SYNC_ID]));

/// The device can produce SYNC: 1005h bit 30 and 1006h. The bit is set while the period is 0, so that no SYNC is sent.
pub(crate) static SYNC_PRODUCER: Need = Need::new("sync-producer", "a SYNC producer (1005h bit 30, 1006h)", |bench| {
    if let Err(why) = bench.can_write_all(&[SYNC_ID, Multiplexer::new(object::COMMUNICATION_CYCLE_PERIOD, 0)])? {
        return Ok(Err(why));
    }
    let before = number(&bench.read(SYNC_ID)?);
    let attempt = bench.download(SYNC_ID, &(before | PRODUCES).to_le_bytes())?;
    if attempt.outcome == Outcome::Downloaded {
        bench.write(SYNC_ID, &before.to_le_bytes())?;
        return Ok(Ok(()));
    }
    match attempt.refused(Situation::SyncNotProduced) {
        Err(breach) if breach.grade == Grade::Wrong => Err(breach.into()),
        _ => Ok(Err("bit 30 of 1005h can't be set".to_owned())),
    }
});

/// The counter of SYNC, 1019h.
pub(crate) static SYNC_COUNTER: Need = Need::new("sync-counter", "the SYNC counter (1019h)", |bench| {
    bench.can_write_all(&[Multiplexer::new(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0)])
});
