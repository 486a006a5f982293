//! The object dictionary against the device's description.

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Stop, demand, tried};
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Index, Multiplexer};
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;

/// The error history, whose entries can only be read while there are errors.
const ERROR_HISTORY: Index = Index(object::PREDEFINED_ERROR_FIELD);

/// Every object that the description calls readable can be read, and its value has the length of its data type.
///
/// An object that has no value at the moment may be refused with abort 0800 0020h to 0800 0024h; an entry of an empty
/// error history may also be refused with abort 0800 0000h.
#[case(id = "301/dictionary/described", clause = "CiA 301 7.4.2", confidence = Cited, level = Must,
       needs = [Description], catches = [ErrorRegisterMissing, SyncObjectMissing, EdsSubIndexMissing, EdsDataTypeWrong, IdentityRevisionMissing, SdoSegmentLengthWrong,
                  ErrorControlMissing, OperatingStatusMissing, AlarmsMissing, PositionSixteenBit,
                  OperatingParametersThirtyTwoBit], cct = "4.1")]
fn described(bench: &mut Bench<'_>) -> Judged {
    let objects = readable(bench);
    bench.each(objects, |bench, (multiplexer, data_type)| {
        let attempt = bench.upload(multiplexer)?;
        let is_history = multiplexer.index == ERROR_HISTORY && multiplexer.sub.0 > 0;
        let is_empty = is_history && attempt.refused(Situation::EmptyHistory).is_ok();
        if is_empty || attempt.abort().is_some_and(is_momentary) {
            return Ok(());
        }
        let value = attempt.value()?;
        let length = data_type.bytes();
        bench.check(demand(length.is_none_or(|length| length == value.len()), || {
            Breach::new(multiplexer, "an object has the length of its data type")
                .expected(format!("{} bytes, the length of {data_type}", length.unwrap_or_default()))
                .found(Observation::Value(value))
        }))
    })
}

/// Sub-index 0 holds the highest sub-index of an object. Sub-indexes above it do not exist: reading one is refused with
/// abort 0609 0011h.
#[case(id = "301/dictionary/highest-sub-index", clause = "CiA 301 7.4.7.2", confidence = Cited, level = Must,
       catches = [SdoWrongCodeForNoSubIndex])]
fn highest_sub_index(bench: &mut Bench<'_>) -> Judged {
    let mut asked = 0;
    for index in [
        object::IDENTITY,
        object::TPDO_COMMUNICATION_PARAMETER,
        object::TPDO_MAPPING_PARAMETER,
        object::RPDO_COMMUNICATION_PARAMETER,
        object::RPDO_MAPPING_PARAMETER,
        object::ERROR_BEHAVIOR,
        object::CONSUMER_HEARTBEAT_TIME,
    ] {
        let Outcome::Uploaded(highest) = bench.upload(Multiplexer::new(index, 0))?.outcome else { continue };
        let Some(beyond) = highest.first().and_then(|highest| highest.checked_add(1)).filter(|&sub| sub < 0xFF) else {
            continue;
        };
        // Sub-index 0 of a mapping object counts the valid entries: the entries after them may exist.
        if matches!(index, object::RPDO_MAPPING_PARAMETER | object::TPDO_MAPPING_PARAMETER) {
            continue;
        }
        let attempt = bench.upload(Multiplexer::new(index, beyond))?;
        bench.check(attempt.refused(Situation::MissingEntry))?;
        asked += 1;
    }
    tried(asked, "an object whose sub-index 0 can be read")
}

fn readable(bench: &Bench<'_>) -> Vec<(Multiplexer, DataType)> {
    let Some(description) = &bench.target().description else { return Vec::new() };
    let entries = description.dictionary.entries();
    let wanted = entries.filter(|(_, entry)| entry.access.is_readable() && !entry.flags.refuses_read_on_scan());
    wanted.map(|(multiplexer, entry)| (multiplexer, entry.data_type)).collect()
}

/// Whether the object exists but can't return its value now.
const fn is_momentary(code: AbortCode) -> bool {
    matches!(code.0, 0x0800_0020..=0x0800_0024)
}

/// Sub-index FFh of an object, if it exists, holds the object code and the data type that the description gives; if it
/// does not exist, reading it is refused with abort 0609 0011h.
#[case(id = "301/dictionary/structure", clause = "CiA 301 7.4.7.2", confidence = Cited, level = Should,
       catches = [SdoWrongCodeForNoSubIndex, StructureEntryWrong], cct = "4.5")]
fn structure(bench: &mut Bench<'_>) -> Judged {
    let mut asked = 0;
    for index in [
        object::IDENTITY,
        object::PREDEFINED_ERROR_FIELD,
        object::TPDO_COMMUNICATION_PARAMETER,
        object::TPDO_MAPPING_PARAMETER,
        object::RPDO_COMMUNICATION_PARAMETER,
    ] {
        if !bench.has(Multiplexer::new(index, 0))? || bench.upload(Multiplexer::new(index, 0))?.abort().is_some() {
            continue;
        }
        asked += 1;
        let attempt = bench.upload(Multiplexer::new(index, 0xFF))?;
        let Outcome::Uploaded(value) = &attempt.outcome else {
            bench.check(attempt.refused(Situation::MissingEntry))?;
            continue;
        };
        let object = bench.target().description.as_ref();
        let object = object.and_then(|described| described.dictionary.object(Index(index)));
        // Bits 0 to 7 are the object code: 7 VAR, 8 ARRAY, 9 RECORD. Bits 24 to 31 are reserved.
        let expected = object.map(|object| u32::from(object.code.0));
        let found = crate::bench::sdo::number(value);
        let is_known = matches!(found & 0xFF, 7..=9) && found >> 24 == 0 && value.len() == 4;
        bench.check(demand(is_known && expected.is_none_or(|expected| expected == found & 0xFF), || {
            let code = expected.map_or_else(|| "7, 8 or 9".to_owned(), |expected| expected.to_string());
            Breach::new(attempt.multiplexer, "sub-index FFh holds the object code in bits 0 to 7; bits 24 to 31 are 0")
                .expected(format!("object code {code}"))
                .found(Observation::Value(value.clone()))
        }))?;
    }
    tried(asked, "an object whose sub-index 0 can be read")
}

/// Parameters have the same values after every reset node. The case notes parameters that differ from the default of
/// the description, because their values may have been stored.
#[case(id = "301/dictionary/after-reset", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [Description], catches = [ParameterDriftsAtReset], cct = "4.8")]
fn after_reset(bench: &mut Bench<'_>) -> Judged {
    let before = parameters(bench)?;
    tried(before.len(), "a parameter that can be read")?;
    bench.reset(canvass_analyzer::wire::nmt::Command::RESET_NODE)?;
    let after = parameters(bench)?;
    for (at, before) in &before {
        let now = after.iter().find(|(other, _)| other == at).map(|(_, value)| value);
        bench.check(demand(now == Some(before), || {
            let found =
                now.map_or(Observation::named("no value after the reset"), |now| Observation::Value(now.clone()));
            let breach = Breach::new(*at, "a parameter is the same after every reset node");
            breach.expected(Observation::Value(before.clone())).found(found)
        }))?;
    }
    let node = bench.node();
    let differs = |(at, value): &&(Multiplexer, Vec<u8>)| {
        let entry = bench.target().description.as_ref().and_then(|it| it.dictionary.entry(*at).ok());
        let default = entry.and_then(|entry| entry.start_value(node)?.encode(entry.data_type).ok());
        default.is_some_and(|default| default != *value)
    };
    let other: Vec<String> = after.iter().filter(differs).take(8).map(|(at, _)| at.to_string()).collect();
    if !other.is_empty() {
        bench.note(format!("not the default of the description: {}", other.join(", ")));
    }
    Ok(())
}

/// Writable parameters of communication and profile that keep their value, without measured values and commands.
fn parameters(bench: &mut Bench<'_>) -> Result<Vec<(Multiplexer, Vec<u8>)>, Stop> {
    let Some(description) = &bench.target().description else { return Ok(Vec::new()) };
    let is_parameter = |at: Multiplexer| {
        matches!(
            at.index.0,
            object::COB_ID_SYNC..=object::SYNCHRONOUS_WINDOW_LENGTH
                | object::GUARD_TIME
                | object::LIFE_TIME_FACTOR
                | object::COB_ID_TIME
                | object::COB_ID_EMCY..=object::PRODUCER_HEARTBEAT_TIME
                | object::SYNCHRONOUS_COUNTER_OVERFLOW..=object::ERROR_BEHAVIOR
        ) || matches!(at.index.0, 0x1200..=0x1BFF)
            || crate::bench::profile::all().any(|profile| profile.is_parameter(at))
    };
    let entries = description.dictionary.entries().filter(|(at, entry)| {
        let is_constant = entry.access.is_writable() && entry.access.is_readable() && !entry.pdo_mappable;
        is_constant && is_parameter(*at) && entry.data_type.bytes().is_some() && !entry.flags.refuses_read_on_scan()
    });
    let objects: Vec<Multiplexer> = entries.map(|(at, _)| at).collect();
    let mut values = Vec::with_capacity(objects.len());
    for at in objects {
        if let Outcome::Uploaded(value) = bench.upload(at)?.outcome {
            values.push((at, value));
        }
    }
    Ok(values)
}
