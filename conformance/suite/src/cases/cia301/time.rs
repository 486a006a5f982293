//! TIME: 1012h (CiA 301, 7.2.6).

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{DataType, Entry};
use canvass_analyzer::wire::time;
use canvass_bus::client::sdo::Bytes;
use canvass_traces::Duration;

const COB_ID: Multiplexer = Multiplexer::new(0x1012, 0);
/// Bit 31 of 1012h: the device consumes TIME.
const CONSUMES: u32 = 1 << 31;
/// Bit 30 of 1012h: the device produces TIME.
const PRODUCES: u32 = 1 << 30;

/// Switches a direction of TIME on; not applicable where the device refuses.
fn switch_on(bench: &mut Bench<'_>, bit: u32, what: &str) -> Result<(), Stop> {
    let own = bench.read_number(COB_ID)?;
    let attempt = bench.download(COB_ID, &(own & !(CONSUMES | PRODUCES) | bit).to_le_bytes())?;
    match attempt.abort() {
        None => Ok(()),
        Some(code) => {
            let reason =
                Reason::new(format!("the device {what} TIME"), "a bit of 1012h that can be set", code.to_string());
            Err(Stop::NotApplicable(reason))
        }
    }
}

/// 1012h names the predefined CAN-ID 100h as delivered.
#[case(id = "301/time/cob-id", clause = "CiA 301 7.5.2.15", confidence = Derived, level = Must,
       needs = [Time], catches = [TimeIdWrong])]
fn cob_id(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.check(demand(own & 0x1FFF_FFFF == u32::from(time::CAN_ID), || {
        Reason::new("1012h names the predefined CAN-ID", "100h", format!("{own:08X}h"))
    }))
}

/// While TIME is consumed or produced, its CAN-ID can't be changed: abort 0609 0030h.
#[case(id = "301/time/cob-id-while-valid", clause = "CiA 301 7.5.2.15", confidence = Derived, level = Must,
       needs = [Time], catches = [TimeIdChangeWhileValid])]
fn cob_id_while_valid(bench: &mut Bench<'_>) -> Judged {
    switch_on(bench, CONSUMES, "consumes")?;
    let own = bench.read(COB_ID)?;
    let other = crate::bench::sdo::number(&own) & !0x7FF | 0x6A0;
    let attempt = bench.download(COB_ID, &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::InvalidValue))?;
    bench.expect_unchanged(COB_ID, &own)?;
    Ok(())
}

/// Restricted CAN-IDs are refused for TIME with abort 0609 0030h.
#[case(id = "301/time/restricted", clause = "CiA 301 7.3.5", confidence = Attested, level = Must,
       needs = [Time], catches = [RestrictedCanIdAccepted], cct = "8.10")]
fn restricted(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.write(COB_ID, &(own & !(CONSUMES | PRODUCES)).to_le_bytes())?;
    for can_id in [0x001_u32, 0x101, 0x581, 0x601, 0x6E0, 0x701] {
        let attempt = bench.download(COB_ID, &(CONSUMES | can_id).to_le_bytes())?;
        bench.check(attempt.refused(Situation::InvalidValue))?;
    }
    Ok(())
}

/// A consumer of TIME takes the time over: an object of type TIME_OF_DAY that the description names shows it.
#[case(id = "301/time/consumer", clause = "CiA 301 7.2.6", confidence = Known, level = Must,
       needs = [Time, Description], catches = [TimeIgnored, SdoUploadEndMissing, SdoAnnouncedSizeWrong, SdoSegmentLengthWrong])]
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
    bench.send_bytes(time::CAN_ID, &[a, b, c, d, low, high])?;
    bench.listen(bench.timing().reaction)?;
    let value = bench.upload(clock)?.value()?;
    bench.check(demand(value.get(4..6) == Some(&[low, high]), || {
        let expected = format!("six bytes that end in {}", Bytes(&[low, high]));
        Reason::new(format!("{clock} follows a TIME message"), expected, Bytes(&value).to_string())
    }))
}

/// A producer sends TIME of six bytes whose upper four bits of the milliseconds are 0.
#[case(id = "301/time/producer", clause = "CiA 301 7.2.6", confidence = Known, level = Must,
       needs = [Time], catches = [TimeReservedBitsSet])]
fn producer(bench: &mut Bench<'_>) -> Judged {
    switch_on(bench, PRODUCES, "produces")?;
    let heard = bench.frames_of(time::CAN_ID, Duration::from_secs(5))?;
    let Some(first) = heard.first() else {
        let reason = Reason::new("the device produces TIME", "one within 5 s", "none");
        return Err(Stop::Inconclusive(reason));
    };
    let is_right = |data: &[u8]| data.len() == 6 && data.get(3).is_some_and(|byte| byte & 0xF0 == 0);
    bench.check(demand(heard.iter().all(|record| is_right(record.data())), || {
        Reason::new("TIME has six bytes, bits 28 to 31 are 0", "six bytes", Bytes(first.data()).to_string())
    }))
}
