//! Each communication parameter accepts its current value (CiA 301, 7.4.5): if a device refuses it, the parameter is
//! writable only in the description, and most cases about its service have nothing to test.

use crate::bench::Bench;
use crate::bench::sdo::{Attempt, number};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop};
use canvass_analyzer::dictionary::Entry;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};
use std::collections::BTreeSet;

/// Bit 30 of 1005h and 1012h: the device produces; bit 31 of 1012h: it consumes.
const PRODUCES: u32 = 1 << 30;
const CONSUMES: u32 = 1 << 31;

/// Whether an object contains configuration, and has no other effect when it is written.
fn is_parameter(at: Multiplexer, entry: &Entry) -> bool {
    let is_known = matches!(
        at.index.0,
        object::COB_ID_SYNC..=object::SYNCHRONOUS_WINDOW_LENGTH
            | object::GUARD_TIME
            | object::LIFE_TIME_FACTOR
            | object::COB_ID_TIME
            | object::COB_ID_EMCY..=object::PRODUCER_HEARTBEAT_TIME
            | object::SYNCHRONOUS_COUNTER_OVERFLOW
            | object::ERROR_BEHAVIOR
    ) || matches!(
        (at.index.0,
        at.sub.0), (0x1400..=0x15FF
            | 0x1800..=0x19FF, 1..)
            | (0x1600..=0x17FF
            | 0x1A00..=0x1BFF, _)
    );
    is_known
        && entry.access.is_writable()
        && entry.access.is_readable()
        && !entry.flags.refuses_write_on_download()
        && entry.data_type.bytes().is_some_and(|bytes| bytes <= 4)
}

/// The COB-ID of the PDO that an object belongs to.
fn cob_id_of_pdo(at: Multiplexer) -> Option<Multiplexer> {
    match at.index.0 {
        0x1400..=0x15FF | 0x1800..=0x19FF => Some(Multiplexer::new(at.index.0, 1)),
        0x1600..=0x17FF | 0x1A00..=0x1BFF => Some(Multiplexer::new(at.index.0 - 0x200, 1)),
        _ => None,
    }
}

/// Whether the object may refuse every write for the moment, because of its value or that of a related object.
fn is_in_use(bench: &mut Bench<'_>, at: Multiplexer, value: u32) -> Result<bool, Stop> {
    if let Some(cob_id) = cob_id_of_pdo(at) {
        let is_entry = canvass_analyzer::object::is_pdo_mapping(at.index.0) && at.sub.0 > 0;
        return Ok(is_entry || bench.read_number(cob_id)? & CobId::INVALID == 0);
    }
    Ok(match at.index.0 {
        object::COB_ID_SYNC => value & PRODUCES != 0,
        object::COB_ID_TIME => value & (PRODUCES | CONSUMES) != 0,
        object::COB_ID_EMCY => value & CobId::INVALID == 0,
        // 1019h may refuse writes while SYNC has a period.
        object::SYNCHRONOUS_COUNTER_OVERFLOW => {
            bench.read_number(Multiplexer::new(object::COMMUNICATION_CYCLE_PERIOD, 0))? != 0
        }
        _ => false,
    })
}

/// Whether the abort code gives a reason other than the value: the device can't store the value now.
fn is_of_the_moment(attempt: &Attempt) -> bool {
    const MOMENT: [AbortCode; 4] =
        [AbortCode::GENERAL, AbortCode(0x0800_0020), AbortCode::LOCAL_CONTROL, AbortCode::DEVICE_STATE];
    attempt.abort().is_some_and(|code| MOMENT.contains(&code))
}

/// Writes the current value of an object. A refusal is a breach unless the object is in use.
fn rewrite(bench: &mut Bench<'_>, at: Multiplexer) -> Judged {
    let value = bench.read(at)?;
    let attempt = bench.download(at, &value)?;
    if is_of_the_moment(&attempt) || attempt.abort().is_some() && is_in_use(bench, at, number(&value))? {
        return Ok(());
    }
    bench.check(attempt.under("with its current value").refused(Situation::Confirmed))
}

/// Every communication parameter that the description calls writable accepts its current value, and a PDO can be
/// switched off and on again. While a COB-ID is in use, the device may refuse to write it and the parameters that
/// belong to it.
#[case(id = "301/sdo/download/own-value", clause = "CiA 301 7.4.5", confidence = Cited, level = Must,
       needs = [Description], catches = [SyncIdRefused, PdoOffRefused, ConsumerTimeRefused, SynchronousRpdoRefused,
                                           MappingProcedureRefused, SameCobIdRefused])]
fn own_value(bench: &mut Bench<'_>) -> Judged {
    let Some(description) = &bench.target().description else {
        return Err(nothing("a description of the device", "none"));
    };
    let entries = description.dictionary.entries().filter(|(at, entry)| is_parameter(*at, entry));
    let objects: Vec<Multiplexer> = entries.map(|(at, _)| at).collect();
    if objects.is_empty() {
        return Err(nothing("a writable communication parameter", "none"));
    }
    bench.each(objects.clone(), rewrite)?;
    let switches: BTreeSet<Multiplexer> = objects
        .iter()
        .copied()
        .filter(|at| at.index.0 == object::COB_ID_EMCY || cob_id_of_pdo(*at) == Some(*at))
        .collect();
    bench.each(switches, |bench, cob_id| {
        let own = bench.read_number(cob_id)?;
        let on = own & !CobId::INVALID;
        if own != on && (CobId(on).is_restricted() || bench.download(cob_id, &on.to_le_bytes())?.abort().is_some()) {
            // The PDO is delivered off, and can't be switched on with this COB-ID.
            return Ok(());
        }
        let attempt = bench.download(cob_id, &(on | CobId::INVALID).to_le_bytes())?;
        if is_of_the_moment(&attempt) {
            return Ok(());
        }
        attempt.under("to switch it off").refused(Situation::Confirmed)?;
        let of_this = |at: &&Multiplexer| **at != cob_id && cob_id_of_pdo(**at) == Some(cob_id);
        bench.each(objects.iter().filter(of_this), |bench, at| rewrite(bench, *at))?;
        let attempt = bench.download(cob_id, &on.to_le_bytes())?;
        bench.check(attempt.under("to switch it on again").refused(Situation::Confirmed))
    })
}

fn nothing(expected: &str, actual: &str) -> Stop {
    Stop::NotApplicable(Reason::new("the description has a parameter for this case", expected, actual))
}
