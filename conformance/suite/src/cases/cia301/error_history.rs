//! The error history (1003h).

use super::emcy::{begin_monitoring, code_of, emergencies, sign_of_life};
use crate::bench::Bench;
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record};

const COUNT: Multiplexer = Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 0);
const NEWEST: Multiplexer = Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 1);
const BEFORE_NEWEST: Multiplexer = Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 2);
/// Long enough for the loss of the monitored node or master.
const UNTIL_LOST: Duration = Duration::from_millis(600);

fn clear(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.write(COUNT, &[0])
}

/// Reading an entry of an empty error history is refused with abort 0800 0024h or 0800 0000h.
///
/// Manuals differ: on some devices the entries read as 0, which has the same meaning. The case notes the answer of the
/// device.
#[case(id = "301/error-history/empty", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Should,
       needs = [ErrorHistory], catches = [ErrorHistoryEmptyReadsZero], cct = "5.3")]
fn empty(bench: &mut Bench<'_>) -> Judged {
    // The code for "no data" was introduced in V4.0 of CiA 301, which also removed 1004h.
    if bench.has(Multiplexer::new(object::NUMBER_OF_PDOS, 0))? {
        let reason =
            Reason::new("the device knows abort 0800 0024h", "CiA 301 V4.0", "a device of DS-301 V3.0 (1004h)");
        return Err(Stop::NotApplicable(reason));
    }
    clear(bench)?;
    let attempt = bench.upload(NEWEST)?;
    bench.check(attempt.refused(Situation::EmptyHistory))
}

/// The error codes by which the device reports the loss of the monitored node, oldest first. Without a report the
/// history may be empty.
fn reported(bench: &mut Bench<'_>) -> Result<Vec<u16>, Stop> {
    let codes = error_codes(&emergencies(bench, UNTIL_LOST)?);
    if codes.is_empty() {
        let actual = "none, so that the history has no error to hold";
        return Err(Stop::Inconclusive(Reason::new(
            "the loss of the monitored node or master is reported",
            "an EMCY",
            actual,
        )));
    }
    Ok(codes)
}

/// The codes of EMCYs, without the EMCYs that report the end of an error.
fn error_codes(heard: &[Record]) -> Vec<u16> {
    heard.iter().filter_map(code_of).map(|code| code.0).filter(|&code| code != 0).collect()
}

/// Requires this error code in the lower word of an entry.
fn expect_code(bench: &mut Bench<'_>, entry: Multiplexer, code: u16, duty: &'static str) -> Judged {
    let value = bench.upload(entry)?.value()?;
    bench.check(demand(number(&value) & 0xFFFF == u32::from(code), || {
        let breach = Breach::new(entry, duty).expected(format!("error code {code:04X}h in the lower word"));
        breach.found(Observation::Value(value))
    }))
}

/// The error history contains an error that the device signalled by EMCY: 1003h:00 counts it, and the lower word of
/// 1003h:01 is its error code.
#[case(id = "301/error-history/entry", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Must,
       needs = [ErrorHistory, Monitoring], catches = [ErrorHistoryNotKept])]
fn entry(bench: &mut Bench<'_>) -> Judged {
    clear(bench)?;
    begin_monitoring(bench)?;
    let codes = reported(bench)?;
    let count = bench.upload(COUNT)?.value()?;
    bench.check(demand(
        (1..=codes.len()).contains(&usize::from(count.first().copied().unwrap_or_default())),
        || {
            let breach = Breach::new(COUNT, "1003h:00 counts the errors that were signalled");
            breach.expected(format!("1 to {}", codes.len())).found(Observation::Value(count))
        },
    ))?;
    let newest = codes.last().copied().unwrap_or_default();
    expect_code(bench, NEWEST, newest, "1003h:01 holds the error that was signalled last")
}

/// 1003h:01 holds the newest error, 1003h:02 the error before it.
#[case(id = "301/error-history/newest-first", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Must,
       needs = [ErrorHistory, HeartbeatConsumer, RpdoMapping], catches = [SdoSilentWhenOperational, ErrorHistoryReversed])]
fn newest_first(bench: &mut Bench<'_>) -> Judged {
    use crate::bench::pdo::RPDO;
    if !bench.has(BEFORE_NEWEST)? {
        let reason = Reason::new("the history holds two errors", BEFORE_NEWEST.to_string(), "no such entry");
        return Err(Stop::NotApplicable(reason));
    }
    clear(bench)?;
    begin_monitoring(bench)?;
    let first = reported(bench)?.last().copied().unwrap_or_default();
    // A second error with another code: an RPDO that is too short.
    let mapped = bench.rpdo_objects().into_iter().find(|mapped| mapped.bits > 8);
    let Some(mapped) = mapped else {
        let reason = Reason::new("an RPDO can carry two bytes", "an object of the description", "none");
        return Err(Stop::NotApplicable(reason));
    };
    bench.set_mapping(RPDO, &[mapped])?;
    bench.set_pdo(RPDO, &[(2, &[255])])?;
    let can_id = (bench.pdo_cob_id(RPDO)?.can_id() & 0x7FF) as u16;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    bench.send_bytes(can_id, &[0])?;
    let heard = emergencies(bench, Duration::from_millis(200))?;
    let Some(second) = error_codes(&heard).last().copied() else {
        let reason = Reason::new("an RPDO that is too short is an error", "an EMCY", "none: there is no second error");
        return Err(Stop::NotApplicable(reason));
    };
    expect_code(bench, NEWEST, second, "the newest error comes first")?;
    expect_code(bench, BEFORE_NEWEST, first, "the error before the newest is at 1003h:02")
}

/// 1003h:00 never counts more errors than the error history has entries.
#[case(id = "301/error-history/full", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Must,
       needs = [ErrorHistory, Monitoring, Description], catches = [ErrorHistoryOverflows])]
fn full(bench: &mut Bench<'_>) -> Judged {
    let entries = bench.target().description.as_ref().map_or(0, |description| {
        description
            .dictionary
            .entries()
            .filter(|(at, _)| at.index.0 == object::PREDEFINED_ERROR_FIELD && at.sub.0 > 0)
            .count()
    });
    if entries < 2 {
        let reason = Reason::new("the description names the entries of 1003h", "two or more", entries.to_string());
        return Err(Stop::NotApplicable(reason));
    }
    clear(bench)?;
    let monitored = begin_monitoring(bench)?;
    reported(bench)?;
    for _ in 0..entries.min(16) {
        sign_of_life(bench, monitored)?;
        bench.listen(Duration::from_millis(330))?;
    }
    let count = bench.read_number(COUNT)?;
    demand(count as usize <= entries, || {
        Breach::new(COUNT, "1003h:00 counts the errors in the history")
            .expected(Allowed::Described(format!("{entries} at most").into()))
            .found(Observation::Number(u64::from(count)))
    })?;
    let last = Multiplexer::new(object::PREDEFINED_ERROR_FIELD, u8::try_from(count).unwrap_or(u8::MAX).max(1));
    bench.upload(last)?.value()?;
    Ok(())
}

/// Writing an entry of the error history is refused with abort 0601 0002h.
#[case(id = "301/error-history/read-only", clause = "CiA 301 7.5.2.4", confidence = Cited, level = Must,
       needs = [ErrorHistory], catches = [SdoReadOnlyWritable, SdoReadOnlyWrongCode], cct = "4.3")]
fn read_only(bench: &mut Bench<'_>) -> Judged {
    let attempt = bench.download(NEWEST, &[0; 4])?;
    bench.check(attempt.refused(Situation::ReadOnly))
}

/// An error that occurs in stopped, where the device may send no EMCY, is in the error history afterwards. The standard
/// leaves this open: the history contains the errors that were signalled, and the EMCY is delayed or not sent at all.
#[case(id = "301/state/stopped/error-history", clause = "CiA 301 7.3.2.2.4", confidence = Cited, level = Open,
       needs = [ErrorHistory, Monitoring], catches = [EmcyLostWhenStopped, ErrorHistoryNotKept, LifeGuardingUnreported])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    clear(bench)?;
    begin_monitoring(bench)?;
    bench.command(Command::STOP)?;
    bench.listen(UNTIL_LOST)?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(Duration::from_millis(200))?;
    let value = bench.upload(COUNT)?.value()?;
    bench.check(demand(value.first().is_some_and(|&count| count > 0), || {
        Breach::new(COUNT, "an error that occurred in stopped is in 1003h")
            .expected("1003h:00 of 1 or more")
            .found(Observation::Value(value))
    }))
}
