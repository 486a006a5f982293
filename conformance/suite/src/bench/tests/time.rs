//! The waits of the bench, and its tolerances for the device.

#![cfg(test)]

use super::super::{HOST_LATE, Options, Target, Timing};
use super::{on_device, with};
use crate::scripted::{with_bench, with_options};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::NodeId;
use canvass_traces::{Duration, Frame, Timestamp};
use std::sync::atomic::{AtomicBool, Ordering};

const MS: fn(u64) -> Duration = Duration::from_millis;

/// The times in docs/testing must not change unnoticed.
#[test]
fn the_times_of_a_run() {
    let timing = Timing::default();
    assert_eq!((timing.sdo_response, timing.store, timing.lss), (MS(1_000), MS(10_000), MS(5_000)));
    assert_eq!((timing.boot_up, timing.reaction, timing.silence), (MS(10_000), MS(50), MS(200)));
    // 5 %, and at least 1 ms.
    let tolerances = [0, 10, 20, 21, 1_000].map(|period| timing.tolerance(MS(period)).nanos());
    assert_eq!(tolerances, [1_000_000, 1_000_000, 1_000_000, 1_050_000, 50_000_000]);
    assert_eq!(Timing { period_tolerance: 20, ..timing }.tolerance(MS(100)), MS(20));
    assert_eq!(HOST_LATE, MS(50));
}

/// Two of the longest frames (160 bits) may precede an answer: 2.56 ms at 125 kbit/s, which is assumed if the rate is
/// unknown.
#[test]
fn a_bus_delays_by_two_frames() {
    with_bench(
        |_: &Frame| Vec::new(),
        |bench| {
            assert_eq!(bench.traffic.bus_delay(), Duration::from_micros(2_560));
            assert_eq!(bench.traffic.host_delay(), Duration::ZERO);
            assert_eq!(bench.shortly(), Duration::from_micros(52_560));
            assert_eq!(bench.tolerance(MS(1_000)), Duration::from_micros(52_560));
            assert_eq!(bench.silence(), MS(200));
            assert_eq!((bench.is_live(), bench.bit_rate(), bench.node().raw()), (false, None, 63));
            assert!(!bench.is_cancelled() && !bench.traffic.is_out_of_time() && !bench.knowledge.has_gone());
        },
    );
    on_device(|bench| {
        let bit_rate = u64::from(bench.bit_rate().unwrap());
        assert_eq!(bench.traffic.bus_delay().nanos(), 320 * 1_000_000_000 / bit_rate);
    });
}

/// A bus that reports a bit rate of zero causes no division by zero.
#[test]
fn a_bus_without_bit_rate_has_a_delay() {
    struct Slow(crate::scripted::ScriptedBus);
    impl canvass_bus::Bus for Slow {
        fn now(&self) -> Timestamp {
            self.0.now()
        }
        fn send(&mut self, frame: &Frame) -> Result<(), canvass_bus::BusError> {
            self.0.send(frame)
        }
        fn receive(&mut self, deadline: Timestamp) -> Result<Option<canvass_traces::Record>, canvass_bus::BusError> {
            self.0.receive(deadline)
        }
        fn bit_rate(&self) -> Option<u32> {
            Some(0)
        }
    }
    let mut bus = Slow(crate::scripted::ScriptedBus::new(|_| Vec::new()));
    let delay = super::on_bus(&mut bus, &Options::default(), |bench| bench.traffic.bus_delay());
    assert_eq!(delay, Duration::from_secs(320), "of one bit per second");
}

/// The time of silence for a slow server is a quarter longer than its slowest answer took.
#[test]
fn silence_lasts_longer_than_the_slowest_answer() {
    let slow = |delay: u64| {
        let script = move |request: &Frame| match request.to_string().starts_with("63F#40") {
            true => vec![(MS(delay), crate::scripted::frame("5BF#4300100096010200"))],
            false => Vec::new(),
        };
        with_bench(script, |bench| {
            bench.read(super::super::sdo::DEVICE_TYPE).unwrap();
            bench.silence()
        })
    };
    assert_eq!((slow(1), slow(160), slow(400)), (MS(200), MS(200), MS(500)));
}

/// Storing may take long, and says nothing about the speed of the server.
#[test]
fn storing_has_a_patience_of_its_own() {
    let store = Multiplexer::new(0x1010, 1);
    let script = |request: &Frame| match request.to_string().as_str() {
        "63F#2310100173617665" => vec![(MS(8_000), crate::scripted::frame("5BF#6010100100000000"))],
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        let attempt = bench.download(store, b"save").unwrap();
        assert_eq!(attempt.expect_confirmation(), Ok(()));
        assert_eq!((bench.silence(), bench.stores(), bench.traffic.watch.has_stored()), (MS(200), 1, true));
        // The wait for another object is shorter.
        let begun = bench.now();
        assert!(bench.upload(super::super::sdo::DEVICE_TYPE).unwrap().is_silent());
        assert_eq!(bench.now().since(begun), MS(1_000));
        assert_eq!((bench.stores(), bench.traffic.watch.has_stored()), (1, true));
        bench.begin();
        assert_eq!((bench.stores(), bench.traffic.watch.has_stored()), (1, false), "of the run, and of the case");
    });
}

#[test]
fn each_wait_takes_its_time() {
    with_bench(
        |_: &Frame| Vec::new(),
        |bench| {
            let mut took = |wait: &mut dyn FnMut(&mut super::Bench<'_>)| {
                let begun = bench.now();
                wait(bench);
                bench.now().since(begun)
            };
            assert_eq!(took(&mut |bench| _ = bench.listen(MS(70)).unwrap()), MS(70));
            assert_eq!(took(&mut |bench| _ = bench.listen(MS(450)).unwrap()), MS(450));
            assert_eq!(took(&mut |bench| bench.drain().unwrap()), Duration::ZERO);
            assert_eq!(took(&mut |bench| _ = bench.wait_for_boot_up().unwrap()), MS(10_000));
            assert_eq!(took(&mut |bench| _ = bench.guard().unwrap()), MS(200));
            assert_eq!(took(&mut |bench| _ = bench.wait_for_late_response().unwrap()), MS(200));
            assert_eq!(took(&mut |bench| _ = bench.is_operational().unwrap()), MS(2_100), "nobody answers");
        },
    );
}

/// The time limit of a run ends a case, but not putting the device back.
#[test]
fn a_run_has_an_end() {
    let options = Options { limit: Some(MS(500)), ..Options::default() };
    with_options(
        |_: &Frame| Vec::new(),
        &options,
        |bench| {
            assert!(!bench.traffic.is_out_of_time());
            bench.listen(MS(499)).unwrap();
            assert!(!bench.traffic.is_out_of_time() && !bench.is_cancelled());
            bench.listen(MS(1)).unwrap();
            assert!(bench.traffic.is_out_of_time() && bench.is_cancelled());
            let Err(Stop::Inconclusive(reason)) = bench.listen(MS(1)) else { panic!("it goes on") };
            assert_eq!(reason.actual, "the time limit of the run was reached");
            assert!(bench.uncancelled(|bench| bench.listen(MS(1))).is_ok());
            assert!(bench.listen(MS(1)).is_err());
        },
    );
}

#[test]
fn a_cancelled_run_sends_nothing_more() {
    let mut bus = crate::scripted::ScriptedBus::new(|_| Vec::new());
    let (target, options, cancel) = (Target::unknown(NodeId::MIN), Options::default(), AtomicBool::new(false));
    let mut annotate = |_: &canvass_traces::Record| String::new();
    let mut bench = super::Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    assert!(bench.send_bytes(0x123, &[1]).is_ok());
    cancel.store(true, Ordering::Relaxed);
    let Err(Stop::Inconclusive(reason)) = bench.send_bytes(0x123, &[1]) else { panic!("it was sent") };
    assert_eq!((reason.actual.as_str(), bench.is_cancelled()), ("the run was cancelled", true));
    assert!(!bench.traffic.is_out_of_time());
    let Err(Stop::Error(reason)) = bench.uncancelled(|bench| bench.send_bytes(0x123, &[0; 9])) else {
        panic!("nine bytes were sent")
    };
    assert_eq!(reason.actual, "9 bytes");
}

/// A bus with a frame every millisecond does not prolong a wait.
#[test]
fn traffic_does_not_prolong_a_wait() {
    let script = |request: &Frame| match request.to_string().as_str() {
        "123#01" => (1..=300).map(|ms| (MS(ms), crate::scripted::frame("1BF#00"))).collect(),
        "124#01" => vec![(MS(10), crate::scripted::frame("1BF#00")); 3],
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        bench.send_bytes(0x123, &[1]).unwrap();
        assert_eq!(bench.listen(MS(100)).unwrap().len(), 100);
        assert_eq!(bench.now(), Timestamp::ZERO + MS(100));
        // Frames of others are not counted as the device's.
        assert_eq!(bench.frames_of(0x1BE, MS(100)).unwrap().len(), 0);
        assert_eq!(bench.frames_of(0x1BF, MS(100)).unwrap().len(), 100);
        // Frames at the last moment are heard, all of them.
        bench.send_bytes(0x124, &[1]).unwrap();
        assert_eq!(bench.listen(MS(10)).unwrap().len(), 3);
    });
}

#[test]
fn a_device_that_is_switched_off_and_on_starts() {
    let cycled = |command: Option<&str>| {
        let options = Options { power_cycle: command.map(str::to_owned), ..Options::default() };
        with(&options, |bench| bench.power_cycle())
    };
    assert_eq!(cycled(None), Ok(false));
    assert_eq!(cycled(Some("exit 0")), Ok(true));
    let ends_with =
        |command, status| matches!(cycled(Some(command)), Err(Stop::Error(reason)) if reason.actual.contains(status));
    assert!(ends_with("exit 3", '3'));
    // The shell of the system handles quotation marks in its own way.
    let quoted = if cfg!(windows) { r#"if "a b"=="a b" exit 4"# } else { r#"[ "a b" = "a b" ] && exit 4"# };
    assert!(ends_with(quoted, '4'));
}
