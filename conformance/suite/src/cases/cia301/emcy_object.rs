//! The objects of EMCY: its COB-ID (1014h) and its inhibit time (1015h).

use super::emcy::{begin_monitoring, code_of, emergencies, shown, sign_of_life};
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode};
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::Duration;

const COB_ID: Multiplexer = Multiplexer::new(0x1014, 0);
const INHIBIT_TIME: Multiplexer = Multiplexer::new(0x1015, 0);
/// Long enough for the loss of the one who is monitored.
const UNTIL_LOST: Duration = Duration::from_millis(600);
/// A CAN-ID that no predefined object has and CiA 301 does not restrict.
const FREE: u32 = 0x6A0;

/// 1014h names the predefined CAN-ID 080h + node-ID as delivered, unless the description says otherwise.
#[case(id = "301/emcy/cob-id", clause = "CiA 301 7.5.2.17", confidence = Derived, level = Must,
       needs = [EmcyObject], catches = [EmcyIdWrong], cct = "5.1")]
fn cob_id(bench: &mut Bench<'_>) -> Judged {
    let node = bench.node();
    let predefined = u32::from(emcy::CAN_ID_BASE) + u32::from(node.raw());
    let described = bench.target().description.as_ref().and_then(|description| {
        let value = description.dictionary.entry(COB_ID).ok()?.start_value(node)?.as_number()?;
        u32::try_from(value).ok()
    });
    let right = described.unwrap_or(predefined);
    let own = bench.read_number(COB_ID)?;
    bench.check(demand(own == right, || {
        Reason::new("1014h names the CAN-ID of EMCY", format!("{right:08X}h"), format!("{own:08X}h"))
    }))
}

/// The CAN-ID of EMCY can't be changed while EMCY is valid: abort 0609 0030h.
#[case(id = "301/emcy/cob-id-while-valid", clause = "CiA 301 7.5.2.17", confidence = Derived, level = Must,
       needs = [EmcyId], catches = [EmcyIdChangeWhileValid])]
fn cob_id_while_valid(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read(COB_ID)?;
    let other = crate::bench::sdo::number(&own) & !0x7FF | FREE;
    let attempt = bench.download(COB_ID, &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::InvalidValue))?;
    bench.expect_unchanged(COB_ID, &own)?;
    Ok(())
}

/// Restricted CAN-IDs are refused for EMCY with abort 0609 0030h.
#[case(id = "301/emcy/restricted", clause = "CiA 301 7.3.5", confidence = Attested, level = Must,
       needs = [EmcyId], catches = [RestrictedCanIdAccepted], cct = "8.10")]
fn restricted(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.write(COB_ID, &(own | CobId::INVALID).to_le_bytes())?;
    for can_id in [0x001_u32, 0x101, 0x581, 0x601, 0x6E0, 0x701] {
        let attempt = bench.download(COB_ID, &can_id.to_le_bytes())?;
        bench.check(attempt.refused(Situation::InvalidValue))?;
    }
    Ok(())
}

/// With bit 31 of 1014h set no EMCY is sent.
#[case(id = "301/emcy/invalid", clause = "CiA 301 7.5.2.17", confidence = Derived, level = Must,
       needs = [EmcyId, Monitoring], catches = [EmcySentWhenInvalid])]
fn invalid(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(COB_ID)?;
    bench.write(COB_ID, &(own | CobId::INVALID).to_le_bytes())?;
    begin_monitoring(bench)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    bench.check(demand(heard.is_empty(), || {
        Reason::new("an EMCY that is switched off is not sent", "silence", shown(&heard))
    }))
}

/// An error that persists is reported once, not again and again.
#[case(id = "301/emcy/not-repeated", clause = "CiA 301 7.2.7", confidence = Attested, level = Must,
       needs = [Monitoring], catches = [EmcyRepeated, HeartbeatConsumerSilent])]
fn not_repeated(bench: &mut Bench<'_>) -> Judged {
    begin_monitoring(bench)?;
    let heard = emergencies(bench, Duration::from_secs(10))?;
    bench.check(demand(heard.len() == 1, || {
        Reason::new("an error that persists for 10 s is reported", "once", format!("{} times", heard.len()))
    }))
}

/// Between two EMCYs at least the inhibit time passes, and the second is not lost.
#[case(id = "301/emcy/inhibit-time", clause = "CiA 301 7.5.2.18", confidence = Derived, level = Must,
       needs = [EmcyInhibit, Monitoring], catches = [EmcyInhibitTimeIgnored, EmcyLostWhenInhibited])]
fn inhibit_time(bench: &mut Bench<'_>) -> Judged {
    const INHIBIT: Duration = Duration::from_millis(1_000);
    // In units of 100 µs. Its length differs: some devices have four bytes.
    let mut value = 10_000_u32.to_le_bytes().to_vec();
    value.truncate(bench.read(INHIBIT_TIME)?.len());
    bench.write(INHIBIT_TIME, &value)?;
    let monitored = begin_monitoring(bench)?;
    let emcy_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    let lost =
        bench.wait_for(UNTIL_LOST, |record| (record.frame.cob_id() == Some(emcy_id)).then_some(record.timestamp))?;
    let Some(lost) = lost else {
        let reason = Reason::new("the loss is reported", "an EMCY", "none");
        return Err(Stop::Inconclusive(reason));
    };
    sign_of_life(bench, monitored)?;
    let heard = emergencies(bench, INHIBIT.times(2))?;
    let back = heard.iter().find(|record| code_of(record).is_some_and(EmcyCode::is_reset));
    let Some(back) = back else {
        let duty = "an EMCY within the inhibit time is sent when it is over";
        return Err(Stop::from(Reason::new(duty, "EMCY 0000h", shown(&heard))));
    };
    let gap = back.timestamp.since(lost);
    let limit = INHIBIT.nanos() - bench.timing().tolerance(INHIBIT).nanos();
    bench.check(demand(gap.nanos() >= limit, || {
        Reason::new("EMCYs are at least the inhibit time apart", INHIBIT.to_string(), gap.to_string())
    }))
}

/// The error register in an EMCY fits its code: 81xxh is a communication error, bit 4.
#[case(id = "301/emcy/register-fits-code", clause = "CiA 301 7.2.7", confidence = Attested, level = Must,
       needs = [Monitoring], catches = [EmcyRegisterZero])]
fn register_fits_code(bench: &mut Bench<'_>) -> Judged {
    use canvass_analyzer::wire::emcy::ErrorRegister;
    begin_monitoring(bench)?;
    let heard = emergencies(bench, UNTIL_LOST)?;
    let Some(first) = heard.first() else {
        let reason = Reason::new("the loss is reported", "an EMCY", "none");
        return Err(Stop::Inconclusive(reason));
    };
    let register = Emcy::read(first.frame.data()).ok().and_then(|_| first.data().get(2).copied()).unwrap_or_default();
    bench.check(demand(register & ErrorRegister::COMMUNICATION.0 != 0, || {
        Reason::new("byte 2 of EMCY 8130h says that it is a communication error", "bit 4", shown(&heard))
    }))
}
