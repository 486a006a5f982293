//! Boot-up: the message by which a device reports the end of its initialisation (CiA 301, 7.2.8.2.3.1 and 7.2.8.3.3).

use crate::bench::Bench;
use crate::bench::nmt::Start;
use crate::case;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand, observed_response};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy};
use canvass_analyzer::wire::error_control::{self, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Record};

/// Maximum time between two boot-up messages of the same start.
const SECOND_BOOT_UP: Duration = Duration::from_millis(1_000);

/// After reset node the device sends exactly one boot-up message: one byte, 00h, on 700h + node-ID.
#[case(id = "301/boot-up/reset-node", clause = "CiA 301 7.2.8.3.3", confidence = Cited, level = Must,
       catches = [BootUpMissing, BootUpTwice, BootUpWrongData], cct = "9.1")]
fn reset_node(bench: &mut Bench<'_>) -> Judged {
    exactly_one_boot_up(bench, Command::RESET_NODE)
}

/// After reset communication the device sends exactly one boot-up message: one byte, 00h, on 700h + node-ID.
#[case(id = "301/boot-up/reset-communication", clause = "CiA 301 7.2.8.3.3", confidence = Cited, level = Must,
       catches = [BootUpMissing, BootUpTwice, BootUpWrongData], cct = "10.1")]
fn reset_communication(bench: &mut Bench<'_>) -> Judged {
    exactly_one_boot_up(bench, Command::RESET_COMMUNICATION)
}

fn exactly_one_boot_up(bench: &mut Bench<'_>, command: Command) -> Judged {
    let start = bench.record_start(command, SECOND_BOOT_UP)?;
    let found = match start.boot_ups.as_slice() {
        [] => Observation::Silence,
        [one] if bench.is_boot_up(&one.frame) => return Ok(()),
        [one] => Observation::Frame(one.frame),
        more => Observation::Count(more.len() as u64),
    };
    let duty = format!("{command} ends in exactly one boot-up message of one byte");
    let breach = Breach::new(Service::BootUp, duty).expected(Observation::BootUp).found(found);
    Err(Stop::Breach(Box::new(breach.told(seen(bench, &start)))))
}

/// The device sends nothing between a reset command and its boot-up message: CiA 301 allows no service in the NMT state
/// initialisation.
///
/// Frames that were already queued when the command arrived, such as a heartbeat or a TPDO, are no breach.
#[case(id = "301/boot-up/silent-before", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       catches = [EmcyBeforeBootUp])]
fn silent_before(bench: &mut Bench<'_>) -> Judged {
    let at_once = bench.now() + bench.timing().reaction;
    let start = bench.record_start(Command::RESET_NODE, Duration::ZERO)?;
    let emcy_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    // This case causes no error, so any EMCY message belongs to the start.
    let is_early = |record: &&Record| record.timestamp <= at_once && record.frame.cob_id() != Some(emcy_id);
    let sent: Vec<Record> = start.before.iter().filter(|record| !is_early(record)).cloned().collect();
    let Some(first) = sent.first() else { return Ok(()) };
    let code = || Emcy::read(first.frame.data()).ok().and_then(|emcy| emcy.code());
    let code = (first.frame.cob_id() == Some(emcy_id)).then(code).flatten();
    let duty = "the device sends nothing between reset node and its boot-up message";
    let found = code.map_or(Observation::Frame(first.frame), Observation::Emcy);
    let breach = Breach::new(Subject::Device, duty).expected(Observation::Silence).found(found);
    bench.check(Err(Box::new(breach.told(frames(&sent)))))
}

fn seen(bench: &Bench<'_>, start: &Start) -> String {
    let strange: Vec<Record> = start.before.iter().filter(|r| bench.is_error_control(&r.frame)).cloned().collect();
    match (start.boot_ups.as_slice(), strange.as_slice()) {
        ([], []) => format!("none within {}", bench.timing().boot_up),
        ([], strange) => format!("none, but {}", frames(strange)),
        (boot_ups, _) => frames(boot_ups),
    }
}

fn frames(records: &[Record]) -> String {
    const SHOWN: usize = 3;
    let shown: Vec<String> =
        records.iter().take(SHOWN).map(|r| format!("{} with {}", r.frame.id(), Bytes(r.data()))).collect();
    let more = records.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

/// Each of many resets ends in a boot-up message. The case reports the time from the command to the message.
#[case(id = "301/boot-up/every-time", clause = "CiA 301 7.2.8.2.3.1", confidence = Cited, level = Must,
       catches = [BootUpSometimesMissing, BootUpMissing])]
fn every_time(bench: &mut Bench<'_>) -> Judged {
    const RESETS: usize = 20;
    let mut times = Vec::with_capacity(RESETS);
    for n in 1..=RESETS {
        bench.drain()?;
        let sent = bench.now();
        bench.command(Command::RESET_NODE)?;
        let Some(at) = bench.wait_for_boot_up()? else {
            let duty = format!("each of {RESETS} resets ends in a boot-up message");
            let breach = Breach::new(Service::BootUp, duty).expected(Observation::BootUp).found(Observation::Silence);
            let told = format!("none after reset {n}, within {}", bench.timing().boot_up);
            return Err(Stop::Breach(Box::new(breach.told(told))));
        };
        times.push(at.since(sent));
        bench.listen(Duration::from_millis(50))?;
    }
    for (name, percent) in [("median", 50), ("maximum", 100)] {
        if let Some(time) = crate::bench::percentile(&mut times, percent) {
            bench.measure(format!("reset to boot-up, {name}"), time);
        }
    }
    Ok(())
}

/// The device answers no SDO request before its boot-up message.
#[case(id = "301/boot-up/no-sdo-before", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       catches = [SdoAnsweredBeforeBootUp])]
fn no_sdo_before(bench: &mut Bench<'_>) -> Judged {
    let response_id = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    bench.drain()?;
    bench.command(Command::RESET_NODE)?;
    let deadline = bench.now() + bench.timing().boot_up;
    let error_control = error_control::CAN_ID_BASE + u16::from(bench.node().raw());
    // The device notices the reset after a while; a quick device has already started by then.
    let at_once = bench.wait_for(bench.timing().reaction, |record| {
        let is_ours = record.frame.cob_id() == Some(error_control);
        (is_ours && record.data() == [State::BOOT_UP.0]).then_some(())
    })?;
    let (mut booted, mut early) = (at_once.is_some(), None);
    while !booted && early.is_none() && bench.now() < deadline {
        bench.send_request(&Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0)))?;
        let seen = bench.wait_for(Duration::from_millis(5), |record| {
            let id = record.frame.cob_id();
            let is_boot_up = id == Some(error_control);
            (is_boot_up || id == Some(response_id)).then_some((is_boot_up, record.frame))
        })?;
        match seen {
            Some((true, _)) => booted = true,
            Some((false, frame)) => early = Some(frame),
            None => {}
        }
    }
    if let Some(frame) = early {
        let duty = "no SDO request is answered before the boot-up message";
        let breach = Breach::new(Service::Sdo, duty).expected(Observation::Silence);
        let response = sdo::Response::read(frame.data()).ok();
        let found = response.map_or(Observation::Frame(frame), |response| observed_response(&response));
        return bench.check(Err(Box::new(breach.found(found).told(frame.to_string()))));
    }
    demand(booted, || {
        Breach::new(Service::BootUp, "the device starts").expected(Observation::BootUp).found(Observation::Silence)
    })
    .or_inconclusive()
}

/// A device that has stored 1F80h with bit 2 cleared enters operational by itself after its boot-up message. The case
/// stores the old value again afterwards.
///
/// 1F80h is an object of CiA 302-2, whose text is not public; CiA 301, 7.3.2.1, allows the start by local control.
#[case(id = "301/boot-up/self-start", clause = "CiA 302-2", confidence = Unknown, level = Must,
       needs = [StartUp, Store, VisibleState], touches = [Nvm], catches = [StoreBreaksStart, StartUpIgnored])]
fn self_start(bench: &mut Bench<'_>) -> Judged {
    const START_UP: Multiplexer = Multiplexer::new(object::NMT_STARTUP, 0);
    const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
    /// Bit 2: the NMT master has to start the device.
    const WAITS: u32 = 1 << 2;
    let before = bench.read_number(START_UP)?;
    bench.write(START_UP, &(before & !WAITS).to_le_bytes())?;
    bench.write(STORE, b"save")?;
    let state = bench.reset(Command::RESET_NODE).and_then(|()| {
        bench.show_state()?;
        bench.listen(bench.timing().reaction)?;
        Ok((bench.read_number(START_UP)?, bench.state()?))
    });
    // The device gets its old value back, whether the check passed or not.
    bench.write(START_UP, &before.to_le_bytes())?;
    bench.prefer_guarding()?;
    bench.write(STORE, b"save")?;
    bench.reset(Command::RESET_NODE)?;
    let (stored, state) = state?;
    if stored & WAITS != 0 {
        let actual = format!("{stored:08X}h after reset node");
        return Err(Stop::Inconclusive(Reason::new("1F80h can be stored", "bit 2 is 0 after the reset", actual)));
    }
    bench.check(demand(state == Some(State::OPERATIONAL), || {
        Breach::new(START_UP, "with bit 2 of 1F80h cleared the device starts by itself")
            .expected(Observation::State(State::OPERATIONAL))
            .found(state.map_or(Observation::Silence, Observation::State))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::{frame, with_bench};
    use canvass_traces::Frame;

    /// Whether a device that sends this frame `delay_ms` after reset node, and starts after 200 ms, causes a breach.
    fn is_breach(delay_ms: u64, sent: &'static str) -> bool {
        let script = move |request: &Frame| match request.to_string().as_str() {
            "000#813F" => {
                vec![(Duration::from_millis(delay_ms), frame(sent)), (Duration::from_millis(200), frame("73F#00"))]
            }
            _ => Vec::new(),
        };
        with_bench(script, |bench| {
            silent_before(bench).unwrap();
            !bench.take_breaches(None).is_empty()
        })
    }

    #[test]
    fn what_was_queued_at_a_reset_may_still_be_sent() {
        for queued in ["1BF#0102", "73F#7F"] {
            assert!(!is_breach(2, queued), "{queued}");
            assert!(is_breach(100, queued), "{queued} comes long after the reset");
        }
        assert!(is_breach(2, "0BF#0000000000000000"));
    }
}
