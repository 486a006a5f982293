//! NMT, boot-up, heartbeat and guarding.

use crate::rig::{NEVER, Rig, model, parse, periods};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::error_control::State;
use canvass_bus::Bus;
use canvass_bus::Machine;
use canvass_device::Device;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_traces::{Duration, Timestamp};

#[test]
fn every_command_in_every_state() {
    // The state after each command, for the previous states pre-operational, operational and stopped.
    for (command, after) in [("01", "05"), ("02", "04"), ("80", "7F")] {
        for before in ["80", "01", "02"] {
            for node in ["3F", "00"] {
                let mut rig = Rig::new();
                rig.write(0x1017, 0, 10, 2);
                rig.ask(&format!("000#{before}3F"));
                let frames = rig.ask(&format!("000#{command}{node}"));
                assert_eq!(frames.last().unwrap(), &format!("73F#{after}"), "{command} after {before}");
            }
        }
    }
    for command in ["81", "82"] {
        for before in ["80", "01", "02"] {
            let mut rig = Rig::new();
            rig.ask(&format!("000#{before}3F"));
            rig.send(&format!("000#{command}00"));
            assert_eq!(rig.run(400), ["73F#00"]);
            assert_eq!(rig.read(0x1000, 0), Ok(0x0002_0196));
        }
    }
}

#[test]
fn what_is_not_addressed_or_not_known_is_ignored() {
    let mut rig = Rig::new();
    for frame in [
        "000#0140",
        "000#013E",
        "000#0080",
        "000#7F3F",
        "000#833F",
        "000#",
        "000#01",
        "000#013F00",
        "00000000#013F",
        "000#R2",
    ] {
        assert!(rig.ask(frame).is_empty(), "{frame}");
    }
    rig.write(0x1017, 0, 10, 2);
    assert_eq!(rig.run(15).last().unwrap(), "73F#7F");
}

#[test]
fn nothing_before_the_boot_up_and_no_sdo_when_stopped() {
    let mut rig = Rig::new();
    rig.send("000#813F");
    rig.send("63F#4000100000000000");
    assert_eq!(rig.run(400), ["73F#00"]);
    rig.ask("000#023F");
    assert_eq!(rig.read(0x1000, 0), Err("silence".to_owned()));
}

/// A reset withdraws a response whose transmission has not begun.
#[test]
fn what_waits_for_the_bus_is_withdrawn_by_a_reset() {
    let model = model();
    let mut device = Device::new(model, model.default_node(), Faults::NONE, 0);
    let boot = device.poll_timeout().unwrap();
    device.handle_timeout(boot);
    assert_eq!(device.poll_transmit(boot), Some(parse("73F#00")));
    device.handle(boot, &parse("63F#4000100000000000"));
    let ready = device.poll_timeout().unwrap();
    device.handle_timeout(ready);
    let response = device.poll_transmit(ready).unwrap();
    assert!(!device.withdraws(&response));
    device.handle(ready, &parse("000#023F"));
    assert!(device.withdraws(&response) && !device.withdraws(&parse("73F#04")));
    device.handle(ready, &parse("000#813F"));
    assert!(device.withdraws(&parse("73F#04")));
}

#[test]
fn heartbeats_are_on_time() {
    for period in [1, 100, 5000] {
        let mut rig = Rig::new();
        assert_eq!(rig.write(0x1017, 0, period, 2), "ok");
        let records = rig.records(u64::from(period) * 10);
        assert!(records.len() >= 9);
        assert!(periods(&records).iter().all(|&found| (found - f64::from(period)).abs() < 0.3), "{period}");
        assert_eq!(rig.write(0x1017, 0, 0, 2), "ok");
        rig.run(1);
        assert!(rig.run(u64::from(period) * 3).is_empty());
    }
}

#[test]
fn guarding_toggles_and_heartbeat_wins() {
    let mut rig = Rig::new();
    let answers: Vec<String> = (0..4).flat_map(|_| rig.ask("73F#R1")).collect();
    assert_eq!(answers, ["73F#7F", "73F#FF", "73F#7F", "73F#FF"]);
    rig.send("000#823F");
    rig.run(300);
    assert_eq!(rig.ask("73F#R1"), ["73F#7F"]);
    rig.write(0x1017, 0, 1000, 2);
    assert!(rig.ask("73F#R1").is_empty());
}

#[test]
fn life_guarding_misses_the_master() {
    let mut rig = Rig::new();
    rig.write(0x100C, 0, 100, 2);
    rig.write(0x100D, 0, 3, 1);
    assert!(rig.run(2000).is_empty(), "not before the first remote frame");
    rig.ask("000#013F");
    assert_eq!(rig.ask("73F#R1"), ["73F#05"]);
    assert!(rig.run(240).is_empty());
    assert_eq!(rig.run(20), ["0BF#3081110000000000"]);
    assert_eq!(rig.ask("73F#R1"), ["73F#FF", "0BF#0000000000000000"], "pre-operational, as 1029h says");
}

#[test]
fn heartbeat_consumer() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x1016, 1, 0x0005_00C8, 4), "ok");
    assert_eq!(rig.write(0x1016, 2, 0x0005_0064, 4), "06040043", "one entry for each node");
    assert_eq!(rig.write(0x1016, 1, 0x0006_00C8, 4), "06040043", "another node only after erasing");
    assert!(rig.ask("705#05").is_empty());
    assert!(rig.run(1000).is_empty(), "the manual: not before it is stored and the device restarted");
    assert_eq!(rig.write(0x1010, 1, 0x6576_6173, 4), "ok");
    rig.send("000#813F");
    rig.run(300);
    assert!(rig.run(1000).is_empty(), "not before the first heartbeat");
    assert!(rig.ask("705#05").is_empty());
    assert_eq!(rig.run(160), ["0BF#3081110000000000"]);
    assert!(rig.run(1000).is_empty());
    assert_eq!(rig.ask("705#05"), ["0BF#0000000000000000"]);
}

/// A wait without deadline on a silent bus returns, and the clock does not run to its end.
#[test]
fn time_does_not_end() {
    let mut rig = Rig::new();
    let before = rig.bus.now();
    assert!(rig.bus.receive(NEVER).unwrap().is_none());
    assert_eq!(rig.bus.now(), before);
}

/// Timers that ran before a reset take no effect during initialisation: the SYNC window, the heartbeat consumer time,
/// and the periods at which the device itself sends SYNC and TIME.
#[test]
fn nothing_is_due_while_initialising() {
    let model = Model::by_id("reference-301").unwrap();
    let mut device = Device::new(model, NodeId::new(63), Faults::NONE, 0);
    let mut now = Timestamp(1_000_000_000);
    device.handle_timeout(now);
    for frame in [
        "63F#2307100050C30000", // 1007h: 50 ms
        "63F#2316100132000500", // 1016h: node 5, 50 ms
        "63F#2306100050C30000", // 1006h: 50 ms
        "63F#2305100080000040", // 1005h: the device produces SYNC
        "63F#2312100000010040", // 1012h: the device produces TIME
        "705#05",
        "080#",
        "000#813F",
    ] {
        device.handle(now, &parse(frame));
        now += Duration::from_millis(3);
        while device.poll_timeout().is_some_and(|due| due <= now) {
            device.handle_timeout(now);
        }
    }
    let mut wakes = 0;
    while device.state() == State::BOOT_UP {
        now = device.poll_timeout().unwrap().max(now + Duration(1));
        device.handle_timeout(now);
        wakes += 1;
        assert!(wakes < 5, "{now}");
    }
    assert_eq!(device.state(), State::PRE_OPERATIONAL);
}
