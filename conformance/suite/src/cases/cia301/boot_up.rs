//! Boot-up: how a device says that its initialisation is over (CiA 301, 7.2.8.2.3.1).

use crate::bench::Bench;
use crate::bench::nmt::Start;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_bus::client::sdo::Bytes;
use canvass_traces::{Duration, Record};

/// So long after the first boot-up message a second one still belongs to the same start.
const SECOND_BOOT_UP: Duration = Duration::from_millis(1_000);

/// After reset node the device sends exactly one boot-up message: one byte, 00h, on 700h + node-ID.
#[case(id = "301/boot-up/reset-node", clause = "CiA 301 7.2.8.2.3.1", confidence = Attested, level = Must,
       catches = [BootUpMissing, BootUpTwice, BootUpWrongData], cct = "9.1")]
fn reset_node(bench: &mut Bench<'_>) -> Judged {
    exactly_one_boot_up(bench, Command::RESET_NODE)
}

/// After reset communication the device sends exactly one boot-up message: one byte, 00h, on 700h + node-ID.
#[case(id = "301/boot-up/reset-communication", clause = "CiA 301 7.2.8.2.3.1", confidence = Attested, level = Must,
       catches = [BootUpMissing, BootUpTwice, BootUpWrongData], cct = "10.1")]
fn reset_communication(bench: &mut Bench<'_>) -> Judged {
    exactly_one_boot_up(bench, Command::RESET_COMMUNICATION)
}

fn exactly_one_boot_up(bench: &mut Bench<'_>, command: Command) -> Judged {
    let start = bench.record_start(command, SECOND_BOOT_UP)?;
    let duty = || format!("{command} ends in exactly one boot-up message");
    demand(start.boot_ups.len() == 1, || Reason::new(duty(), "one frame with the data 00", seen(bench, &start)))?;
    bench.check(demand(start.boot_ups.iter().all(|record| bench.is_boot_up(&record.frame)), || {
        Reason::new(duty(), "one byte", seen(bench, &start))
    }))
}

/// From a reset command to its boot-up message the device is silent: initialisation knows no communication.
#[case(id = "301/boot-up/silent-before", clause = "CiA 301 7.3.2.2", confidence = Attested, level = Must,
       catches = [BootUpWrongData, EmcyBeforeBootUp])]
fn silent_before(bench: &mut Bench<'_>) -> Judged {
    let start = bench.record_start(Command::RESET_NODE, Duration::ZERO)?;
    bench.check(demand(start.before.is_empty(), || {
        let duty = "the device sends nothing between reset node and its boot-up message";
        Reason::new(duty, "silence", frames(&start.before))
    }))
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

/// Every one of many resets ends in a boot-up message. Its time after the command is reported.
#[case(id = "301/boot-up/every-time", clause = "CiA 301 7.2.8.2.3.1", confidence = Attested, level = Must,
       catches = [BootUpSometimesMissing, BootUpMissing])]
fn every_time(bench: &mut Bench<'_>) -> Judged {
    const RESETS: usize = 20;
    let mut times = Vec::with_capacity(RESETS);
    for n in 1..=RESETS {
        bench.drain()?;
        let sent = bench.now();
        bench.command(Command::RESET_NODE)?;
        let Some(at) = bench.wait_for_boot_up()? else {
            let actual = format!("none after reset {n}, within {}", bench.timing().boot_up);
            let duty = format!("each of {RESETS} resets ends in a boot-up message");
            return Err(Stop::from(Reason::new(duty, "a boot-up message", actual)));
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

/// Before its boot-up message the device answers no SDO request.
#[case(id = "301/boot-up/no-sdo-before", clause = "CiA 301 7.3.2.2.1", confidence = Known, level = Should,
       catches = [SdoAnsweredBeforeBootUp])]
fn no_sdo_before(bench: &mut Bench<'_>) -> Judged {
    let response_id = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    bench.drain()?;
    bench.command(Command::RESET_NODE)?;
    let deadline = bench.now() + bench.timing().boot_up;
    let error_control = 0x700 + response_id % 0x80;
    // The reset itself takes a while to be seen; a quick device has started by then.
    let at_once = bench
        .wait_for(Duration::from_millis(5), |record| (record.frame.cob_id() == Some(error_control)).then_some(()))?;
    let (mut booted, mut early) = (at_once.is_some(), None);
    while !booted && early.is_none() && bench.now() < deadline {
        bench.send_request(&Request::upload(Multiplexer::new(0x1000, 0)))?;
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
    demand(early.is_none(), || {
        let actual = early.map(|frame| frame.to_string()).unwrap_or_default();
        Reason::new("no SDO is answered before the boot-up message", "silence", actual)
    })?;
    demand(booted, || Reason::new("the device starts", "a boot-up message", "none")).or_inconclusive()
}

/// With 1F80h stored so that the device starts by itself (bit 2 is 0) it is operational after its boot-up message. The
/// old value is stored again afterwards.
#[case(id = "301/boot-up/self-start", clause = "CiA 301 7.3.2.1", confidence = Attested, level = Must,
       needs = [StartUp, Store, VisibleState], touches = [Nvm], catches = [StartUpIgnored, StoreWithoutEffect])]
fn self_start(bench: &mut Bench<'_>) -> Judged {
    const START_UP: Multiplexer = Multiplexer::new(0x1F80, 0);
    const STORE: Multiplexer = Multiplexer::new(0x1010, 1);
    /// Bit 2: the NMT master has to start the device.
    const WAITS: u32 = 1 << 2;
    let before = bench.read_number(START_UP)?;
    bench.write(START_UP, &(before & !WAITS).to_le_bytes())?;
    bench.write(STORE, b"save")?;
    let state = bench.reset(Command::RESET_NODE).and_then(|()| {
        bench.show_state()?;
        bench.listen(bench.timing().reaction)?;
        bench.state()
    });
    // Whatever came of it, the device gets its old value back.
    bench.write(START_UP, &before.to_le_bytes())?;
    bench.prefer_guarding()?;
    bench.write(STORE, b"save")?;
    bench.reset(Command::RESET_NODE)?;
    let state = state?;
    bench.check(demand(state == Some(State::OPERATIONAL), || {
        let actual = state.map_or_else(|| "no sign of a state".to_owned(), |state| state.to_string());
        Reason::new("with bit 2 of 1F80h cleared the device starts by itself", "operational", actual)
    }))
}
