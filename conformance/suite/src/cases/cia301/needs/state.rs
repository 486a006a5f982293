//! NMT states, error control, and the nodes on the bus.

use crate::bench::Bench;
use crate::bench::Met;
use crate::bench::state::{GUARD_TIME, HEARTBEAT_TIME, Heartbeats};
use crate::need::Need;
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;

/// The device shows its NMT state: by heartbeat (1017h) or by node guarding (100Ch).
pub static VISIBLE_STATE: Need =
    Need::new("visible-state", "a heartbeat (1017h) or node guarding (100Ch), which show the NMT state", |bench| {
        match bench.heartbeats()? != Heartbeats::None || bench.has(GUARD_TIME)? {
            true => Ok(Ok(())),
            false => Ok(Err("the device has no 1017h that is not 0, and no 100Ch".to_owned())),
        }
    });

/// A heartbeat producer with a configurable period, 1017h.
pub static HEARTBEAT: Need = Need::new("heartbeat", "the heartbeat producer (1017h)", |bench| {
    let heartbeats = bench.heartbeats()?;
    if !heartbeats.is_settable() && bench.described(HEARTBEAT_TIME) == Some(true) && bench.can_write(HEARTBEAT_TIME)? {
        // The description says that 1017h can be written: it is a breach if it can't. 7.5.2.20: UNSIGNED16.
        bench.upload(HEARTBEAT_TIME)?.value()?;
        bench.download(HEARTBEAT_TIME, &1_000_u16.to_le_bytes())?.expect_confirmation()?;
    }
    Ok(match heartbeats {
        Heartbeats::Settable(_) => Ok(()),
        Heartbeats::Fixed(period) => Err(format!("the period is fixed: 1017h is {period} and can't be written")),
        Heartbeats::None => Err("the device has no 1017h that can be written".to_owned()),
    })
});

/// The heartbeat consumer, 1016h:01, and a node-ID next to the device's own for the tester to use.
pub(crate) static HEARTBEAT_CONSUMER: Need =
    Need::new("heartbeat-consumer", "the heartbeat consumer (1016h:01)", heartbeat_consumer);

fn heartbeat_consumer(bench: &mut Bench<'_>) -> Result<Met, Stop> {
    Ok(match (bench.has(Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1))?, bench.vacant_neighbour()) {
        (false, _) => Err("the device has no 1016h:01".to_owned()),
        (true, None) => Err("every node-ID next to that of the device is in use".to_owned()),
        (true, Some(_)) => Ok(()),
    })
}

/// Configurable life guarding, 100Ch and 100Dh, or the heartbeat consumer, 1016h:01.
pub static MONITORING: Need =
    Need::new("monitoring", "life guarding (100Ch, 100Dh) or a heartbeat consumer (1016h:01)", |bench| {
        match bench.can_be_guarded()? {
            true => Ok(Ok(())),
            false if watches_once_stored(bench) => {
                Ok(Err("the device monitors other nodes only after 1016h is stored, as its manual says".to_owned()))
            }
            false => heartbeat_consumer(bench),
        }
    });

/// Whether the entries of 1016h take effect only after they are stored, according to the manual.
fn watches_once_stored(bench: &Bench<'_>) -> bool {
    bench.manual().is_some_and(|model| model.sheet().network.heartbeat_consumer_needs_store)
}

/// Node guarding, 100Ch.
pub static GUARDING: Need = Need::new("guarding", "node guarding (100Ch)", |bench| {
    Ok(match (bench.has(GUARD_TIME)?, bench.heartbeats()?) {
        (false, _) => Err("the device has no 100Ch".to_owned()),
        (true, Heartbeats::Fixed(_)) => {
            Err("its heartbeat (1017h) can't be switched off, and takes precedence over guarding".to_owned())
        }
        (true, _) => Ok(()),
    })
});

/// Error behaviour, 1029h:01.
pub(crate) static ERROR_BEHAVIOUR: Need = Need::new("error-behaviour", "error behaviour (1029h:01)", |bench| {
    bench.can_write_all(&[Multiplexer::new(object::ERROR_BEHAVIOR, 1)])
});

/// NMT start-up, 1F80h.
pub(crate) static START_UP: Need = Need::new("start-up", "NMT start-up (1F80h)", |bench| {
    bench.can_write_all(&[Multiplexer::new(object::NMT_STARTUP, 0)])
});

/// No other node was heard on the bus or answers, or the user allows commands to other nodes: the case commands all
/// nodes.
pub(crate) static ALONE: Need =
    Need::new("alone", "a bus without other nodes, because the case commands all of them", |bench| bench.is_alone())
        .fleeting();
