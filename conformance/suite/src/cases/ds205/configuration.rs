//! Node-ID and bit rate. Only the store case stores, and it stores the current values.

use super::dialogue::{breach, exchange, expect_error, in_configuration};
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::bit_rate;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lmt::{self, ConfigureCommand, Lmt, Request};
use canvass_analyzer::wire::sdo;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// Configures the device's own node-ID, so that it is the last one configured.
pub(super) fn configure_own(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let node_id = bench.node().raw();
    exchange(bench, Request::ConfigureNodeId { node_id }).map(|_| ())
}

/// The slave refuses node-IDs that do not exist, 0 and 128 to 255, with an error code.
///
/// The table of the standard has no error code for this: devices answer 255 with a specific error of their own.
#[case(id = "205/node-id/invalid", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [NodeId], catches = [LmtNodeIdUnchecked])]
fn invalid_node_id(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        bench.each([0, 128, 254, 255], |bench, node_id| {
            let response = exchange(bench, Request::ConfigureNodeId { node_id })?;
            let duty = format!("node-ID {node_id} is refused");
            bench.check(expect_error(duty, "an error code other than 0", ConfigureCommand::NodeId, response, |error| {
                error != 0
            }))
        })?;
        let node_id = bench.node().raw();
        let response = exchange(bench, Request::ConfigureNodeId { node_id })?;
        let duty = "its own node-ID is accepted after those";
        bench.check(expect_error(duty, "error code 0", ConfigureCommand::NodeId, response, |error| error == 0))
    })
}

/// A configured node-ID takes effect only after it was stored and the device was switched off: until then the device
/// keeps its old node-ID.
#[case(id = "205/node-id/not-at-once", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [NodeId], catches = [LmtNodeIdAtOnce])]
fn not_at_once(bench: &mut Bench<'_>) -> Judged {
    let Some(node_id) = bench.vacant_neighbour() else {
        let reason = Reason::new("a neighbouring node-ID is free", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    in_configuration(bench, |bench| {
        bench.watch_restart();
        bench.gives_node_id(node_id);
        let response = exchange(bench, Request::ConfigureNodeId { node_id })?;
        bench.listen(bench.timing().silence)?;
        let answers = bench.answers()?;
        configure_own(bench)?;
        bench.listen(bench.timing().silence)?;
        let duty = format!("node-ID {node_id} is accepted");
        bench.check(expect_error(duty, "error code 0", ConfigureCommand::NodeId, response, |error| error == 0))?;
        bench.check(demand(answers, || {
            let breach = breach("the old node-ID is in use until power-off");
            breach.expected("an SDO response").found(Observation::Silence)
        }))
    })
}

/// Configures the bit rate of the bus, if it is known, so that it is the last one configured.
pub(super) fn configure_own_rate(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if let Some(index) = bench.bit_rate().and_then(Lmt::bit_rate_index) {
        exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    }
    Ok(())
}

/// Every bit rate of the description can be set by its row of table 0, which has 50, 20 and 10 kbit/s in rows 5 to 7:
/// LMT does not have the empty row 5 of LSS.
#[case(id = "205/bit-timing/table", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt, Description], touches = [BitRate], catches = [LmtBitTimingUnshifted])]
fn table(bench: &mut Bench<'_>) -> Judged {
    let described = bench.target().description.as_ref().map(|description| description.device.bit_rates.clone());
    let rates: Vec<u8> =
        described.unwrap_or_default().iter().filter_map(|&kbit| Lmt::bit_rate_index(u32::from(kbit) * 1000)).collect();
    in_configuration(bench, |bench| {
        bench.each(rates, |bench, index| {
            let response = exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
            let rate = Lmt::bit_rate(index).map_or(0, |rate| rate / 1000);
            let duty = format!("row {index}, {rate} kbit/s, is accepted");
            bench.check(expect_error(duty, "error code 0", ConfigureCommand::BitTiming, response, |error| error == 0))
        })?;
        configure_own_rate(bench)
    })
}

/// The slave refuses tables and rows that do not exist with an error code.
#[case(id = "205/bit-timing/invalid", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [BitRate], catches = [LmtBitTimingUnchecked])]
fn invalid_bit_timing(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        bench.each([(0, 9), (0, 200), (1, 0), (127, 3)], |bench, (table, index)| {
            let response = exchange(bench, Request::ConfigureBitTiming { table, index })?;
            let duty = format!("row {index} of table {table} is refused");
            bench.check(expect_error(
                duty,
                "an error code other than 0",
                ConfigureCommand::BitTiming,
                response,
                |error| error != 0,
            ))
        })?;
        configure_own_rate(bench)
    })
}

/// After activate bit timing the slave is silent for two delays and then works again. The case activates the current
/// bit rate of the bus.
#[case(id = "205/bit-timing/activate", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [BitRate], catches = [LmtActivationNotSilent])]
fn activate(bench: &mut Bench<'_>) -> Judged {
    const DELAY_MS: u16 = 500;
    let Some(index) = bench.bit_rate().and_then(Lmt::bit_rate_index) else {
        let found = bench.bit_rate().map_or_else(|| "it is not known".to_owned(), |rate| format!("{rate} bit/s"));
        let reason = Reason::new("the bit rate of the bus is in table 0", "one of DS-205", found);
        return Err(Stop::NotApplicable(reason));
    };
    in_configuration(bench, |bench| {
        let response = exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
        let duty = "the bit rate of the bus can be configured";
        expect_error(duty, "error code 0", ConfigureCommand::BitTiming, response, |error| error == 0)
            .or_inconclusive()?;
        bench.send(&Request::ActivateBitTiming { delay: DELAY_MS }.to_frame(lmt::MASTER_CAN_ID))?;
        let upload = sdo::Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0));
        // The waits end up to 200 ms before the end of the second delay.
        for _ in 0..3 {
            bench.listen(Duration::from_millis(60))?;
            let reply = bench.send_unanswered(&upload, "upload of 1000h:00 while the bit timing is activated")?;
            bench.check(reply.expect_silence())?;
        }
        bench.listen(Duration::from_millis(u64::from(DELAY_MS)))?;
        let works = bench.answers()?;
        bench.check(demand(works, || {
            let breach = breach("the device works after two delays");
            breach.expected("an SDO response").found(Observation::Silence)
        }))
    })
}

/// After "activate bit timing" the slave uses the bit rate that it has confirmed. The tester changes its own bit rate, asks
/// the device there, and brings it back. The device stores nothing.
#[case(id = "205/bit-timing/takes-effect", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt, Description], touches = [BitRate], catches = [LmtBitTimingWithoutEffect])]
fn takes_effect(bench: &mut Bench<'_>) -> Judged {
    bit_rate::takes_effect::<Lmt>(bench)
}

/// The slave answers store configuration, with error code 0 if the device can store.
#[case(id = "205/store/answered", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [Nvm, NodeId], catches = [LmtStoreSilent])]
fn store(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        configure_own(bench)?;
        let response = exchange(bench, Request::StoreConfiguration)?;
        bench.note("17h stored the current node-ID: one more write of the device's non-volatile memory");
        let expected = "error code 0, or 1 where nothing can be stored";
        bench.check(expect_error(
            "store configuration is answered",
            expected,
            ConfigureCommand::Store,
            response,
            |error| error <= 1,
        ))
    })
}
