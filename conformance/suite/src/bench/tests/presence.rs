//! Presence of devices: a device that leaves, comes back, is silent or starts by itself.

#![cfg(test)]

use super::super::state::Heartbeats;
use super::super::{Bench, Options};
use super::{Failing, on_bus, with};
use crate::scripted::{ScriptedBus, frame, table, with_bench, with_options};
use crate::touch::Touch;
use crate::verdict::Stop;
use canvass_analyzer::wire::error_control::State;
use canvass_traces::{Direction, Duration, Frame};
use std::cell::Cell;
use std::rc::Rc;

const MS: fn(u64) -> Duration = Duration::from_millis;
const DEVICE_TYPE: &str = "63F#4000100000000000";
const ANSWER: &str = "5BF#4300100096010200";

/// A device that is present while the switch is on: it answers with a device type, and starts when it is reset.
fn switched(is_there: &Rc<Cell<bool>>) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> + use<> {
    let is_there = Rc::clone(is_there);
    move |request| {
        let answer = match request.to_string().as_str() {
            DEVICE_TYPE => ANSWER,
            "000#813F" => "73F#00",
            _ => return Vec::new(),
        };
        if is_there.get() { vec![(MS(1), frame(answer))] } else { Vec::new() }
    }
}

fn commands(bench: &Bench<'_>, text: &str) -> usize {
    let own = bench.evidence().frames().filter(|exhibit| exhibit.record.direction == Direction::Tx);
    own.filter(|exhibit| exhibit.text == text).count()
}

/// A device has left if it neither answers nor starts, and can't be given its node-ID again; this is found out once.
#[test]
fn a_device_leaves_once_and_comes_back() {
    let there = Rc::new(Cell::new(true));
    with_bench(switched(&there), |bench| {
        assert!(!bench.has_left("301/a", |_| panic!("it is there")) && !bench.knowledge.has_gone());
        assert_eq!(bench.look_for_it(), Ok(()), "nobody is missed");
        assert_eq!(commands(bench, "000#813F"), 0, "one that answers is not reset");
        there.set(false);
        let mut asked = 0;
        assert!(bench.has_left("301/b", |_| asked += 1) && bench.knowledge.has_gone());
        assert!(!bench.has_left("301/c", |_| asked += 1), "it has left before");
        assert_eq!(asked, 1);
        let begun = bench.now();
        let Err(Stop::Inconclusive(reason)) = bench.look_for_it() else { panic!("it is away") };
        assert_eq!(reason.actual, "it stopped answering during 301/b");
        assert_eq!(bench.now().since(begun), MS(250));
        there.set(true);
        assert_eq!((bench.look_for_it(), bench.knowledge.has_gone()), (Ok(()), false));
    });
}

/// Any frame of the device is a sign of its presence; frames of others are not.
#[test]
fn any_frame_of_a_device_is_a_sign_of_it() {
    let found = |sign: &'static str| {
        let script = move |request: &Frame| match request.to_string().as_str() {
            DEVICE_TYPE => vec![(MS(240), frame(sign))],
            _ => Vec::new(),
        };
        with_bench(script, |bench| {
            bench.knowledge.gone = Some("301/a");
            bench.look_for_it().is_ok()
        })
    };
    assert!(found("73F#05") && found("5BF#8000100000000405") && found("1BF#00") && found("0BF#0000000000000000"));
    assert!(!found("73E#05") && !found("63F#4000100000000000"));
}

/// A device that lost its node-ID gets it again, and is then present.
#[test]
fn a_node_id_that_is_given_again_brings_a_device_back() {
    let there = Rc::new(Cell::new(false));
    with_bench(switched(&there), |bench| {
        assert!(!bench.has_left("301/a", |_| there.set(true)) && !bench.knowledge.has_gone());
        // A device that does not answer but starts is present, too.
        let starts = &[("000#813F", "73F#00")];
        assert!(!with_bench(table(starts), |bench| bench.has_left("301/a", |_| panic!("it starts"))));
    });
}

/// The user's command that switches the device off and on runs before the tester waits for the device.
#[test]
fn a_supply_that_is_switched_brings_a_device_back() {
    let looked_for = |command: &str, is_there: bool| {
        let options = Options { power_cycle: Some(command.to_owned()), ..Options::default() };
        let there = Rc::new(Cell::new(is_there));
        with_options(switched(&there), &options, |bench| {
            bench.knowledge.gone = Some("301/a");
            let found = bench.look_for_it();
            (found.is_ok(), bench.knowledge.has_gone(), matches!(found, Err(Stop::Error(_))))
        })
    };
    assert_eq!(looked_for("true", true), (true, false, false));
    assert_eq!(looked_for("true", false), (false, true, false));
    assert_eq!(looked_for("exit 1", true), (false, true, true), "a command that fails is the tester's error");
    let unswitched = with(&Options::default(), |bench| bench.look_for_it());
    assert_eq!(unswitched, Ok(()));
}

/// A start after switching the supply is not a restart by the device itself.
#[test]
fn a_boot_up_after_the_supply_was_switched_is_expected() {
    let options = Options { power_cycle: Some("true".to_owned()), ..Options::default() };
    let restarted = |cycles: bool| {
        let mut first = true;
        let script =
            move |_: &Frame| if std::mem::take(&mut first) { vec![(MS(700), frame("73F#00"))] } else { Vec::new() };
        with_options(script, &options, |bench| {
            bench.send_bytes(0x123, &[]).unwrap();
            if cycles {
                assert_eq!(bench.power_cycle(), Ok(true));
                assert_eq!(bench.now(), canvass_traces::Timestamp::ZERO + MS(700), "no longer than it takes");
            } else {
                bench.listen(MS(1_000)).unwrap();
            }
            bench.finish().boots.unasked.is_some()
        })
    };
    assert_eq!((restarted(true), restarted(false)), (false, true));
}

/// With the user's leave, the tester need not look for other nodes.
#[test]
fn others_may_be_commanded_with_leave() {
    const NEIGHBOUR: &[(&str, &str)] = &[("640#4000100000000000", "5C0#4300100096010200")];
    let options = Options { allow: [Touch::OtherNodes].into(), ..Options::default() };
    let (alone, frames) =
        with_options(table(NEIGHBOUR), &options, |bench| (bench.is_alone(), bench.evidence().frames().count()));
    assert_eq!((alone, frames), (Ok(Ok(())), 0));
    let refused = with_bench(table(NEIGHBOUR), |bench| bench.is_alone());
    let why = "node 64 is on this bus too, and commanding other nodes is not allowed";
    assert_eq!(refused, Ok(Err(why.to_owned())));
    // Of several nodes the first is named.
    const TWO: &[(&str, &str)] =
        &[("640#4000100000000000", "5C0#4300100096010200"), ("605#4000100000000000", "585#4300100096010200")];
    let first = with_bench(table(TWO), |bench| bench.is_alone()).unwrap().unwrap_err();
    assert!(first.starts_with("node 5 is on this bus too"), "{first}");
    // Only SDO responses are answers.
    const NOISE: &[(&str, &str)] =
        &[("640#4000100000000000", "5C0#43"), ("641#4000100000000000", "1C1#4300100096010200")];
    assert_eq!(with_bench(table(NOISE), |bench| bench.is_alone()), Ok(Ok(())));
}

/// The transmit queue of an interface holds at least eight frames: 126 nodes are asked in sixteen portions, 20 ms
/// apart. After the last portion the tester waits for the time of silence.
#[test]
fn others_are_asked_in_portions() {
    with_bench(table(&[]), |bench| {
        let begun = bench.now();
        bench.look_for_others().unwrap();
        assert_eq!(bench.now().since(begun), MS(16 * 20 + 200));
        let times: Vec<u64> = bench.evidence().frames().map(|exhibit| exhibit.record.timestamp.0 / 1_000_000).collect();
        assert_eq!((times.len(), times[7], times[8], times[125]), (126, 0, 20, 300));
    });
}

/// The nearest vacant node-ID serves first, below and above the device's own, within the valid range.
#[test]
fn the_nearest_vacant_node_id_serves() {
    let vacant = |own: u8, others: &'static [u8]| {
        let mut bus = ScriptedBus::new(move |_| {
            others.iter().map(|node| (MS(1), frame(&format!("{:03X}#05", 0x700 + u16::from(*node))))).collect()
        });
        let target = super::Target::unknown(canvass_analyzer::NodeId::new(own).unwrap());
        let cancel = std::sync::atomic::AtomicBool::new(false);
        let (mut annotate, options) = (|_: &canvass_traces::Record| String::new(), Options::default());
        let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        bench.send_bytes(0x123, &[]).unwrap();
        bench.listen(MS(10)).unwrap();
        bench.vacant_neighbour()
    };
    assert_eq!([vacant(63, &[]), vacant(127, &[]), vacant(1, &[])], [Some(64), Some(126), Some(2)]);
    assert_eq!(vacant(63, &[64]), Some(62));
    assert_eq!(vacant(63, &[62, 64]), Some(65));
    assert_eq!(vacant(63, &[62, 64, 65]), Some(61));
    assert_eq!(vacant(63, &[61, 62, 64, 65]), None);
    assert_eq!((vacant(127, &[126]), vacant(127, &[125, 126])), (Some(125), None));
}

/// A device of a few lines: the state after its reset, the states in which its SDO server answers, and whether it
/// answers guarding.
struct Starter {
    starts_in: u8,
    answers_in: &'static [u8],
    guarded: bool,
}

impl Starter {
    fn script(self) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
        let mut state = self.starts_in;
        move |request| {
            let text = request.to_string();
            let answers = self.answers_in.contains(&state);
            match text.as_str() {
                "000#813F" => {
                    state = self.starts_in;
                    vec![(MS(1), frame("73F#00"))]
                }
                "000#803F" => {
                    state = 0x7F;
                    Vec::new()
                }
                DEVICE_TYPE if answers => vec![(MS(1), frame(ANSWER))],
                _ if text.starts_with("73F#R") && self.guarded => vec![(MS(1), frame(&format!("73F#{state:02X}")))],
                _ if text.starts_with("63F#") && answers => {
                    let [_, low, high, sub, ..] = request.bytes();
                    let data = [0x80, low, high, sub, 0, 0, 2, 6];
                    vec![(MS(1), Frame::full(canvass_traces::CanId::standard_masked(0x5BF), data))]
                }
                _ => Vec::new(),
            }
        }
    }
}

/// Whether a device starts by itself is found out once, with one more reset. If its state can't be seen, it counts as a
/// device that starts by itself.
#[test]
fn a_device_that_starts_by_itself_is_found_out_once() {
    let found = |starter: Starter| {
        with_bench(starter.script(), |bench| {
            bench.prepare().unwrap();
            let (first, to_pre_operational) = (commands(bench, "000#813F"), commands(bench, "000#803F"));
            let starts = bench.starts_by_itself().unwrap();
            bench.prepare().unwrap();
            bench.drain().unwrap();
            let again = (commands(bench, "000#813F") - first, commands(bench, "000#803F") - to_pre_operational);
            (starts, (first, to_pre_operational), again, bench.guard().unwrap())
        })
    };
    const SERVING: &[u8] = &[0x7F, 5];
    let pre = Some(State::PRE_OPERATIONAL);
    let quiet = Starter { starts_in: 0x7F, answers_in: SERVING, guarded: true };
    assert_eq!(found(quiet), (false, (2, 0), (1, 0), pre));
    let operational = Starter { starts_in: 5, answers_in: SERVING, guarded: true };
    assert_eq!(found(operational), (true, (2, 1), (1, 1), pre));
    // A device that shows no state may have started.
    let hidden = Starter { starts_in: 0x7F, answers_in: SERVING, guarded: false };
    assert_eq!(found(hidden), (true, (2, 1), (1, 1), None));
    // A device that starts in stopped answers only after it was brought to pre-operational, and is not reset again.
    let stopped = Starter { starts_in: 4, answers_in: SERVING, guarded: true };
    assert_eq!(found(stopped), (true, (1, 2), (1, 1), pre));
    // A device without SDO server that shows its state.
    let mute = Starter { starts_in: 0x7F, answers_in: &[], guarded: true };
    let (starts, ..) = found(mute);
    assert!(!starts);
}

/// The tester waits for a commanded start that does not come. If the bus fails meanwhile, the device does not count as
/// silent.
#[test]
fn a_bus_that_fails_is_no_silent_device() {
    let mut bus = Failing::new(ScriptedBus::new(|_| Vec::new()));
    let fails = bus.switch();
    on_bus(&mut bus, &Options::default(), |bench| {
        fails.set(true);
        for stop in [bench.look_for_others().err(), bench.answers().err(), bench.prepare().err()] {
            assert!(matches!(&stop, Some(Stop::Error(reason)) if reason.actual.contains("unplugged")), "{stop:?}");
        }
        assert!(bench.has_left("301/a", |_| {}), "whoever can't be reached is not there");
    });
}

/// A device with a fixed 1017h shows its state by itself, whatever its heartbeat period.
#[test]
fn a_fixed_heartbeat_is_waited_for_by_its_period() {
    let state = |after: u64| {
        let script = move |request: &Frame| match request.to_string().as_str() {
            "63F#4017100000000000" => vec![(MS(1), frame("5BF#4B171000D0070000"))],
            "63F#2B171000D0070000" => vec![(MS(1), frame("5BF#8017100002000106"))],
            "123#" => vec![(MS(after), frame("73F#05"))],
            _ => Vec::new(),
        };
        with_bench(script, |bench| {
            assert_eq!(bench.heartbeats(), Ok(Heartbeats::Fixed(MS(2_000))));
            let since = bench.evidence().frames().count();
            bench.show_state().unwrap();
            assert_eq!(bench.evidence().frames().count(), since, "it shows by itself");
            bench.send_bytes(0x123, &[]).unwrap();
            bench.state().unwrap()
        })
    };
    // Four periods without a heartbeat mean that there is none.
    assert_eq!((state(7_990), state(8_010)), (Some(State::OPERATIONAL), None));
}

/// A state that a case needs is reached; a state that is not reached is reported.
#[test]
fn a_state_that_is_not_reached_is_told() {
    const OPERATIONAL: &[(&str, &str)] = &[("73F#R1", "73F#05")];
    with_bench(table(OPERATIONAL), |bench| {
        assert_eq!(bench.require_state(State::OPERATIONAL), Ok(()));
        let Err(Stop::Inconclusive(reason)) = bench.reach(State::STOPPED) else { panic!("it stays operational") };
        assert_eq!((reason.expected.as_str(), reason.actual.as_str()), ("stopped", "operational"));
        assert_eq!(commands(bench, "000#023F"), 1);
        bench.reach(State::OPERATIONAL).unwrap();
        assert_eq!(commands(bench, "000#013F"), 0, "it is there already");
        bench.expect_state(State::OPERATIONAL, "a start").unwrap();
        assert_eq!(bench.take_breaches(None), []);
        bench.expect_state(State::STOPPED, "a stop").unwrap();
        let found = bench.take_breaches(None);
        assert_eq!(found[0].to_string(), "the device is stopped after a stop: expected stopped, found operational");
    });
    with_bench(table(&[]), |bench| {
        let Err(Stop::Inconclusive(reason)) = bench.require_state(State::STOPPED) else { panic!("it shows none") };
        assert_eq!(reason.actual, "no message that shows the state");
        bench.expect_state(State::STOPPED, "a stop").unwrap();
        assert_eq!(bench.take_breaches(None)[0].found_text(), "no answer");
    });
}
