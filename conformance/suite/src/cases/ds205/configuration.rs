//! Node-ID and bit rate. Nothing of it is stored, but for the store case, which stores what the device has.

use super::{exchange, in_configuration, shown};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lmt::{self, BIT_RATES, ConfigureCommand, Request, Response};
use canvass_analyzer::wire::sdo;
use canvass_traces::Duration;

/// The error code of the answer to a configuration; `None` for any other answer.
fn error_of(response: Option<Response>, of: ConfigureCommand) -> Option<u8> {
    match response {
        Some(Response::Configured { command, error, .. }) if command == of => Some(error),
        _ => None,
    }
}

/// Leaves the node-ID that the device has as the one configured last.
pub(super) fn configure_own(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let node_id = bench.node().raw();
    exchange(bench, Request::ConfigureNmtAddress { node_id }).map(|_| ())
}

/// Node-IDs that don't exist, 0 and 128 to 255, are refused with an error code.
///
/// The table of the standard has no code for it: devices answer 255 with a specific error of their own.
#[case(id = "205/node-id/invalid", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [NodeId], catches = [LmtNodeIdUnchecked])]
fn invalid_node_id(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        let mut wrong = None;
        for node_id in [0, 128, 254, 255] {
            let response = exchange(bench, Request::ConfigureNmtAddress { node_id })?;
            let refused = error_of(response, ConfigureCommand::NmtAddress).is_some_and(|error| error != 0);
            if !refused && wrong.is_none() {
                wrong = Some((node_id, shown(response)));
            }
        }
        configure_own(bench)?;
        bench.check(demand(wrong.is_none(), || {
            let (node_id, actual) = wrong.unwrap_or_default();
            Reason::new(format!("node-ID {node_id} is refused"), "an error code other than 0", actual)
        }))
    })
}

/// A configured node-ID acts only after it was stored and the device was off: until then the old one is in use.
#[case(id = "205/node-id/not-at-once", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [NodeId], catches = [LmtNodeIdAtOnce])]
fn not_at_once(bench: &mut Bench<'_>) -> Judged {
    let Some(node_id) = bench.vacant_neighbour() else {
        let reason = Reason::new("a node-ID beside that of the device is free", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    in_configuration(bench, |bench| {
        bench.watch_restart();
        let response = exchange(bench, Request::ConfigureNmtAddress { node_id })?;
        bench.listen(bench.timing().silence)?;
        let answers = bench.answers()?;
        configure_own(bench)?;
        bench.listen(bench.timing().silence)?;
        demand(error_of(response, ConfigureCommand::NmtAddress) == Some(0), || {
            Reason::new(format!("node-ID {node_id} is taken"), "error code 0", shown(response))
        })?;
        bench.check(demand(answers, || {
            Reason::new("the old node-ID is in use until power-off", "an SDO response", "silence")
        }))
    })
}

/// Sets the bit rate that the bus has as the one configured last, where it is known.
pub(super) fn configure_own_rate(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if let Some(index) = bench.bit_rate().and_then(index_of) {
        exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    }
    Ok(())
}

fn index_of(rate: u32) -> Option<u8> {
    BIT_RATES.iter().position(|&known| known == rate).and_then(|index| u8::try_from(index).ok())
}

/// Every bit rate of the description can be set by its row of table 0, which has 50, 20 and 10 kbit/s in rows 5 to 7:
/// the empty row 5 of LSS does not exist in LMT.
#[case(id = "205/bit-timing/table", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt, Description], touches = [BitRate], catches = [LmtBitTimingUnshifted])]
fn table(bench: &mut Bench<'_>) -> Judged {
    let described = bench.target().description.as_ref().map(|description| description.device.bit_rates.clone());
    let rates: Vec<u8> =
        described.unwrap_or_default().iter().filter_map(|&kbit| index_of(u32::from(kbit) * 1000)).collect();
    in_configuration(bench, |bench| {
        let mut wrong = None;
        for index in rates {
            let response = exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
            if error_of(response, ConfigureCommand::BitTiming) != Some(0) && wrong.is_none() {
                wrong = Some((index, shown(response)));
            }
        }
        configure_own_rate(bench)?;
        bench.check(demand(wrong.is_none(), || {
            let (index, actual) = wrong.unwrap_or_default();
            let rate = BIT_RATES.get(usize::from(index)).map_or(0, |rate| rate / 1000);
            Reason::new(format!("row {index}, {rate} kbit/s, is taken"), "error code 0", actual)
        }))
    })
}

/// Rows and tables that don't exist are refused with error code 1.
#[case(id = "205/bit-timing/invalid", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [BitRate], catches = [LmtBitTimingUnchecked])]
fn invalid_bit_timing(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        let mut wrong = None;
        for (table, index) in [(0, 9), (0, 200), (1, 0), (127, 3)] {
            let response = exchange(bench, Request::ConfigureBitTiming { table, index })?;
            let refused = error_of(response, ConfigureCommand::BitTiming).is_some_and(|error| error != 0);
            if !refused && wrong.is_none() {
                wrong = Some((table, index, shown(response)));
            }
        }
        configure_own_rate(bench)?;
        bench.check(demand(wrong.is_none(), || {
            let (table, index, actual) = wrong.unwrap_or_default();
            Reason::new(format!("row {index} of table {table} is refused"), "error code 1", actual)
        }))
    })
}

/// After activate bit timing the slave is silent for two delays, then it works on. The bit rate that the bus has
/// already is activated.
#[case(id = "205/bit-timing/activate", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [BitRate], catches = [LmtActivationNotSilent])]
fn activate(bench: &mut Bench<'_>) -> Judged {
    const DELAY_MS: u16 = 500;
    let Some(index) = bench.bit_rate().and_then(index_of) else {
        let reason =
            Reason::new("the bit rate of the bus is known", "one of table 0", format!("{:?}", bench.bit_rate()));
        return Err(Stop::NotApplicable(reason));
    };
    in_configuration(bench, |bench| {
        let response = exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
        demand(error_of(response, ConfigureCommand::BitTiming) == Some(0), || {
            Reason::new("the bit rate of the bus can be configured", "error code 0", shown(response))
        })
        .or_inconclusive()?;
        bench.send(&Request::ActivateBitTiming { delay: DELAY_MS }.to_frame(lmt::MASTER_CAN_ID))?;
        let upload = sdo::Request::upload(Multiplexer::new(0x1000, 0));
        let mut answered = None;
        // Up to 200 ms before the end of the second delay.
        for _ in 0..3 {
            bench.listen(Duration::from_millis(60))?;
            let reply = bench.send_unanswered(&upload, "upload of 1000h:00 while the bit timing is activated")?;
            answered = answered.or(reply.expect_silence().err());
        }
        bench.listen(Duration::from_millis(u64::from(DELAY_MS)))?;
        let works = bench.answers()?;
        if let Some(failure) = answered {
            return Err(failure.into());
        }
        bench.check(demand(works, || Reason::new("the device works after two delays", "an SDO response", "silence")))
    })
}

/// Store configuration is answered, with error code 0 where the device can store.
#[case(id = "205/store/answered", clause = "CiA DS-205", confidence = Unknown, level = Must,
       needs = [Alone, Lmt], touches = [Nvm, NodeId], catches = [LmtStoreSilent])]
fn store(bench: &mut Bench<'_>) -> Judged {
    in_configuration(bench, |bench| {
        configure_own(bench)?;
        let response = exchange(bench, Request::StoreConfiguration)?;
        bench.note("17h stored the node-ID that the device has: one more write of its non-volatile memory");
        bench.check(demand(matches!(error_of(response, ConfigureCommand::Store), Some(0 | 1)), || {
            Reason::new(
                "store configuration is answered",
                "error code 0, or 1 where nothing can be stored",
                shown(response),
            )
        }))
    })
}
