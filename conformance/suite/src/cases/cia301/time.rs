//! TIME: 1012h (CiA 301, 7.2.6).

use crate::bench::Bench;
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::dictionary::{DataType, Entry};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::time;
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

const COB_ID: Multiplexer = Multiplexer::new(object::COB_ID_TIME, 0);
/// Bit 31 of 1012h: the device consumes TIME.
const CONSUMES: u32 = 1 << 31;
/// Bit 30 of 1012h: the device produces TIME.
const PRODUCES: u32 = 1 << 30;
/// Maximum difference of the device's clock, since answers take time.
const CLOCK_ERROR_MS: u64 = 200;

/// Switches a direction of TIME on; not applicable if the device refuses it in the way of a device without this
/// direction.
fn switch_on(bench: &mut Bench<'_>, bit: u32, what: &str) -> Result<(), Stop> {
    let own = bench.read_number(COB_ID)?;
    let attempt = bench.download(COB_ID, &(own & !(CONSUMES | PRODUCES) | bit).to_le_bytes())?;
    let Some(code) = attempt.abort() else { return Ok(()) };
    bench.check(attempt.refused(Situation::InvalidValue))?;
    let duty = format!("the device {what} TIME");
    Err(Stop::NotApplicable(Reason::new(duty, "a bit of 1012h that can be set", code.to_string())))
}

/// 1012h holds the predefined CAN-ID 100h as delivered.
#[case(id = "301/time/cob-id", clause = "CiA 301 7.5.2.15", confidence = Cited, level = Must,
       needs = [Time], catches = [TimeIdWrong])]
fn cob_id(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read(COB_ID)?;
    bench.check(demand(number(&own) & 0x1FFF_FFFF == u32::from(time::CAN_ID), || {
        let breach = Breach::new(COB_ID, "1012h holds the predefined CAN-ID of TIME").expected("100h in bits 0 to 28");
        breach.found(Observation::Value(own))
    }))
}

/// The CAN-ID of TIME does not change while the device consumes or produces TIME: the device refuses the write.
#[case(id = "301/time/cob-id-while-valid", clause = "CiA 301 7.5.2.15", confidence = Cited, level = Must,
       needs = [Time], catches = [TimeIdChangeWhileValid])]
fn cob_id_while_valid(bench: &mut Bench<'_>) -> Judged {
    match switch_on(bench, CONSUMES, "consumes") {
        Err(Stop::NotApplicable(_)) => switch_on(bench, PRODUCES, "produces or consumes")?,
        switched => switched?,
    }
    let own = bench.read(COB_ID)?;
    let other = number(&own) & !0x7FF | 0x6A0;
    let attempt = bench.download(COB_ID, &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
    bench.expect_unchanged(COB_ID, &own)
}

/// The device refuses restricted CAN-IDs for TIME.
#[case(id = "301/time/restricted", clause = "CiA 301 7.3.5", confidence = Cited, level = Must,
       needs = [Time], catches = [RestrictedCanIdAccepted], cct = "8.10")]
fn restricted(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.write(COB_ID, &(own & !(CONSUMES | PRODUCES)).to_le_bytes())?;
    bench.each([0x001_u32, 0x101, 0x581, 0x601, 0x6E0, 0x701], |bench, can_id| {
        let attempt = bench.download(COB_ID, &(CONSUMES | can_id).to_le_bytes())?;
        bench.check(attempt.refused(Situation::RestrictedCanId))
    })
}

/// The case only records whether a TIME consumer adopts the received time, so that an object of type TIME_OF_DAY in the
/// description shows it. Each device decides how it uses TIME.
#[case(id = "301/time/consumer", clause = "CiA 301 7.2.6.1", confidence = Cited, level = Open,
       needs = [Time, Description], catches = [TimeIgnored, ClockStands])]
fn consumer(bench: &mut Bench<'_>) -> Judged {
    switch_on(bench, CONSUMES, "consumes")?;
    let clock = bench.target().description.as_ref().and_then(|description| {
        let is_clock = |entry: &Entry| entry.data_type == DataType::TIME_OF_DAY && entry.access.is_readable();
        description.dictionary.entries().find(|(_, entry)| is_clock(entry)).map(|(at, _)| at)
    });
    let Some(clock) = clock else {
        let reason = Reason::new("the device shows its time", "an object of type TIME_OF_DAY", "none is described");
        return Err(Stop::NotApplicable(reason));
    };
    // 06:00 on 1 January 2020: 28 bits of milliseconds since midnight, days since 1 January 1984.
    let (milliseconds, days) = (6 * 3_600_000_u32, 13_149_u16);
    let [a, b, c, d] = milliseconds.to_le_bytes();
    let [low, high] = days.to_le_bytes();
    let own = bench.read_number(COB_ID)?;
    bench.send_bytes((own & 0x7FF) as u16, &[a, b, c, d, low, high])?;
    let sent = bench.now();
    // Soon after the message, and later, when the clock has advanced.
    bench.each([bench.timing().reaction, Duration::from_secs(3)], |bench, span| {
        bench.listen(span)?;
        let value = bench.upload(clock)?.value()?;
        let passed = bench.now().since(sent).nanos() / 1_000_000;
        let shown = number(&value) & 0x0FFF_FFFF;
        let is_near = u64::from(shown).abs_diff(u64::from(milliseconds) + passed) <= CLOCK_ERROR_MS;
        bench.check(demand(is_near && value.get(4..6) == Some(&[low, high]), || {
            let expected = format!("{} ms, and six bytes that end in {}", milliseconds, Bytes(&[low, high]));
            Breach::new(clock, format!("{clock} follows a TIME message, {passed} ms later"))
                .expected(expected)
                .found(Observation::Value(value))
        }))
    })
}

/// The case only records whether a device that accepts bit 30 of 1012h sends TIME within 5 s on the CAN-ID in 1012h,
/// because CiA 301 does not say when a producer sends it.
#[case(id = "301/time/produced", clause = "CiA 301 7.5.2.15", confidence = Cited, level = Open,
       needs = [Time], catches = [TimeNotProduced])]
fn produced(bench: &mut Bench<'_>) -> Judged {
    switch_on(bench, PRODUCES, "produces")?;
    let can_id = (bench.read_number(COB_ID)? & 0x7FF) as u16;
    let heard = bench.frames_of(can_id, Duration::from_secs(5))?;
    bench.check(demand(!heard.is_empty(), || {
        let breach = Breach::new(COB_ID, format!("TIME comes on CAN-ID {can_id:03X}h within 5 s of bit 30"));
        breach.expected("TIME").found(Observation::Silence)
    }))?;
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    let heard = bench.frames_of(can_id, Duration::from_secs(5))?;
    bench.check(demand(heard.is_empty(), || {
        let breach = Breach::new(COB_ID, "no TIME comes in stopped").expected(Observation::Silence);
        breach.found(Observation::Count(heard.len() as u64))
    }))
}

/// After bit 30 of 1012h was set back to 0 the device sends no TIME.
#[case(id = "301/time/off", clause = "CiA 301 7.5.2.15", confidence = Cited, level = Must,
       needs = [Time], catches = [TimeNotStopped])]
fn off(bench: &mut Bench<'_>) -> Judged {
    const SPAN: Duration = Duration::from_secs(5);
    switch_on(bench, PRODUCES, "produces")?;
    let own = bench.read_number(COB_ID)?;
    let can_id = (own & 0x7FF) as u16;
    let before = bench.frames_of(can_id, SPAN)?.len();
    demand(before > 0, || {
        Breach::new(COB_ID, "TIME comes within 5 s of bit 30").expected("TIME").found(Observation::Silence)
    })
    .or_inconclusive()?;
    bench.write(COB_ID, &(own & !PRODUCES).to_le_bytes())?;
    bench.listen(bench.timing().reaction)?;
    let after = bench.frames_of(can_id, SPAN)?.len();
    bench.check(demand(after == 0, || {
        let breach = Breach::new(COB_ID, "without bit 30 of 1012h no TIME is sent, in 5 s");
        breach.expected(Observation::Silence).found(Observation::Count(after as u64))
    }))
}

/// The case only records whether the high resolution time stamp, 1013h, increases by one per microsecond after it was
/// written, because its use is left to the device.
#[case(id = "301/time/high-resolution", clause = "CiA 301 7.5.2.16", confidence = Cited, level = Open,
       needs = [], catches = [ClockStands, StampSetByOthers])]
fn high_resolution(bench: &mut Bench<'_>) -> Judged {
    const STAMP: Multiplexer = Multiplexer::new(object::HIGH_RESOLUTION_TIME_STAMP, 0);
    if !bench.can_write(STAMP)? {
        return Err(Stop::NotApplicable(Reason::new("the device has a time stamp", "1013h, writable", "none")));
    }
    let written = 5_000_000_u32;
    bench.write(STAMP, &written.to_le_bytes())?;
    let from = bench.now();
    bench.listen(Duration::from_millis(500))?;
    // Writes of other objects do not matter here.
    let own = bench.read(COB_ID)?;
    bench.download(COB_ID, &own)?;
    if let Some(other) = bench.scratch_objects()?.into_iter().next() {
        bench.write(other.multiplexer, &other.other)?;
    }
    let shown = bench.read_number(STAMP)?;
    let passed = bench.now().since(from).nanos() / 1_000;
    let is_near = u64::from(shown.wrapping_sub(written)).abs_diff(passed) <= 1_000 * CLOCK_ERROR_MS;
    bench.check(demand(is_near, || {
        Breach::new(STAMP, format!("1013h counts on from {written}, {passed} µs later"))
            .expected(Observation::Number(u64::from(written) + passed))
            .found(Observation::Number(shown.into()))
    }))
}

/// A TIME producer sends six bytes. The four reserved bits above the milliseconds are 0.
///
/// CiA 301 leaves the value of reserved bits undefined, but consumers rely on 0.
#[case(id = "301/time/producer", clause = "CiA 301 7.2.6.3.1", confidence = Cited, level = Should,
       needs = [Time], catches = [TimeReservedBitsSet])]
fn producer(bench: &mut Bench<'_>) -> Judged {
    switch_on(bench, PRODUCES, "produces")?;
    let heard = bench.frames_of(time::CAN_ID, Duration::from_secs(5))?;
    if heard.is_empty() {
        return Err(Stop::Inconclusive(Reason::new("the device produces TIME", "one within 5 s", "none")));
    }
    let found = heard.iter().find_map(|record| match record.data() {
        [_, _, _, top, _, _] if top & 0xF0 == 0 => None,
        [_, _, _, _, _, _] => Some((Observation::named("reserved bits set"), record)),
        other => Some((Observation::Number(other.len() as u64), record)),
    });
    let Some((found, record)) = found else { return Ok(()) };
    let breach = Breach::new(Service::Time, "TIME has six bytes, of which bits 28 to 31 are 0");
    bench.check(Err(Box::new(breach.expected("six bytes").found(found).told(Bytes(record.data()).to_string()))))
}
