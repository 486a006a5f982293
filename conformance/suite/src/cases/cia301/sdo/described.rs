//! Access rights, lengths and limits of every object that the device's description names (CiA 301, 7.2.4.3.17).
//!
//! The cases send requests that must be refused. Objects that could do harm if the device accepted the request are left
//! out: node-ID and bit rate, and manufacturer objects from 2000h to 5FFFh.

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{Access, Entry, Value};
use canvass_analyzer::object;

/// Number of errors in the error history.
const ERROR_COUNT: Multiplexer = Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 0);

/// An object and its entry in the description.
type Described = (Multiplexer, Entry);

fn described(bench: &Bench<'_>, wanted: impl Fn(Multiplexer, &Entry) -> bool) -> Result<Vec<Described>, Stop> {
    let Some(description) = &bench.target().description else {
        return Err(nothing("a description of the device", "none"));
    };
    let entries = description.dictionary.entries();
    let found: Vec<Described> =
        entries.filter(|(at, entry)| wanted(*at, entry)).map(|(at, entry)| (at, entry.clone())).collect();
    if found.is_empty() { Err(nothing("an object that the case is about", "none")) } else { Ok(found) }
}

fn nothing(expected: &str, actual: &str) -> Stop {
    Stop::NotApplicable(Reason::new("the description has an object for this case", expected, actual))
}

/// Whether an object is a communication or profile object that holds a configuration and does not act when it is
/// written.
fn is_harmless(bench: &Bench<'_>, at: Multiplexer) -> bool {
    bench.may_write(at)
        && !bench.acts(at)
        && matches!(
            at.index.0,
            object::COB_ID_SYNC..=object::SYNCHRONOUS_WINDOW_LENGTH
                | object::GUARD_TIME
                | object::LIFE_TIME_FACTOR
                | object::COB_ID_TIME..=object::ERROR_BEHAVIOR
                | 0x1400..=0x1BFF
                | 0x6000..=0x9FFF
        )
}

fn is_plain(entry: &Entry) -> bool {
    !entry.flags.refuses_write_on_download() && entry.access.is_writable() && entry.access.is_readable()
}

/// Every object that the description calls constant or read-only refuses a write with abort 0601 0002h.
#[case(id = "301/sdo/download/every-read-only", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [Description], catches = [SdoReadOnlyWritable, SdoReadOnlyWrongCode, HeartbeatConsumerNotStopped, PositionWritable, EdsSubIndexMissing], cct = "4.3")]
fn every_read_only(bench: &mut Bench<'_>) -> Judged {
    // The number of errors can be written, whatever a description in short form says of sub-indexes 0.
    let objects = described(bench, |at, entry| {
        at != ERROR_COUNT
            && !entry.access.is_writable()
            && entry.data_type.bytes().is_some_and(|bytes| (1..=4).contains(&bytes))
    })?;
    bench.each(objects, |bench, (multiplexer, entry)| {
        let attempt = bench.download(multiplexer, &vec![0; entry.data_type.bytes().unwrap_or(1)])?;
        bench.check(attempt.refused(Situation::ReadOnly))
    })
}

/// Every object that the description calls write-only refuses a read with abort 0601 0001h.
#[case(id = "301/sdo/upload/write-only", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [Description], catches = [SdoWriteOnlyWrongCode], cct = "4.4")]
fn write_only(bench: &mut Bench<'_>) -> Judged {
    let objects = described(bench, |_, entry| entry.access == Access::Wo)?;
    bench.each(objects, |bench, (multiplexer, _)| {
        let attempt = bench.upload(multiplexer)?;
        bench.check(attempt.refused(Situation::WriteOnly))
    })
}

/// Every writable object refuses a value with more bytes than its data type with abort 0607 0012h.
#[case(id = "301/sdo/download/every-too-long", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [Description], catches = [SdoLengthUnchecked, SdoLengthWrongCode], cct = "2.8")]
fn every_too_long(bench: &mut Bench<'_>) -> Judged {
    every_length(bench, 1..=2, |length| length + 1, Situation::TooLong)
}

/// Every writable object refuses a value with fewer bytes than its data type with abort 0607 0013h.
#[case(id = "301/sdo/download/every-too-short", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [Description], catches = [SdoShortLengthUnchecked, SdoLengthWrongCode, HeartbeatConsumerNotStopped, SyncNotStopped, EdsDataTypeWrong], cct = "2.9")]
fn every_too_short(bench: &mut Bench<'_>) -> Judged {
    every_length(bench, 2..=4, |length| length - 1, Situation::TooShort)
}

fn every_length(
    bench: &mut Bench<'_>,
    lengths: std::ops::RangeInclusive<usize>,
    wrong: fn(usize) -> usize,
    situation: Situation,
) -> Judged {
    let objects = described(bench, |at, entry| {
        is_harmless(bench, at)
            && is_plain(entry)
            && entry.data_type.bytes().is_some_and(|bytes| lengths.contains(&bytes))
    })?;
    bench.each(objects, |bench, (multiplexer, entry)| {
        let length = wrong(entry.data_type.bytes().unwrap_or(1));
        let attempt = bench.download(multiplexer, &vec![0; length])?;
        // An object in use may refuse every write for this reason.
        let is_refused_as_used = may_be_in_use(multiplexer) && attempt.abort().is_some();
        if is_refused_as_used { Ok(()) } else { bench.check(attempt.refused(situation)) }
    })
}

/// Whether the object is a parameter of a PDO, or a COB-ID: while the PDO or the COB-ID is valid, the device may refuse
/// any change.
const fn may_be_in_use(at: Multiplexer) -> bool {
    matches!(
        at.index.0,
        object::COB_ID_SYNC | object::COB_ID_TIME | object::COB_ID_EMCY | object::EMERGENCY_CONSUMER | 0x1400..=0x1BFF
    )
}

/// The value just below a low limit.
fn below(bench: &Bench<'_>, entry: &Entry) -> Option<Vec<u8>> {
    let length = entry.data_type.bytes().filter(|&length| length <= 4)?;
    let limit = entry.low_limit.as_ref()?.resolve(entry.data_type, bench.node()).as_number()?;
    let value = match limit.checked_sub(1)? {
        below @ 0.. => Value::Unsigned(u64::try_from(below).ok()?),
        below => Value::Integer(i64::try_from(below).ok()?),
    };
    value.encode(entry.data_type).ok().filter(|bytes| bytes.len() == length)
}

/// Writing a value below the low limit of the description is refused with abort 0609 0032h or 0609 0030h, and the
/// object keeps its value.
#[case(id = "301/sdo/download/below-range", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [Description], catches = [SdoRangeUnchecked, SdoRangeWrongCode], cct = "2.11")]
fn below_range(bench: &mut Bench<'_>) -> Judged {
    let objects = described(bench, |at, entry| is_harmless(bench, at) && is_plain(entry) && entry.low_limit.is_some())?;
    let tried: Vec<(Multiplexer, Vec<u8>)> =
        objects.iter().filter_map(|(at, entry)| Some((*at, below(bench, entry)?))).collect();
    if tried.is_empty() {
        return Err(nothing("a low limit above the lowest value of its type", "none"));
    }
    bench.each(tried, |bench, (multiplexer, value)| {
        let before = bench.read(multiplexer)?;
        let attempt = bench.download(multiplexer, &value)?;
        bench.check(attempt.refused(Situation::TooLow))?;
        bench.expect_unchanged(multiplexer, &before)
    })
}
