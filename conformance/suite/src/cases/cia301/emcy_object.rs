//! The objects of EMCY: its COB-ID (1014h) and its inhibit time (1015h).

use super::emcy::{begin_monitoring, emergencies, is_error, observed, reported_loss, shown, sign_of_life};
use crate::bench::Bench;
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::emcy::{self, EmcyCode, ErrorRegister};
use canvass_analyzer::{CobId, Multiplexer, Service};
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record};

const COB_ID: Multiplexer = Multiplexer::new(object::COB_ID_EMCY, 0);
const INHIBIT_TIME: Multiplexer = Multiplexer::new(object::INHIBIT_TIME_EMCY, 0);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);
/// Long enough for the loss of the monitored node or master.
const UNTIL_LOST: Duration = Duration::from_millis(600);
/// A CAN-ID that belongs to no predefined object and that CiA 301 does not restrict.
const FREE: u32 = 0x6A0;

/// 1014h holds the predefined CAN-ID 080h + node-ID as delivered, unless the description gives another one. The device
/// may be delivered with EMCY valid or invalid.
#[case(id = "301/emcy/cob-id", clause = "CiA 301 7.5.2.17", confidence = Cited, level = Must,
       needs = [EmcyObject], catches = [EmcyIdWrong], cct = "5.1")]
fn cob_id(bench: &mut Bench<'_>) -> Judged {
    let node = bench.node();
    let predefined = u32::from(emcy::CAN_ID_BASE) + u32::from(node.raw());
    let described = bench.target().description.as_ref().and_then(|description| {
        let value = description.dictionary.entry(COB_ID).ok()?.start_value(node)?.as_number()?;
        u32::try_from(value).ok()
    });
    let right = described.unwrap_or(predefined);
    let own = bench.read(COB_ID)?;
    bench.check(demand(number(&own) & !CobId::INVALID == right & !CobId::INVALID, || {
        Breach::new(COB_ID, "1014h holds the CAN-ID of EMCY, with bit 31 set or cleared")
            .expected(Observation::Value(right.to_le_bytes().to_vec()))
            .found(Observation::Value(own))
    }))
}

/// The CAN-ID of EMCY does not change while EMCY is valid: the device refuses the write.
#[case(id = "301/emcy/cob-id-while-valid", clause = "CiA 301 7.5.2.17", confidence = Cited, level = Must,
       needs = [EmcyId], catches = [EmcyIdChangeWhileValid])]
fn cob_id_while_valid(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    if own & CobId::INVALID != 0 {
        bench.write(COB_ID, &(own & !CobId::INVALID).to_le_bytes())?;
    }
    let valid = bench.read(COB_ID)?;
    let other = number(&valid) & !0x7FF | FREE;
    let attempt = bench.download(COB_ID, &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
    bench.expect_unchanged(COB_ID, &valid)
}

/// The device refuses restricted CAN-IDs for EMCY.
#[case(id = "301/emcy/restricted", clause = "CiA 301 7.3.5", confidence = Cited, level = Must,
       needs = [EmcyId], catches = [RestrictedCanIdAccepted], cct = "8.10")]
fn restricted(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.write(COB_ID, &(own | CobId::INVALID).to_le_bytes())?;
    bench.each([0x001_u32, 0x101, 0x581, 0x601, 0x6E0, 0x701], |bench, can_id| {
        let attempt = bench.download(COB_ID, &can_id.to_le_bytes())?;
        bench.check(attempt.refused(Situation::RestrictedCanId))
    })
}

/// The device sends no EMCY while bit 31 of 1014h is set, and the bit reads back as 1.
#[case(id = "301/emcy/invalid", clause = "CiA 301 7.5.2.17", confidence = Cited, level = Must,
       needs = [EmcyId, Monitoring], catches = [EmcySentWhenInvalid])]
fn invalid(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.write_confirmed(COB_ID, &(own | CobId::INVALID).to_le_bytes())?;
    let now = bench.read(COB_ID)?;
    bench.check(demand(number(&now) & CobId::INVALID != 0, || {
        let breach = Breach::new(COB_ID, "bit 31 of 1014h reads back as written").expected("bit 31");
        breach.found(Observation::Value(now))
    }))?;
    begin_monitoring(bench)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    bench.check(demand(heard.is_empty(), || {
        let breach = Breach::new(COB_ID, "an EMCY that is switched off is not sent").expected(Observation::Silence);
        breach.found(observed(&heard)).told(shown(&heard))
    }))
}

/// The device reports an error that persists once, without repeating the EMCY.
#[case(id = "301/emcy/not-repeated", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       needs = [Monitoring], catches = [EmcyRepeated])]
fn not_repeated(bench: &mut Bench<'_>) -> Judged {
    let (_, first) = reported_loss(bench)?;
    let later = emergencies(bench, Duration::from_secs(10))?;
    let heard: Vec<Record> = first.into_iter().chain(later).filter(is_error).collect();
    // Counts the same message for the same error; other EMCYs are allowed.
    let times = |one: &Record| heard.iter().filter(|record| record.data() == one.data()).count();
    let most = heard.iter().map(times).max().unwrap_or(0);
    bench.check(demand(most <= 1, || {
        Breach::new(Service::Emcy, "an error that persists for 10 s is reported once")
            .expected(Allowed::Count { least: 1, most: Some(1) })
            .found(Observation::Count(most as u64))
            .told(shown(&heard))
    }))
}

/// At least the inhibit time passes between two EMCYs, and the device does not lose the second one.
#[case(id = "301/emcy/inhibit-time", clause = "CiA 301 7.5.2.18", confidence = Cited, level = Must,
       needs = [EmcyInhibit, Monitoring], catches = [EmcyInhibitTimeIgnored, EmcyLostWhenInhibited,
       EmcyMutedByInhibitTime])]
fn inhibit_time(bench: &mut Bench<'_>) -> Judged {
    const INHIBIT: Duration = Duration::from_millis(1_000);
    // In units of 100 µs. The length of 1015h differs: some devices have four bytes.
    let mut value = 10_000_u32.to_le_bytes().to_vec();
    value.truncate(bench.read(INHIBIT_TIME)?.len());
    bench.write(INHIBIT_TIME, &value)?;
    // In some devices the inhibit time starts with the write of 1015h.
    bench.listen(INHIBIT)?;
    let monitored = begin_monitoring(bench)?;
    let emcy_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    let lost = bench.wait_for(UNTIL_LOST + INHIBIT, |record| {
        (record.frame.cob_id() == Some(emcy_id)).then_some(record.timestamp)
    })?;
    let Some(lost) = lost else {
        value.fill(0);
        bench.write(INHIBIT_TIME, &value)?;
        return unreported(bench, monitored);
    };
    sign_of_life(bench, monitored)?;
    let heard = emergencies(bench, INHIBIT.times(2))?;
    let back = heard.iter().find(|record| !is_error(record));
    let gap = back.map(|back| back.timestamp.since(lost));
    let least = Duration::from_nanos(INHIBIT.nanos() - bench.timing().tolerance(INHIBIT).nanos());
    bench.check(demand(gap.is_some_and(|gap| gap >= least), || {
        let duty = "an EMCY 0000h within the inhibit time of the previous EMCY is sent when that time is over";
        Breach::new(INHIBIT_TIME, duty)
            .expected(Allowed::Time { least, most: INHIBIT.times(2) })
            .found(gap.map_or(Observation::Silence, Observation::Time))
    }))
}

/// Called if no EMCY came. Causes the same error again without inhibit time: if the device reports it now, the inhibit
/// time had suppressed it.
fn unreported(bench: &mut Bench<'_>, monitored: super::emcy::Monitored) -> Judged {
    sign_of_life(bench, monitored)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    bench.check(demand(!heard.iter().any(is_error), || {
        let duty = "an error that is reported without inhibit time is also reported with one";
        Breach::new(INHIBIT_TIME, duty).expected("an EMCY").found(Observation::Silence).told(shown(&heard))
    }))?;
    Err(Stop::Inconclusive(Reason::new("the loss of a master or node is reported", "an EMCY", "none")))
}

/// An EMCY has eight bytes. Its third byte is the error register as read from 1001h, with the generic bit set.
///
/// The case only records whether the EMCY of a communication error (81xxh) also has bit 4 set, because bits 1 to 7 are
/// optional.
#[case(id = "301/emcy/register-fits-code", clause = "CiA 301 7.2.7.3.1", confidence = Cited, level = Must,
       needs = [Monitoring], catches = [EmcyRegisterZero, ErrorRegisterMissing, ErrorRegisterGenericMissing])]
fn register_fits_code(bench: &mut Bench<'_>) -> Judged {
    let (_, heard) = reported_loss(bench)?;
    let Some(last) = heard.iter().rev().find(|record| is_error(record)) else { return Ok(()) };
    bench.check(demand(last.data().len() == 8, || {
        let breach = Breach::new(Service::Emcy, "an EMCY has eight bytes").expected("eight bytes");
        breach.found(Observation::Frame(last.frame))
    }))?;
    let sent = last.data().get(2).copied().unwrap_or_default();
    let found = Observation::Number(u64::from(sent));
    let breach = |duty| Breach::new(Service::Emcy, duty).found(found.clone()).told(shown(&heard));
    bench.check(demand(sent & ErrorRegister::GENERIC.0 != 0, || {
        breach("byte 2 of an EMCY that reports an error has the generic bit").expected("bit 0")
    }))?;
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    let right = number(&register);
    bench.check(demand(right == u32::from(sent), || {
        breach("byte 2 of an EMCY is 1001h").expected(Observation::Number(u64::from(right)))
    }))?;
    let is_communication = super::emcy::code_of(last) == Some(EmcyCode::HEARTBEAT);
    bench.check(demand(!is_communication || sent & ErrorRegister::COMMUNICATION.0 != 0, || {
        breach("byte 2 of EMCY 8130h has the bit of communication errors").expected("bit 4").open()
    }))
}
