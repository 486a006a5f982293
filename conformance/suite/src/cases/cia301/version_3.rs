//! Objects of DS-301 V3.0 that V4.0 dropped: 1004h, 100Bh, 100Eh, and bit 31 of 1005h. Only devices that have them are
//! judged.

use crate::bench::Bench;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::CobId;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;

const PDOS: Multiplexer = Multiplexer::new(object::NUMBER_OF_PDOS, 0);
const NODE_ID: Multiplexer = Multiplexer::new(object::NODE_ID, 0);
const SYNC_ID: Multiplexer = Multiplexer::new(object::COB_ID_SYNC, 0);
const GUARDING_ID: Multiplexer = Multiplexer::new(object::COB_ID_GUARDING, 0);

/// The number in an object that may be absent.
fn number(bench: &mut Bench<'_>, multiplexer: Multiplexer) -> Result<u32, Stop> {
    match bench.upload(multiplexer)?.outcome {
        Outcome::Uploaded(value) => Ok(crate::bench::sdo::number(&value)),
        other => {
            let reason = Reason::new("the device has the object", multiplexer.to_string(), other.to_string());
            Err(Stop::NotApplicable(reason))
        }
    }
}

/// 1004h counts the PDOs, RPDOs in the upper half and TPDOs in the lower half. Sub-index 0 is the sum of the
/// synchronous PDOs in sub-index 1 and the asynchronous PDOs in sub-index 2, and equals the number of communication
/// parameters.
#[case(id = "301/dictionary/number-of-pdos", clause = "CiA 301", confidence = Unknown, level = Should,
       needs = [Description], catches = [PdoCountWrong])]
fn number_of_pdos(bench: &mut Bench<'_>) -> Judged {
    let all = number(bench, PDOS)?;
    let synchronous = number(bench, Multiplexer::new(object::NUMBER_OF_PDOS, 1))?;
    let asynchronous = number(bench, Multiplexer::new(object::NUMBER_OF_PDOS, 2))?;
    let found = Observation::Value(all.to_le_bytes().to_vec());
    bench.check(demand(synchronous.wrapping_add(asynchronous) == all, || {
        Breach::new(PDOS, "1004h:00 is the sum of 1004h:01 and 1004h:02")
            .expected(format!("{synchronous:08X}h + {asynchronous:08X}h"))
            .found(found.clone())
    }))?;
    let dictionary = bench.target().description.as_ref().map(|description| &description.dictionary);
    let count = |first: u16, last: u16| {
        let entries = dictionary.into_iter().flat_map(|dictionary| dictionary.entries());
        entries.filter(|(at, _)| (first..=last).contains(&at.index.0) && at.sub.0 == 1).count() as u32
    };
    let there = count(0x1400, 0x15FF) << 16 | count(0x1800, 0x19FF);
    bench.check(demand(there == all, || {
        let breach = Breach::new(PDOS, "1004h:00 counts the PDOs of the device");
        breach.expected(format!("{there:08X}h")).found(found)
    }))
}

/// 100Bh holds the node-ID.
#[case(id = "301/dictionary/node-id", clause = "CiA 301", confidence = Unknown, level = Should,
       catches = [NodeIdObjectWrong])]
fn node_id(bench: &mut Bench<'_>) -> Judged {
    let found = number(bench, NODE_ID)?;
    let node = u32::from(bench.node().raw());
    bench.check(demand(found == node, || {
        Breach::new(NODE_ID, "100Bh is the node-ID in use")
            .expected(Observation::Number(u64::from(node)))
            .found(Observation::Number(u64::from(found)))
    }))
}

/// 100Eh holds the COB-ID of the guarding answers: 700h + node-ID.
#[case(id = "301/guarding/cob-id", clause = "CiA 301", confidence = Unknown, level = Should,
       catches = [GuardingCobIdWrong])]
fn guarding_cob_id(bench: &mut Bench<'_>) -> Judged {
    let found = number(bench, GUARDING_ID)? & 0x7FF;
    let used = u32::from(error_control::CAN_ID_BASE) + u32::from(bench.node().raw());
    bench.check(demand(found == used, || {
        Breach::new(GUARDING_ID, "100Eh is the COB-ID of guarding")
            .expected(format!("{used:03X}h"))
            .found(Observation::Number(u64::from(found)))
            .told(format!("{found:03X}h"))
    }))
}

/// The CAN-ID of a TPDO that the device as delivered sends after each SYNC.
fn with_each_sync(bench: &mut Bench<'_>) -> Result<Option<u16>, Stop> {
    for pdo in (1..=4).map(|number| TPDO.numbered(number)) {
        if bench.has(pdo.parameter(2))? && bench.read_number(pdo.parameter(2))? == 1 {
            let cob_id = bench.pdo_cob_id(pdo)?;
            return Ok(cob_id.is_valid().then_some((cob_id.can_id() & 0x7FF) as u16));
        }
    }
    Ok(None)
}

/// The case only records whether a device of DS-301 V3.0 that is delivered with bit 31 of 1005h set consumes SYNC only
/// while that bit is set, because the fourth edition gives the bit no meaning.
#[case(id = "301/sync/consumer-bit", clause = "CiA 301 7.5.2.5", confidence = Cited, level = Open,
       needs = [Tpdo], catches = [SyncConsumerBitIgnored])]
fn consumer_bit(bench: &mut Bench<'_>) -> Judged {
    number(bench, PDOS)?;
    let own = number(bench, SYNC_ID)?;
    if own & CobId::INVALID == 0 {
        let actual = format!("1005h = {own:08X}h");
        return Err(Stop::NotApplicable(Reason::new("1005h is delivered with bit 31", "bit 31", actual)));
    }
    let Some(can_id) = with_each_sync(bench)? else {
        return Err(Stop::NotApplicable(Reason::new(
            "a TPDO is delivered with type 1",
            "one of the first four",
            "none",
        )));
    };
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    bench.each([(own, 1), (own & !CobId::INVALID, 0)], |bench, (value, right)| {
        bench.write_confirmed(SYNC_ID, &value.to_le_bytes())?;
        bench.drain()?;
        bench.send_bytes((own & 0x7FF) as u16, &[])?;
        let heard = bench.frames_of(can_id, bench.shortly())?.len() as u64;
        bench.check(demand(heard == right, || {
            Breach::new(SYNC_ID, format!("with 1005h = {value:08X}h one SYNC triggers {right} TPDOs of type 1"))
                .expected(Observation::Count(right))
                .found(Observation::Count(heard))
        }))
    })
}
