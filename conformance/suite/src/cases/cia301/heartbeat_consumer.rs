//! Heartbeat consumer (1016h).

use super::emcy::{code_of, emergencies, shown};
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{EmcyCode, ErrorRegister};
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::sdo::Bytes;
use canvass_traces::Duration;

const WATCHED: Multiplexer = Multiplexer::new(0x1016, 1);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(0x1001, 0);
const CONSUMER_MS: u16 = 200;
const CONSUMER_TIME: Duration = Duration::from_millis(200);

/// The entry that watches a node for that time.
pub const fn entry(node: u8, milliseconds: u16) -> [u8; 4] {
    ((node as u32) << 16 | milliseconds as u32).to_le_bytes()
}

/// A second entry for a node that another entry watches already is refused with abort 0604 0043h.
#[case(id = "301/heartbeat-consumer/duplicate", clause = "CiA 301 7.5.2.19", confidence = Derived, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerDoubleAccepted], cct = "7.104")]
fn duplicate(bench: &mut Bench<'_>) -> Judged {
    let Some(node) = bench.vacant_neighbour() else { return Ok(()) };
    bench.write(Multiplexer::new(0x1016, 1), &entry(node, 500))?;
    let attempt = bench.download(Multiplexer::new(0x1016, 2), &entry(node, 1_000))?;
    if attempt.abort() == Some(AbortCode::NO_SUB_INDEX) {
        let reason = crate::verdict::Reason::new("two nodes can be watched", "1016h:02", attempt.outcome.to_string());
        return Err(Stop::NotApplicable(reason));
    }
    bench.check(attempt.refused(Situation::DuplicateConsumer))
}

/// A node-ID that nobody uses, with which the tester sends heartbeats.
fn neighbour(bench: &Bench<'_>) -> Result<u8, Stop> {
    bench
        .vacant_neighbour()
        .ok_or_else(|| Stop::NotApplicable(Reason::new("a node-ID beside that of the device is free", "one", "none")))
}

/// Lets the device watch a node that nobody else is.
fn watch(bench: &mut Bench<'_>) -> Result<u8, Stop> {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    bench.write(WATCHED, &entry(node, CONSUMER_MS))?;
    Ok(node)
}

fn beat(bench: &mut Bench<'_>, node: u8) -> Result<(), Stop> {
    let message = ErrorControl::heartbeat(State::OPERATIONAL);
    bench.send(&message.to_frame(error_control::CAN_ID_BASE + u16::from(node))).map(|_| ())
}

/// A watched node is missed only after its first heartbeat: one that was never heard causes no EMCY.
#[case(id = "301/heartbeat-consumer/first-heartbeat", clause = "CiA 301 7.2.8.2.2.3", confidence = Attested,
       level = Must, needs = [HeartbeatConsumer], catches = [HeartbeatConsumerStartsAtOnce])]
fn first_heartbeat(bench: &mut Bench<'_>) -> Judged {
    watch(bench)?;
    let heard = emergencies(bench, CONSUMER_TIME.times(5))?;
    bench.check(demand(heard.is_empty(), || {
        Reason::new("a node that was never heard is not missed", "no EMCY", shown(&heard))
    }))
}

/// A watched node whose heartbeats come in time is not missed.
#[case(id = "301/heartbeat-consumer/kept-alive", clause = "CiA 301 7.2.8.2.2.3", confidence = Attested,
       level = Must, needs = [HeartbeatConsumer], catches = [HeartbeatConsumerNotRestarted], cct = "7.105")]
fn kept_alive(bench: &mut Bench<'_>) -> Judged {
    let node = watch(bench)?;
    let mut heard = Vec::new();
    for _ in 0..20 {
        beat(bench, node)?;
        heard.extend(emergencies(bench, Duration::from_millis(100))?);
    }
    bench.check(demand(heard.is_empty(), || {
        let duty = "a node that sends a heartbeat every 100 ms is not missed after 200 ms";
        Reason::new(duty, "no EMCY", shown(&heard))
    }))
}

/// A watched node that falls silent is missed after the consumer heartbeat time: EMCY 8130h once, and bit 4 of 1001h.
#[case(id = "301/heartbeat-consumer/lost", clause = "CiA 301 7.2.8.2.2.3", confidence = Attested, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerLate, HeartbeatConsumerSilent, EmcyRepeated, ErrorRegisterMissing], cct = "7.106")]
fn lost(bench: &mut Bench<'_>) -> Judged {
    let node = watch(bench)?;
    beat(bench, node)?;
    let sent = bench.now();
    let heard = emergencies(bench, CONSUMER_TIME.times(4))?;
    demand(heard.len() == 1 && heard.iter().all(|record| code_of(record) == Some(EmcyCode::HEARTBEAT)), || {
        Reason::new("a node that falls silent is reported once", "one EMCY 8130h", shown(&heard))
    })?;
    let after = heard.first().map_or(Duration::ZERO, |record| record.timestamp.since(sent));
    bench.measure("heartbeat loss, noticed after", after);
    let (least, most) = (CONSUMER_TIME.nanos() * 9 / 10, CONSUMER_TIME.nanos() * 3 / 2);
    demand((least..=most).contains(&after.nanos()), || {
        let duty = format!("a node is missed after {CONSUMER_TIME}");
        Reason::new(duty, "180 ms to 300 ms", after.to_string())
    })?;
    let register = bench.upload(ERROR_REGISTER)?.value()?;
    let bits = register.first().copied().unwrap_or_default();
    bench.check(demand(bits & ErrorRegister::COMMUNICATION.0 != 0, || {
        Reason::new("the loss shows in 1001h", "bit 4", Bytes(&register).to_string())
    }))
}

/// A node that is back ends the error: EMCY 0000h, bit 4 of 1001h is cleared, and the node is watched again.
#[case(id = "301/heartbeat-consumer/back", clause = "CiA 301 7.2.8.2.2.3", confidence = Attested, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerNotRearmed, EmcyResetMissing])]
fn back(bench: &mut Bench<'_>) -> Judged {
    let node = watch(bench)?;
    for round in ["first", "second"] {
        beat(bench, node)?;
        let lost = emergencies(bench, CONSUMER_TIME.times(3))?;
        let met = lost.iter().any(|record| code_of(record) == Some(EmcyCode::HEARTBEAT));
        let reason = || Reason::new(format!("the {round} loss is reported"), "EMCY 8130h", shown(&lost));
        demand(met, reason)?;
        beat(bench, node)?;
        let back = emergencies(bench, Duration::from_millis(100))?;
        demand(back.iter().any(|record| code_of(record).is_some_and(EmcyCode::is_reset)), || {
            Reason::new("the return of the node is reported", "EMCY 0000h", shown(&back))
        })?;
    }
    Ok(())
}

/// Every entry of 1016h watches its node.
#[case(id = "301/heartbeat-consumer/all-entries", clause = "CiA 301 7.5.2.19", confidence = Derived, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerFirstOnly])]
fn all_entries(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let entries = bench.read_number(Multiplexer::new(0x1016, 0))?.min(8);
    let own = bench.node().raw();
    for sub in 1..=u8::try_from(entries).unwrap_or(1) {
        let node = 100 + sub;
        if node == own {
            continue;
        }
        bench.write(Multiplexer::new(0x1016, sub), &entry(node, CONSUMER_MS))?;
        beat(bench, node)?;
        let heard = emergencies(bench, CONSUMER_TIME.times(3))?;
        demand(heard.iter().any(|record| code_of(record) == Some(EmcyCode::HEARTBEAT)), || {
            Reason::new(format!("1016h:{sub:02X} watches its node"), "EMCY 8130h", shown(&heard))
        })?;
        bench.write(Multiplexer::new(0x1016, sub), &entry(0, 0))?;
        bench.listen(Duration::from_millis(50))?;
    }
    Ok(())
}

/// An entry whose time is 0 watches nobody.
#[case(id = "301/heartbeat-consumer/off", clause = "CiA 301 7.5.2.19", confidence = Derived, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerNotStopped])]
fn off(bench: &mut Bench<'_>) -> Judged {
    let node = watch(bench)?;
    beat(bench, node)?;
    bench.write(WATCHED, &entry(node, 0))?;
    let heard = emergencies(bench, CONSUMER_TIME.times(4))?;
    bench.check(demand(heard.is_empty(), || {
        Reason::new("a node that is no longer watched is not missed", "no EMCY", shown(&heard))
    }))
}

/// The number of entries, 1016h:00, can't be written: abort 0601 0002h.
#[case(id = "301/heartbeat-consumer/count", clause = "CiA 301 7.5.2.19", confidence = Derived, level = Must,
       needs = [HeartbeatConsumer], catches = [SdoReadOnlyWritable, SdoReadOnlyWrongCode], cct = "4.3")]
fn count(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = Multiplexer::new(0x1016, 0);
    let before = bench.upload(multiplexer)?.value()?;
    demand(matches!(before.as_slice(), [1..=127]), || {
        Reason::new("1016h:00 counts the entries", "one byte, 1 to 127", Bytes(&before).to_string())
    })?;
    let attempt = bench.download(multiplexer, &[1])?;
    bench.check(attempt.refused(Situation::ReadOnly))?;
    bench.expect_unchanged(multiplexer, &before)?;
    Ok(())
}

/// An entry for a node-ID that does not exist, 0 or 128 to 255, watches nobody, or is refused with abort 0609 0030h.
#[case(id = "301/heartbeat-consumer/no-node", clause = "CiA 301 7.5.2.19", confidence = Derived, level = Should,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerWatchesEveryone])]
fn no_node(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    let node = neighbour(bench)?;
    for unused in [0_u8, 128, 255] {
        // Some take another node only after the entry was erased.
        bench.write(WATCHED, &entry(0, 0))?;
        let attempt = bench.download(WATCHED, &entry(unused, CONSUMER_MS))?;
        if attempt.abort().is_some() {
            bench.check(attempt.refused(Situation::InvalidValue))?;
            continue;
        }
        attempt.expect_confirmation()?;
        beat(bench, node)?;
        let heard = emergencies(bench, CONSUMER_TIME.times(3))?;
        demand(heard.is_empty(), || {
            Reason::new(format!("an entry for node-ID {unused} watches nobody"), "no EMCY", shown(&heard))
        })?;
    }
    Ok(())
}

/// Heartbeats of a watched node that have another length, or bit 7 set, and its boot-up message, do not disturb the
/// device. Whether they count as a sign of life is noted: CiA 301 does not say.
#[case(id = "301/heartbeat-consumer/malformed", clause = "CiA 301 7.2.8.2.2.3", confidence = Attested, level = Should,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerCrashes])]
fn malformed(bench: &mut Bench<'_>) -> Judged {
    let node = watch(bench)?;
    let cob_id = error_control::CAN_ID_BASE + u16::from(node);
    let messages: [(&str, &[u8]); 4] =
        [("of no byte", &[]), ("of two bytes", &[5, 0]), ("with bit 7", &[0x85]), ("of a boot-up", &[0])];
    for (what, data) in messages {
        beat(bench, node)?;
        let mut heard = Vec::new();
        for _ in 0..4 {
            heard.extend(emergencies(bench, Duration::from_millis(100))?);
            bench.send_bytes(cob_id, data)?;
        }
        bench.note(format!("a heartbeat {what} {}", if heard.is_empty() { "counts" } else { "does not count" }));
        bench.upload(ERROR_REGISTER)?.value()?;
    }
    Ok(())
}
