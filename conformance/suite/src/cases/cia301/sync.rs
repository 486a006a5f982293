//! SYNC: 1005h, 1006h and 1019h (CiA 301, 7.2.5).

use crate::bench::Bench;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::wire::{emcy, sync};
use canvass_bus::client::sdo::Bytes;
use canvass_traces::{Duration, Record};

const COB_ID: Multiplexer = Multiplexer::new(0x1005, 0);
const PERIOD: Multiplexer = Multiplexer::new(0x1006, 0);
const OVERFLOW: Multiplexer = Multiplexer::new(0x1019, 0);
/// Bit 30 of 1005h: the device produces SYNC.
const PRODUCES: u32 = 1 << 30;
const PERIOD_US: u32 = 50_000;
const PERIOD_TIME: Duration = Duration::from_millis(50);

/// Lets the device produce SYNC every 50 ms, with a counter if `overflow` is not 0.
fn produce(bench: &mut Bench<'_>, overflow: u8) -> Result<(), Stop> {
    let own = bench.read_number(COB_ID)?;
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    if bench.has(OVERFLOW)? {
        bench.write(OVERFLOW, &[overflow])?;
    }
    bench.write(PERIOD, &PERIOD_US.to_le_bytes())?;
    bench.write(COB_ID, &(own | PRODUCES).to_le_bytes())
}

fn syncs(bench: &mut Bench<'_>, periods: u64) -> Result<Vec<Record>, Stop> {
    bench.frames_of(sync::CAN_ID, PERIOD_TIME.times(periods))
}

fn data(records: &[Record]) -> String {
    let shown: Vec<String> = records.iter().take(12).map(|record| Bytes(record.data()).to_string()).collect();
    if shown.is_empty() { "no SYNC".to_owned() } else { shown.join(", ") }
}

/// A producer sends SYNC at the period that 1006h says, in microseconds.
#[case(id = "301/sync/period", clause = "CiA 301 7.5.2.6", confidence = Derived, level = Must,
       needs = [SyncProducer], catches = [SyncPeriodDoubled], cct = "6.2")]
fn period(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 0)?;
    syncs(bench, 2)?;
    let heard = syncs(bench, 20)?;
    let gaps = u64::try_from(heard.len().saturating_sub(1)).unwrap_or(0);
    let span = heard.first().zip(heard.last()).map(|(first, last)| last.timestamp.since(first.timestamp));
    let mean = span.filter(|_| gaps > 0).map(|span| Duration::from_nanos(span.nanos() / gaps));
    let tolerance = bench.timing().tolerance(PERIOD_TIME);
    if let Some(mean) = mean {
        bench.measure("SYNC period, mean", mean);
    }
    bench.check(demand(
        mean.is_some_and(|mean| mean.nanos().abs_diff(PERIOD_TIME.nanos()) <= tolerance.nanos()),
        || {
            let actual = mean.map_or_else(|| format!("{} SYNCs", heard.len()), |mean| mean.to_string());
            let expected = format!("{PERIOD_TIME} ± {tolerance} on average");
            Reason::new(format!("with 1006h = {PERIOD_US} SYNC comes every {PERIOD_TIME}"), expected, actual)
        },
    ))
}

/// With 1006h = 0 no SYNC is produced.
#[case(id = "301/sync/off", clause = "CiA 301 7.5.2.6", confidence = Derived, level = Must,
       needs = [SyncProducer], catches = [SyncNotStopped], cct = "6.4")]
fn off(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 0)?;
    let before = syncs(bench, 4)?;
    demand(!before.is_empty(), || Reason::new("SYNC is produced", "one every 50 ms", "none in 200 ms"))
        .or_inconclusive()?;
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    bench.listen(bench.timing().reaction)?;
    let after = syncs(bench, 6)?;
    bench.check(demand(after.is_empty(), || {
        Reason::new("with 1006h = 0 no SYNC is produced", "silence", format!("{} SYNCs in 300 ms", after.len()))
    }))
}

/// In stopped no SYNC is produced; in pre-operational and operational it is.
#[case(id = "301/state/stopped/sync", clause = "CiA 301 7.3.2.2.5", confidence = Known, level = Must,
       needs = [SyncProducer], catches = [SyncWhenStopped], cct = "9.4")]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 0)?;
    for command in [Command::ENTER_PRE_OPERATIONAL, Command::START] {
        bench.command(command)?;
        bench.listen(bench.timing().reaction)?;
        let heard = syncs(bench, 4)?;
        let duty = format!("SYNC is produced after {command}");
        demand(!heard.is_empty(), || Reason::new(duty, "one every 50 ms", "none in 200 ms")).or_inconclusive()?;
    }
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    let heard = syncs(bench, 6)?;
    bench.check(demand(heard.is_empty(), || {
        Reason::new("no SYNC is produced in stopped", "silence", format!("{} SYNCs in 300 ms", heard.len()))
    }))
}

/// With a counter (1019h) SYNC has one byte that counts from 1 to the overflow value and begins anew.
#[case(id = "301/sync/counter", clause = "CiA 301 7.2.5", confidence = Known, level = Must,
       needs = [SyncProducer, SyncCounter], catches = [SyncCounterFromZero], cct = "6.7")]
fn counter(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 5)?;
    let heard = syncs(bench, 13)?;
    let bytes: Vec<&[u8]> = heard.iter().map(Record::data).collect();
    let is_right = |pair: &[&[u8]]| match pair {
        [[before], [now]] => (1..=5).contains(before) && *now == before % 5 + 1,
        _ => false,
    };
    bench.check(demand(bytes.len() > 6 && bytes.windows(2).all(is_right), || {
        Reason::new("with 1019h = 5 SYNC counts from 1 to 5", "1, 2, 3, 4, 5, 1, …", data(&heard))
    }))
}

/// The counter begins with 1 when the device leaves stopped.
#[case(id = "301/sync/counter-restarts", clause = "CiA 301 7.2.5", confidence = Known, level = Should,
       needs = [SyncProducer, SyncCounter], catches = [SyncCounterNotReset, NmtStartWhenStoppedIgnored, SyncWhenStopped])]
fn counter_restarts(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 240)?;
    syncs(bench, 5)?;
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    bench.command(Command::START)?;
    let heard = syncs(bench, 4)?;
    bench.check(demand(heard.first().is_some_and(|record| record.data() == [1]), || {
        Reason::new("after stopped the SYNC counter begins with 1", "01", data(&heard))
    }))
}

/// Without a counter (1019h = 0) SYNC carries no data.
#[case(id = "301/sync/no-counter", clause = "CiA 301 7.2.5", confidence = Known, level = Must,
       needs = [SyncProducer], catches = [SyncAlwaysCounts], cct = "6.6")]
fn no_counter(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 0)?;
    let heard = syncs(bench, 6)?;
    bench.check(demand(!heard.is_empty() && heard.iter().all(|record| record.data().is_empty()), || {
        Reason::new("without counter SYNC has no data", "empty frames", data(&heard))
    }))
}

/// 1019h takes 0 and 2 to 240; 1 and 241 to 255 are refused with abort 0609 0030h.
#[case(id = "301/sync/overflow-range", clause = "CiA 301 7.5.2.22", confidence = Derived, level = Must,
       needs = [SyncCounter], catches = [SyncOverflowUnchecked], cct = "6.5")]
fn overflow_range(bench: &mut Bench<'_>) -> Judged {
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    for wrong in [1_u8, 241, 255] {
        let attempt = bench.download(OVERFLOW, &[wrong])?;
        bench.check(attempt.refused(Situation::InvalidValue))?;
    }
    for right in [2_u8, 240, 0] {
        bench.download(OVERFLOW, &[right])?.expect_confirmation()?;
    }
    Ok(())
}

/// While 1006h is not 0, 1019h can't be changed: abort 0800 0022h.
#[case(id = "301/sync/overflow-while-running", clause = "CiA 301 7.5.2.22", confidence = Derived, level = Must,
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

/// While the device produces SYNC, its CAN-ID can't be changed: abort 0609 0030h.
#[case(id = "301/sync/cob-id-while-producing", clause = "CiA 301 7.5.2.5", confidence = Derived, level = Must,
       needs = [SyncProducer], catches = [SyncIdChangeWhileProducing])]
fn cob_id_while_producing(bench: &mut Bench<'_>) -> Judged {
    produce(bench, 0)?;
    let own = bench.read(COB_ID)?;
    let other = crate::bench::sdo::number(&own) & !0x7FF | 0x0A0;
    let attempt = bench.download(COB_ID, &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::InvalidValue))?;
    bench.expect_unchanged(COB_ID, &own)?;
    bench.write(COB_ID, &(crate::bench::sdo::number(&own) & !PRODUCES).to_le_bytes())?;
    Ok(())
}

/// 1005h names the predefined CAN-ID 080h as delivered.
#[case(id = "301/sync/cob-id", clause = "CiA 301 7.5.2.5", confidence = Derived, level = Must,
       needs = [Sync], catches = [SyncIdWrong], cct = "6.1")]
fn cob_id(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.check(demand(own & 0x1FFF_FFFF == u32::from(sync::CAN_ID), || {
        Reason::new("1005h names the predefined CAN-ID", "080h", format!("{own:08X}h"))
    }))
}

/// A consumer that expects a counter takes SYNC of another length than one byte for wrong: it sends no TPDO.
#[case(id = "301/sync/wrong-length", clause = "CiA 301 7.2.7", confidence = Attested, level = Must,
       needs = [SyncCounter, Tpdo, DynamicMapping], catches = [SyncLengthUnchecked])]
fn wrong_length(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    bench.write(OVERFLOW, &[10])?;
    bench.set_pdo(TPDO, &[(2, &[1])])?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    bench.send_bytes(sync::CAN_ID, &[1])?;
    let right = bench.frames_of(can_id, Duration::from_millis(50))?;
    demand(!right.is_empty(), || Reason::new("SYNC with a counter is obeyed", "a TPDO", "none")).or_inconclusive()?;
    for wrong in [&[][..], &[2, 0]] {
        bench.drain()?;
        bench.send_bytes(sync::CAN_ID, wrong)?;
        let heard = bench.listen(Duration::from_millis(50))?;
        let pdos = heard.iter().filter(|record| record.frame.cob_id() == Some(can_id)).count();
        demand(pdos == 0, || {
            let duty = format!("SYNC of {} bytes is not obeyed where a counter is expected", wrong.len());
            Reason::new(duty, "no TPDO", format!("{pdos} TPDO"))
        })?;
        let emcy_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
        if !heard.iter().any(|record| record.frame.cob_id() == Some(emcy_id)) {
            bench.note(format!("SYNC of {} bytes is not reported by EMCY 8240h", wrong.len()));
        }
    }
    Ok(())
}

/// A device that only consumes SYNC refuses to produce it: abort 0609 0030h for bit 30 of 1005h.
#[case(id = "301/sync/consumer-only", clause = "CiA 301 7.5.2.5", confidence = Derived, level = Should,
       needs = [Sync], catches = [SyncProducerBitAccepted])]
fn consumer_only(bench: &mut Bench<'_>) -> Judged {
    if bench.has(PERIOD)? && bench.target().description.is_none() {
        let reason = Reason::new("the device is known to be no producer", "a description", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let own = bench.read_number(COB_ID)?;
    // Where nothing of 1005h can be changed, that is the reason to refuse.
    let strict = if bench.can_write(COB_ID)? { AbortCode::INVALID_VALUE } else { AbortCode::READ_ONLY };
    let attempt = bench.download(COB_ID, &(own | PRODUCES).to_le_bytes())?;
    if attempt.abort().is_none() {
        // A producer, then: it must produce.
        bench.write(COB_ID, &own.to_le_bytes())?;
        produce(bench, 0)?;
        let heard = syncs(bench, 6)?;
        return bench.check(demand(!heard.is_empty(), || {
            let duty = "a device that takes bit 30 of 1005h produces SYNC";
            Reason::new(duty, "SYNC, or abort 0609 0030h", "confirmation, but no SYNC")
        }));
    }
    bench.check(attempt.refused_with(&[strict], &[AbortCode::INVALID_VALUE, AbortCode::READ_ONLY, AbortCode::GENERAL]))
}

/// The synchronous counter overflow value that was stored is there after reset node. The old one is stored again.
#[case(id = "301/sync/overflow-stored", clause = "CiA 301 7.5.2.22", confidence = Derived, level = Must,
       needs = [SyncCounter, Store], touches = [Nvm], catches = [StoreWithoutEffect], cct = "6.8")]
fn overflow_stored(bench: &mut Bench<'_>) -> Judged {
    const STORE: Multiplexer = Multiplexer::new(0x1010, 1);
    bench.write(PERIOD, &0_u32.to_le_bytes())?;
    let before = bench.read(OVERFLOW)?;
    let other = if before == [10] { [20] } else { [10] };
    bench.write(OVERFLOW, &other)?;
    bench.write(STORE, b"save")?;
    let stored = bench.reset(Command::RESET_NODE).and_then(|()| bench.read(OVERFLOW));
    // Whatever came of it, the device gets its old value back.
    bench.write(OVERFLOW, &before)?;
    bench.write(STORE, b"save")?;
    let stored = stored?;
    bench.check(demand(stored == other, || {
        let duty = "1019h has its stored value after reset node";
        Reason::new(duty, Bytes(&other).to_string(), Bytes(&stored).to_string())
    }))
}
