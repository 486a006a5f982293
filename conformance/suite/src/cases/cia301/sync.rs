//! SYNC: 1005h, 1006h and 1019h (CiA 301, 7.2.5).

use super::emcy::expect_no_error;
use crate::bench::Bench;
use crate::bench::pdo::{RPDO, TPDO};
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::wire::{emcy, sync};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record, Timestamp};

pub(super) const COB_ID: Multiplexer = Multiplexer::new(object::COB_ID_SYNC, 0);
const PERIOD: Multiplexer = Multiplexer::new(object::COMMUNICATION_CYCLE_PERIOD, 0);
const OVERFLOW: Multiplexer = Multiplexer::new(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0);
/// Bit 30 of 1005h: the device produces SYNC.
pub(super) const PRODUCES: u32 = 1 << 30;
const PERIOD_US: u32 = 50_000;
const PERIOD_TIME: Duration = Duration::from_millis(50);

/// Makes the device produce SYNC every 50 ms, with a counter if `overflow` is not 0; returns the CAN-ID of SYNC.
/// Objects that already have their value are not written.
pub(super) fn produce(bench: &mut Bench<'_>, overflow: u8) -> Result<u16, Stop> {
    let own = bench.read_number(COB_ID)?;
    bench.stop_sync_period()?;
    let changes = if bench.has(OVERFLOW)? { bench.read_number(OVERFLOW)? != u32::from(overflow) } else { overflow > 0 };
    if changes {
        bench.write(OVERFLOW, &[overflow])?;
    }
    bench.write(PERIOD, &PERIOD_US.to_le_bytes())?;
    bench.write_confirmed(COB_ID, &(own | PRODUCES).to_le_bytes())?;
    Ok((own & 0x7FF) as u16)
}

fn syncs(bench: &mut Bench<'_>, id: u16, periods: u64) -> Result<Vec<Record>, Stop> {
    bench.frames_of(id, PERIOD_TIME.times(periods))
}

fn data(records: &[Record]) -> String {
    let shown: Vec<String> = records.iter().take(12).map(|record| Bytes(record.data()).to_string()).collect();
    if shown.is_empty() { "no SYNC".to_owned() } else { shown.join(", ") }
}

/// The breach of a wrong number of SYNC messages: fewer than `least`, or more than `most`.
fn counted(duty: impl Into<String>, least: u64, most: Option<u64>, heard: &[Record]) -> Breach {
    let found = Observation::Count(heard.len() as u64);
    Breach::new(Service::Sync, duty.into()).expected(Allowed::Count { least, most }).found(found)
}

/// Requires a `first` SYNC within one period after bit 30 of 1005h was `set`.
fn begins_in_time(bench: &mut Bench<'_>, set: Timestamp, first: Option<&Record>) -> Judged {
    let took = first.map(|record| record.timestamp.since(set));
    let most = PERIOD_TIME + bench.tolerance(PERIOD_TIME) + bench.host_delay();
    bench.check(demand(took.is_some_and(|took| took <= most), || {
        Breach::new(Service::Sync, "the first SYNC comes within one period after bit 30 of 1005h is set")
            .expected(Allowed::Time { least: Duration::ZERO, most })
            .found(took.map_or(Observation::Silence, Observation::Time))
    }))
}

/// A SYNC producer sends SYNC with the period in microseconds that 1006h holds, the first within one period after bit
/// 30 of 1005h is set.
#[case(id = "301/sync/period", clause = "CiA 301 7.5.2.6", confidence = Cited, level = Must,
       needs = [SyncProducer], catches = [SyncPeriodDoubled, SyncHangsWithoutCounter], cct = "6.2")]
fn period(bench: &mut Bench<'_>) -> Judged {
    let was_off = bench.read_number(COB_ID)? & PRODUCES == 0;
    let id = produce(bench, 0)?;
    let set = bench.now();
    let first = syncs(bench, id, 2)?;
    if was_off {
        begins_in_time(bench, set, first.first())?;
    }
    let heard = syncs(bench, id, 20)?;
    let gaps = u64::try_from(heard.len().saturating_sub(1)).unwrap_or(0);
    let span = heard.first().zip(heard.last()).map(|(first, last)| last.timestamp.since(first.timestamp));
    let mean = span.filter(|_| gaps > 0).map(|span| Duration::from_nanos(span.nanos() / gaps));
    let tolerance = bench.timing().tolerance(PERIOD_TIME);
    if let Some(mean) = mean {
        bench.measure("SYNC period, mean", mean);
    }
    let is_right = mean.is_some_and(|mean| mean.nanos().abs_diff(PERIOD_TIME.nanos()) <= tolerance.nanos());
    bench.check(demand(is_right, || {
        let least = Duration::from_nanos(PERIOD_TIME.nanos() - tolerance.nanos());
        Breach::new(PERIOD, format!("with 1006h = {PERIOD_US} SYNC comes every {PERIOD_TIME} on average"))
            .expected(Allowed::Time { least, most: PERIOD_TIME + tolerance })
            .found(mean.map_or(Observation::Count(heard.len() as u64), Observation::Time))
            .over(gaps)
    }))
}

/// With 1006h = 0 the device produces no SYNC.
#[case(id = "301/sync/off", clause = "CiA 301 7.5.2.6", confidence = Cited, level = Must,
       needs = [SyncProducer], catches = [SyncNotStopped], cct = "6.4")]
fn off(bench: &mut Bench<'_>) -> Judged {
    let id = produce(bench, 0)?;
    let before = syncs(bench, id, 4)?;
    demand(!before.is_empty(), || counted("SYNC is produced every 50 ms, in 200 ms", 1, None, &before))
        .or_inconclusive()?;
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    bench.listen(bench.timing().reaction)?;
    let after = syncs(bench, id, 6)?;
    bench.check(demand(after.is_empty(), || {
        counted("with 1006h = 0 no SYNC is produced, in 300 ms", 0, Some(0), &after)
    }))
}

/// A device with a valid PDO of a synchronous transmission type, 0 to 240, has 1005h. The case reads the transmission
/// types of the first four PDOs of each direction as delivered. A PDO that is switched off proves nothing: its type may
/// be 0 for want of a value.
#[case(id = "301/sync/object", clause = "CiA 301 7.5.2.5", confidence = Cited, level = Must,
       needs = [], catches = [SyncObjectMissing])]
fn object_exists(bench: &mut Bench<'_>) -> Judged {
    let mut synchronous = None;
    for pdo in (1..=4).flat_map(|number| [TPDO.numbered(number), RPDO.numbered(number)]) {
        let [cob_id, transmission_type] = [pdo.parameter(1), pdo.parameter(2)];
        if synchronous.is_some() || !bench.has(cob_id)? || !bench.has(transmission_type)? {
            continue;
        }
        if bench.pdo_cob_id(pdo)?.is_valid() && bench.read_number(transmission_type)? <= 240 {
            synchronous = Some(pdo);
        }
    }
    let Some(pdo) = synchronous else {
        let reason = Reason::new("a PDO is synchronous as delivered", "one of the first four", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let attempt = bench.upload(COB_ID)?;
    let Some(code) = attempt.abort() else { return attempt.value().map(|_| ()).map_err(Into::into) };
    bench.check(Err(Box::new(
        Breach::new(COB_ID, format!("1005h exists, as {} is synchronous", pdo.subject()))
            .expected("a value")
            .found(Observation::Abort(code)),
    )))
}

/// While bit 30 of 1005h is 0 the device produces no SYNC, whatever period 1006h holds.
///
/// A SYNC is the device's own only if none comes before 1006h holds a period, and none after it is 0 again.
#[case(id = "301/sync/not-asked", clause = "CiA 301 7.5.2.5", confidence = Cited, level = Must,
       needs = [SyncProducer], catches = [SyncProducedUnasked])]
fn not_asked(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)? & !PRODUCES;
    let id = (own & 0x7FF) as u16;
    bench.stop_sync_period()?;
    for cob_id in [own | PRODUCES, own] {
        bench.write(COB_ID, &cob_id.to_le_bytes())?;
    }
    no_other_producer(bench, id, "before 1006h holds a period")?;
    bench.write(PERIOD, &PERIOD_US.to_le_bytes())?;
    let heard = syncs(bench, id, 6)?;
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    bench.listen(bench.timing().reaction)?;
    no_other_producer(bench, id, "after 1006h is 0 again")?;
    bench.check(demand(heard.is_empty(), || {
        counted("without bit 30 of 1005h no SYNC is produced, in 300 ms", 0, Some(0), &heard)
    }))
}

fn no_other_producer(bench: &mut Bench<'_>, id: u16, when: &str) -> Judged {
    let heard = syncs(bench, id, 6)?;
    demand(heard.is_empty(), || counted(format!("no SYNC comes {when}, in 300 ms"), 0, Some(0), &heard))
        .or_inconclusive()
}

/// The device produces SYNC in pre-operational and operational, but not in stopped.
#[case(id = "301/state/stopped/sync", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       needs = [SyncProducer], catches = [SyncWhenStopped, SyncHangsWithoutCounter], cct = "9.4")]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    let id = produce(bench, 0)?;
    for command in [Command::ENTER_PRE_OPERATIONAL, Command::START] {
        bench.command(command)?;
        bench.listen(bench.timing().reaction)?;
        let heard = syncs(bench, id, 4)?;
        let duty = || format!("SYNC is produced after {command}, every 50 ms, in 200 ms");
        demand(!heard.is_empty(), || counted(duty(), 1, None, &heard)).or_inconclusive()?;
    }
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    let heard = syncs(bench, id, 6)?;
    bench.check(demand(heard.is_empty(), || counted("no SYNC is produced in stopped, in 300 ms", 0, Some(0), &heard)))
}

/// With a counter (1019h) SYNC has one byte, which counts from 1 to the overflow value and starts again.
#[case(id = "301/sync/counter", clause = "CiA 301 7.2.5.2.2", confidence = Cited, level = Must,
       needs = [SyncProducer, SyncCounter], catches = [SyncCounterFromZero], cct = "6.7")]
fn counter(bench: &mut Bench<'_>) -> Judged {
    let id = produce(bench, 5)?;
    let heard = syncs(bench, id, 13)?;
    bench.check(demand(heard.len() > 6, || {
        counted("SYNC with a counter is produced every 50 ms, in 650 ms", 7, None, &heard)
    }))?;
    let mut before = None;
    let wrong = heard.iter().find(|record| {
        let is_right = match *record.data() {
            [now] => (1..=5).contains(&now) && before.is_none_or(|before| now == before % 5 + 1),
            _ => false,
        };
        before = record.data().first().copied();
        !is_right
    });
    bench.check(demand(wrong.is_none(), || {
        let found = wrong.map_or(Observation::Silence, |record| Observation::Value(record.data().to_vec()));
        let breach = Breach::new(OVERFLOW, "with 1019h = 5 SYNC counts from 1 to 5");
        breach.expected("1, 2, 3, 4, 5, 1, …").found(found).told(data(&heard))
    }))
}

/// The SYNC counter starts with 1 when the device leaves stopped.
#[case(id = "301/sync/counter-restarts", clause = "CiA 301 7.2.5.2.2", confidence = Cited, level = Must,
       needs = [SyncProducer, SyncCounter], catches = [SyncCounterNotReset, NmtStartWhenStoppedIgnored, SyncWhenStopped])]
fn counter_restarts(bench: &mut Bench<'_>) -> Judged {
    let id = produce(bench, 240)?;
    syncs(bench, id, 5)?;
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    bench.command(Command::START)?;
    let heard = syncs(bench, id, 4)?;
    let found = heard.first().map_or(Observation::Silence, |record| Observation::Value(record.data().to_vec()));
    bench.check(demand(found == Observation::Value(vec![1]), || {
        let breach = Breach::new(Service::Sync, "after the state stopped the SYNC counter begins with 1");
        breach.expected(Observation::Value(vec![1])).found(found).told(data(&heard))
    }))
}

/// Without a counter (1019h = 0) SYNC carries no data, with any CAN-ID.
#[case(id = "301/sync/no-counter", clause = "CiA 301 7.5.2.22", confidence = Cited, level = Must,
       needs = [SyncProducer], catches = [SyncAlwaysCounts, SyncMovedCounts], cct = "6.6")]
fn no_counter(bench: &mut Bench<'_>) -> Judged {
    let id = produce(bench, 0)?;
    let heard = syncs(bench, id, 6)?;
    bench.check(demand(!heard.is_empty(), || counted("SYNC is produced every 50 ms, in 300 ms", 1, None, &heard)))?;
    has_no_data(bench, &heard)?;
    let own = bench.read_number(COB_ID)?;
    bench.write(COB_ID, &(own & !PRODUCES).to_le_bytes())?;
    // This case does not judge whether the CAN-ID can be changed at all.
    let moved = own & !0x7FF & !PRODUCES | u32::from(MOVED);
    if bench.download(COB_ID, &moved.to_le_bytes())?.abort().is_some() {
        return Ok(());
    }
    bench.write(COB_ID, &(moved | PRODUCES).to_le_bytes())?;
    let heard = syncs(bench, MOVED, 6)?;
    has_no_data(bench, &heard)
}

/// A CAN-ID that belongs to no predefined object and that CiA 301 does not restrict.
const MOVED: u16 = 0x6A1;

fn has_no_data(bench: &mut Bench<'_>, heard: &[Record]) -> Judged {
    let wrong = heard.iter().find(|record| !record.data().is_empty());
    bench.check(demand(wrong.is_none(), || {
        let found = wrong.map_or(0, |record| record.data().len() as u64);
        let breach = Breach::new(Service::Sync, "number of data bytes of a SYNC without counter");
        breach.expected(Observation::Number(0)).found(Observation::Number(found)).told(data(heard))
    }))
}

/// 1019h accepts 0 and 2 to 240. The reserved values 1 and 241 to 255 are refused with abort 0609 0030h.
#[case(id = "301/sync/overflow-range", clause = "CiA 301 7.5.2.22", confidence = Cited, level = Should,
       needs = [SyncCounter], catches = [SyncOverflowUnchecked], cct = "6.5")]
fn overflow_range(bench: &mut Bench<'_>) -> Judged {
    bench.stop_sync_period()?;
    bench.each([1_u8, 241, 255], |bench, wrong| {
        let attempt = bench.download(OVERFLOW, &[wrong])?;
        bench.check(attempt.refused(Situation::InvalidValue))
    })?;
    bench.each([2_u8, 240, 0], |bench, right| {
        let attempt = bench.download(OVERFLOW, &[right])?;
        bench.check(attempt.expect_confirmation())
    })
}

/// Writing 1019h while 1006h is not 0 is refused with abort 0800 0022h or 0800 0000h.
#[case(id = "301/sync/overflow-while-running", clause = "CiA 301 7.5.2.22", confidence = Cited, level = Must,
       needs = [SyncCounter], catches = [SyncOverflowChangeWhileProducing], cct = "6.9")]
fn overflow_while_running(bench: &mut Bench<'_>) -> Judged {
    bench.write(PERIOD, &PERIOD_US.to_le_bytes())?;
    let before = bench.read(OVERFLOW)?;
    let other = if before == [10] { 20 } else { 10 };
    let attempt = bench.download(OVERFLOW, &[other])?;
    bench.check(attempt.refused(Situation::OverflowWhilePeriod))?;
    bench.expect_unchanged(OVERFLOW, &before)?;
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    Ok(())
}

/// The CAN-ID of SYNC does not change while the device produces SYNC: the device refuses the write.
#[case(id = "301/sync/cob-id-while-producing", clause = "CiA 301 7.5.2.5", confidence = Cited, level = Must,
       needs = [SyncProducer], catches = [SyncIdChangeWhileProducing])]
fn cob_id_while_producing(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 0)?;
    let own = bench.read(COB_ID)?;
    let other = number(&own) & !0x7FF | 0x0A0;
    let attempt = bench.download(COB_ID, &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
    bench.expect_unchanged(COB_ID, &own)?;
    bench.write(COB_ID, &(number(&own) & !PRODUCES).to_le_bytes())?;
    Ok(())
}

/// 1005h holds the predefined CAN-ID 080h as delivered.
#[case(id = "301/sync/cob-id", clause = "CiA 301 7.5.2.5", confidence = Cited, level = Must,
       needs = [Sync], catches = [SyncIdWrong], cct = "6.1")]
fn cob_id(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read(COB_ID)?;
    bench.check(demand(number(&own) & 0x1FFF_FFFF == u32::from(sync::CAN_ID), || {
        let breach = Breach::new(COB_ID, "1005h holds the predefined CAN-ID of SYNC").expected("80h in bits 0 to 28");
        breach.found(Observation::Value(own))
    }))
}

/// The case only records whether a consumer that expects a counter follows a SYNC whose length is not one byte. Such a
/// consumer may report the SYNC by EMCY 8240h; the standard does not define whether the consumer then sends its TPDOs.
#[case(id = "301/sync/wrong-length", clause = "CiA 301 7.5.2.22", confidence = Cited, level = Open,
       needs = [SyncCounter, Tpdo, DynamicMapping], catches = [SyncLengthUnchecked])]
fn wrong_length(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    bench.stop_sync_period()?;
    bench.write(OVERFLOW, &[10])?;
    bench.set_pdo(TPDO, &[(2, &[1])])?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    let sync_id = bench.sync_id()?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    bench.send_bytes(sync_id, &[1])?;
    let right = bench.frames_of(can_id, bench.shortly())?;
    demand(!right.is_empty(), || counted("SYNC with a counter is followed by a TPDO", 1, Some(1), &right))
        .or_inconclusive()?;
    bench.each([&[][..], &[2, 0]], |bench, wrong| {
        bench.drain()?;
        bench.send_bytes(sync_id, wrong)?;
        let heard = bench.frames_of(can_id, bench.shortly())?;
        let emcy_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
        let told = bench.evidence().frames().any(|exhibit| exhibit.record.frame.cob_id() == Some(emcy_id));
        bench.note(match told {
            true => format!("SYNC of {} bytes: an EMCY", wrong.len()),
            false => format!("SYNC of {} bytes is not reported by EMCY 8240h", wrong.len()),
        });
        bench.check(demand(heard.is_empty(), || {
            let duty = format!("a consumer that expects a counter ignores SYNC of {} bytes", wrong.len());
            counted(duty, 0, Some(0), &heard)
        }))
    })
}

/// A SYNC with the expected length is no error: with it the device sends no EMCY for a protocol error (82xxh) and no
/// generic EMCY (10xxh).
#[case(id = "301/sync/no-error", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       needs = [Sync], catches = [RightSyncReported])]
fn no_error(bench: &mut Bench<'_>) -> Judged {
    bench.expect_plain_sync()?;
    let sync_id = bench.sync_id()?;
    bench.each([Command::ENTER_PRE_OPERATIONAL, Command::START], |bench, command| {
        expect_no_error(bench, "SYNC of the right length is no error", |bench| {
            bench.command(command)?;
            bench.listen(bench.timing().reaction)?;
            Ok((sync_id, Vec::new()))
        })
    })
}

/// A device that only consumes SYNC refuses to produce it: setting bit 30 of 1005h is refused with abort 0609 0030h.
#[case(id = "301/sync/consumer-only", clause = "CiA 301 7.5.2.5", confidence = Cited, level = Must,
       needs = [Sync], catches = [SyncProducerBitAccepted])]
fn consumer_only(bench: &mut Bench<'_>) -> Judged {
    if bench.has(PERIOD)? && bench.target().description.is_none() {
        let reason = Reason::new("the device is known to be no producer", "a description", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let own = bench.read_number(COB_ID)?;
    let attempt = bench.download(COB_ID, &(own | PRODUCES).to_le_bytes())?;
    if attempt.abort().is_none() {
        demand(bench.has(PERIOD)?, || {
            let breach = Breach::new(COB_ID, "a device that accepts bit 30 of 1005h has a period in 1006h");
            breach.expected("abort 0609 0030h").found(Observation::Confirmation)
        })?;
        // The device is a producer if it accepts the bit, so it must produce SYNC.
        bench.write(COB_ID, &own.to_le_bytes())?;
        let id = produce(bench, 0)?;
        let heard = syncs(bench, id, 6)?;
        return bench.check(demand(!heard.is_empty(), || {
            let breach = Breach::new(COB_ID, "a device that accepts bit 30 of 1005h produces SYNC");
            let breach = breach.expected("SYNC, or abort 0609 0030h").found(Observation::Silence);
            breach.told("confirmation, but no SYNC")
        }));
    }
    // If 1005h can't be changed at all, that is a valid reason to refuse, too.
    let is_named = attempt.abort() == Some(AbortCode::INVALID_VALUE);
    let situation = if is_named || bench.can_write(COB_ID)? { Situation::InvalidValue } else { Situation::ReadOnly };
    bench.check(attempt.refused(situation))
}

/// The case only records whether a stored synchronous counter overflow value is restored after reset node, because a
/// device does not have to store every parameter. The case stores the old value again.
#[case(id = "301/sync/overflow-stored", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Open,
       needs = [SyncCounter, Store], touches = [Nvm], catches = [StoreWithoutEffect], cct = "6.8")]
fn overflow_stored(bench: &mut Bench<'_>) -> Judged {
    const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
    bench.stop_sync_period()?;
    let before = bench.read(OVERFLOW)?;
    let other = if before == [10] { [20] } else { [10] };
    bench.write(OVERFLOW, &other)?;
    bench.write(STORE, b"save")?;
    let stored = bench.reset(Command::RESET_NODE).and_then(|()| bench.read(OVERFLOW));
    // The device gets its old value back, whether the check passed or not.
    bench.write(OVERFLOW, &before)?;
    bench.write(STORE, b"save")?;
    let stored = stored?;
    bench.check(demand(stored == other, || {
        Breach::new(OVERFLOW, "1019h has its stored value after reset node")
            .expected(Observation::Value(other.to_vec()))
            .found(Observation::Value(stored))
    }))
}
