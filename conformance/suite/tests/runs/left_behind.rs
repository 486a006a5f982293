//! Changes that a run leaves are reported with the commands that put them back, and the run does not count as good.

use crate::scripted::{frame, test_case, with_bench};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_suite::case::Case;
use canvass_suite::comparison::{Comparison, Nature};
use canvass_suite::runner::{Plan, RunEvent, Summary, run};
use canvass_traces::{CanId, Duration, Frame};

const HEARTBEAT_TIME: Multiplexer = Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0);

static WRITES: Case = test_case("test/writes", |bench| bench.write(HEARTBEAT_TIME, &[0xE8, 0x03]));

fn answer(bytes: [u8; 8]) -> Vec<(Duration, Frame)> {
    vec![(Duration::from_millis(1), Frame::full(CanId::standard_masked(0x5BF), bytes))]
}

/// A device with a device type, a heartbeat time, and an error register that counts its reads. If `sticks`, the
/// heartbeat time can't be switched off again. Resets change no value.
fn device(sticks: bool) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
    let (mut time, mut reads) = ([0, 0], 0_u8);
    move |request| {
        if matches!(request.data(), [0x81, 63]) {
            return vec![(Duration::from_millis(1), frame("73F#00"))];
        }
        let [command, low, high, sub, first, second, ..] = request.bytes();
        match (command, low, high, sub) {
            (0x40, 0x00, 0x10, 0) => answer([0x43, low, high, sub, 0x91, 0x01, 0, 0]),
            (0x40, 0x01, 0x10, 0) => {
                reads += 1;
                answer([0x4F, low, high, sub, reads, 0, 0, 0])
            }
            (0x40, 0x17, 0x10, 0) => answer([0x4B, low, high, sub, time[0], time[1], 0, 0]),
            (0x2B, 0x17, 0x10, 0) if !sticks || time == [0, 0] || [first, second] != [0, 0] => {
                time = [first, second];
                answer([0x60, low, high, sub, 0, 0, 0, 0])
            }
            (0x00..=0x7F, ..) if request.cob_id() == Some(0x63F) => answer([0x80, low, high, sub, 0, 0, 0x02, 0x06]),
            _ => Vec::new(),
        }
    }
}

fn compared(sticks: bool) -> (Summary, Comparison) {
    let mut found = None;
    let summary = with_bench(device(sticks), |bench| {
        let plan = Plan { cases: &[&WRITES], bus: "can 0", bit_rate: None, seed: 0, shuffle: None };
        run(bench, &plan, &mut |event| {
            if let RunEvent::DictionaryCompared(comparison) = event {
                found = Some((*comparison).clone());
            }
        })
    });
    (summary.unwrap(), found.unwrap())
}

#[test]
fn a_value_that_can_not_be_put_back_is_told() {
    let (summary, comparison) = compared(true);
    assert!(summary.is_good() && !summary.is_as_found && !comparison.is_as_found());
    let left: Vec<_> = comparison.left().collect();
    assert_eq!((left.len(), left[0].multiplexer, left[0].nature), (1, HEARTBEAT_TIME, Nature::Setting));
    assert_eq!((left[0].before.as_deref(), left[0].after.as_deref()), (Some(&[0, 0][..]), Some(&[0xE8, 3][..])));
    assert_eq!(comparison.commands, ["canvass sdo write 'can 0' 63 1017:00 0000 --type bytes"]);
}

#[test]
fn a_value_that_was_put_back_is_not_and_one_that_moves_is_the_devices_own() {
    let (summary, comparison) = compared(false);
    assert!(summary.is_as_found && comparison.is_as_found() && comparison.commands.is_empty(), "{comparison:?}");
    let own: Vec<_> = comparison.own().map(|change| change.multiplexer).collect();
    assert_eq!(own, [Multiplexer::new(object::ERROR_REGISTER, 0)]);
}
