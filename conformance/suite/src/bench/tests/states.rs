//! NMT commands, states and resets.

#![cfg(test)]

use super::super::nmt::Start;
use super::super::state::{GUARD_TIME, HEARTBEAT_TIME, Heartbeats, LIFE_TIME_FACTOR, command_to};
use super::on_device;
use crate::scripted::{Row, dictionary, frame, table, with_bench};
use crate::verdict::Stop;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::{Duration, Frame};
use std::cell::Cell;
use std::rc::Rc;

const MS: fn(u64) -> Duration = Duration::from_millis;

#[test]
fn every_state_is_reached_and_seen() {
    on_device(|bench| {
        bench.prepare().unwrap();
        assert_eq!(bench.heartbeats(), Ok(Heartbeats::Settable(50)));
        bench.show_state().unwrap();
        for state in [State::OPERATIONAL, State::PRE_OPERATIONAL, State::STOPPED] {
            bench.reach(state).unwrap();
            assert_eq!(bench.state(), Ok(Some(state)));
            assert_eq!(bench.is_operational(), Ok(state == State::OPERATIONAL));
        }
        bench.reset(Command::RESET_COMMUNICATION).unwrap();
        bench.show_state().unwrap();
        assert_eq!(bench.state(), Ok(Some(State::PRE_OPERATIONAL)));
        // The heartbeat time is put back.
        bench.finish();
        assert_eq!(bench.read_number(HEARTBEAT_TIME), Ok(0));
    });
    assert_eq!(command_to(State::BOOT_UP), None);
    assert_eq!(command_to(State::STOPPED), Some(Command::STOP));
}

#[test]
fn guarding_shows_the_state_too() {
    on_device(|bench| {
        bench.prepare().unwrap();
        assert_eq!(bench.can_be_guarded(), Ok(true));
        bench.write(HEARTBEAT_TIME, &[0xE8, 3]).unwrap();
        bench.prefer_guarding().unwrap();
        assert_eq!(bench.read_number(HEARTBEAT_TIME), Ok(0));
        bench.let_guarding_be_answered().unwrap();
        assert_eq!((bench.read_number(GUARD_TIME), bench.read_number(LIFE_TIME_FACTOR)), (Ok(10_000), Ok(100)));
        assert_eq!(bench.guard(), Ok(Some(State::PRE_OPERATIONAL)));
        bench.command(Command::START).unwrap();
        assert_eq!(bench.guard(), Ok(Some(State::OPERATIONAL)));
    });
}

#[test]
fn a_start_is_recorded_with_its_boot_up() {
    on_device(|bench| {
        let Start { boot_ups, before } = bench.record_start(Command::RESET_NODE, MS(500)).unwrap();
        assert_eq!((boot_ups.len(), before.len()), (1, 0));
        assert!(bench.is_boot_up(&boot_ups[0].frame) && bench.is_error_control(&boot_ups[0].frame));
        let none = bench.record_start(Command::START, MS(500)).unwrap();
        assert!(none.boot_ups.is_empty(), "nothing starts");
    });
    // Frames come before the boot-up message, and a second boot-up message after it.
    let script = |request: &Frame| match request.to_string().as_str() {
        "000#813F" => ["1BF#01", "1BE#01", "73F#00", "73F#00", "73F#7F"]
            .iter()
            .zip(1..)
            .map(|(text, ms)| (MS(ms), frame(text)))
            .collect(),
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        let Start { boot_ups, before } = bench.record_start(Command::RESET_NODE, MS(100)).unwrap();
        let before: Vec<String> = before.iter().map(|record| record.frame.to_string()).collect();
        assert_eq!((boot_ups.len(), before), (2, vec!["1BF#01".to_owned()]));
    });
}

/// Some devices ignore resets while they are stopped: the tester first brings them to pre-operational.
#[test]
fn a_reset_wakes_a_device_that_is_stopped() {
    let mut awake = false;
    let script = move |request: &Frame| match request.to_string().as_str() {
        "000#803F" => {
            awake = true;
            Vec::new()
        }
        "000#813F" if awake => vec![(MS(5), frame("73F#00"))],
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        let begun = bench.now();
        assert_eq!(bench.reset(Command::RESET_NODE), Ok(()));
        // 10 s for the first boot-up, 20 ms between the commands, 5 ms, and 50 ms after the second boot-up.
        assert_eq!(bench.now().since(begun), MS(10_075));
    });
    // A device that does not start but answers is present all the same.
    let answering = &[("63F#4000100000000000", "5BF#4300100096010200")];
    assert_eq!(with_bench(table(answering), |bench| bench.reset(Command::RESET_NODE)), Ok(()));
    let gone = with_bench(table(&[]), |bench| bench.reset(Command::RESET_NODE));
    assert!(matches!(gone, Err(Stop::Inconclusive(_))), "{gone:?}");
}

/// The tester waits for the longest time of a start only once: later resets end when the device answers again.
#[test]
fn a_device_without_boot_up_message_is_waited_for_once() {
    let unanswered = Rc::new(Cell::new(0));
    let left = unanswered.clone();
    let script = move |request: &Frame| match (request.to_string().as_str(), left.get()) {
        ("63F#4000100000000000", 0) => vec![(MS(1), frame("5BF#4300100096010200"))],
        ("63F#4000100000000000", more) => {
            left.set(more - 1);
            Vec::new()
        }
        _ => Vec::new(),
    };
    with_bench(script, move |bench| {
        let mut took = || {
            let begun = bench.now();
            assert_eq!(bench.reset(Command::RESET_NODE), Ok(()));
            bench.now().since(begun)
        };
        // Twice 10 s, 20 ms between the commands, the answer, and 50 ms.
        assert_eq!(took(), MS(20_071));
        assert_eq!(took(), MS(1_051), "a second before it is asked, the answer, and 50 ms");
        // A device that leaves three requests unanswered, for a second each, is waited for.
        unanswered.set(3);
        assert_eq!(took(), MS(4_051));
    });
}

/// A device that starts silently and is later gone does not count as started.
#[test]
fn a_device_without_boot_up_message_may_be_gone() {
    let mut left = 1;
    let script = move |request: &Frame| match request.to_string().as_str() {
        "63F#4000100000000000" if left > 0 => {
            left -= 1;
            vec![(MS(1), frame("5BF#4300100096010200"))]
        }
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        assert_eq!(bench.reset(Command::RESET_NODE), Ok(()));
        assert!(matches!(bench.reset(Command::RESET_NODE), Err(Stop::Inconclusive(_))));
    });
}

/// The tester allows the device its reaction time before it asks for its state or its server.
#[test]
fn a_device_has_time_to_react() {
    const OPERATIONAL: &[(&str, &str)] = &[("73F#R1", "73F#05")];
    with_bench(table(OPERATIONAL), |bench| {
        bench.heartbeats().unwrap();
        let begun = bench.now();
        bench.require_state(State::OPERATIONAL).unwrap();
        assert_eq!(bench.now().since(begun), MS(51));
        let begun = bench.now();
        bench.expect_state(State::OPERATIONAL, "a start").unwrap();
        assert_eq!(bench.now().since(begun), MS(51));
    });
    let mut silent = true;
    let script = move |request: &Frame| match request.to_string().as_str() {
        "000#803F" => {
            silent = false;
            Vec::new()
        }
        "63F#4000100000000000" if !silent => vec![(MS(1), frame("5BF#4300100096010200"))],
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        let begun = bench.now();
        assert_eq!(bench.starts_by_itself(), Ok(true));
        assert_eq!(bench.now().since(begun), MS(1_000 + 50 + 1));
    });
}

/// If the boot-up message comes after all, the tester waits for it again.
#[test]
fn a_boot_up_message_that_comes_again_is_waited_for() {
    let mut resets = 0;
    let script = move |request: &Frame| match request.to_string().as_str() {
        "000#813F" => {
            resets += 1;
            if resets == 3 { vec![(MS(5), frame("73F#00"))] } else { Vec::new() }
        }
        "63F#4000100000000000" if resets < 4 => vec![(MS(1), frame("5BF#4300100096010200"))],
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        bench.reset(Command::RESET_NODE).unwrap();
        let begun = bench.now();
        bench.reset(Command::RESET_NODE).unwrap();
        assert_eq!(bench.now().since(begun), MS(55));
        let begun = bench.now();
        assert!(bench.reset(Command::RESET_NODE).is_err(), "it is gone");
        assert!(bench.now().since(begun) > MS(20_000), "as long as a start may take, and again");
    });
}

/// 1017h reads as 200 ms, and each download of it gets `answer`.
fn heartbeat_times(answer: fn(&str) -> Option<&'static str>) -> Heartbeats {
    let script = move |request: &Frame| {
        let text = request.to_string();
        let answer = match text.as_str() {
            "63F#4017100000000000" => Some("5BF#4B171000C8000000"),
            download if download.starts_with("63F#2B171000") => answer(download),
            _ => None,
        };
        answer.map(|answer| (MS(1), frame(answer))).into_iter().collect()
    };
    with_bench(script, |bench| bench.heartbeats()).unwrap()
}

/// A period that the device refuses does not prevent its state from being seen: the device has a minimum period, or a
/// fixed one.
#[test]
fn the_period_is_one_that_the_device_takes() {
    const TAKEN: Option<&str> = Some("5BF#6017100000000000");
    const TOO_LOW: Option<&str> = Some("5BF#8017100032000906");
    assert_eq!(heartbeat_times(|_| TAKEN), Heartbeats::Settable(50));
    let from_100 = |download: &str| if download.ends_with("32000000") { TOO_LOW } else { TAKEN };
    assert_eq!(heartbeat_times(from_100), Heartbeats::Settable(100));
    let own_alone = |download: &str| if download.ends_with("C8000000") { TAKEN } else { TOO_LOW };
    assert_eq!(heartbeat_times(own_alone), Heartbeats::Fixed(MS(200)));
    let unanswered = |download: &str| if download.ends_with("C8000000") { TAKEN } else { None };
    assert_eq!(heartbeat_times(unanswered), Heartbeats::Fixed(MS(200)));
}

/// Only a reset of this node, or of all nodes, makes its boot-up expected.
#[test]
fn a_boot_up_is_expected_after_a_reset_of_this_node() {
    const ROWS: &[(&str, &str)] =
        &[("000#813E", "73F#00"), ("000#013F", "73F#00"), ("000#8100", "73F#00"), ("000#823F", "73F#00")];
    let restarted = |node: u8, command: Command| {
        with_bench(table(ROWS), |bench| {
            bench.command_to(node, command).unwrap();
            bench.listen(MS(100)).unwrap();
            bench.finish().boots.unasked.is_some()
        })
    };
    assert!(restarted(62, Command::RESET_NODE), "another node was reset");
    assert!(restarted(63, Command::START), "a start is no reset");
    assert!(!restarted(0, Command::RESET_NODE));
    assert!(!restarted(63, Command::RESET_COMMUNICATION));
    let all = with_bench(table(ROWS), |bench| {
        bench.command_all(Command::RESET_NODE).unwrap();
        bench.listen(MS(100)).unwrap();
        bench.evidence().frames().map(|exhibit| exhibit.record.frame.to_string()).collect::<Vec<_>>()
    });
    assert_eq!(all, ["000#8100", "73F#00"]);
}

/// A device that starts by itself is brought back to pre-operational before each case.
#[test]
fn a_device_that_starts_by_itself_is_noticed() {
    let state = |starts: bool| {
        let mut state = 0x7F;
        let script = move |request: &Frame| {
            let text = request.to_string();
            match text.as_str() {
                "000#813F" => {
                    state = if starts { 5 } else { 0x7F };
                    return vec![(MS(1), frame("73F#00"))];
                }
                "000#803F" => state = 0x7F,
                "63F#4000100000000000" => return vec![(MS(1), frame("5BF#4300100091010000"))],
                _ if text.starts_with("73F#R") => {
                    return vec![(MS(1), Frame::new(request.id(), &[state]).unwrap())];
                }
                _ if text.starts_with("63F#") => {
                    let [_, low, high, sub, ..] = request.bytes();
                    let answer = [0x80, low, high, sub, 0, 0, 2, 6];
                    return vec![(MS(1), Frame::full(canvass_traces::CanId::standard_masked(0x5BF), answer))];
                }
                _ => {}
            }
            Vec::new()
        };
        with_bench(script, |bench| {
            bench.prepare().unwrap();
            let commanded = bench.evidence().frames().filter(|exhibit| exhibit.text == "000#803F").count();
            (bench.starts_by_itself().unwrap(), bench.guard().unwrap(), commanded)
        })
    };
    assert_eq!(state(true), (true, Some(State::PRE_OPERATIONAL), 1));
    assert_eq!(state(false), (false, Some(State::PRE_OPERATIONAL), 0));
}

/// Frames before the reset command do not belong to the start. Without a boot-up message, the tester waits for the
/// whole boot-up time.
#[test]
fn a_start_is_recorded_from_its_command_on() {
    let script = |request: &Frame| match request.to_string().as_str() {
        "123#" => vec![(Duration::ZERO, frame("1BF#AA")), (Duration::ZERO, frame("73F#00"))],
        "000#813F" => vec![(MS(9_999), frame("73F#00")), (MS(10_050), frame("73F#00")), (MS(10_200), frame("73F#00"))],
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        bench.send_bytes(0x123, &[]).unwrap();
        let begun = bench.now();
        let Start { boot_ups, before } = bench.record_start(Command::RESET_NODE, MS(100)).unwrap();
        assert_eq!((boot_ups.len(), before.len()), (2, 0), "the third comes after that");
        assert_eq!(bench.now().since(begun), MS(10_099));
        let begun = bench.now();
        bench.listen(MS(500)).unwrap();
        let none = bench.record_start(Command::START, MS(100)).unwrap();
        assert_eq!((none.boot_ups.len(), bench.now().since(begun)), (0, MS(10_500)));
    });
    // The case judges a boot-up message of another length; state 0 of another node is no boot-up.
    let odd = |request: &Frame| match request.to_string().as_str() {
        "000#813F" => vec![(MS(1), frame("73E#00")), (MS(2), frame("73F#0001")), (MS(3), frame("73F#7F"))],
        _ => Vec::new(),
    };
    with_bench(odd, |bench| {
        let Start { boot_ups, before } = bench.record_start(Command::RESET_NODE, MS(100)).unwrap();
        assert_eq!((boot_ups.len(), before.len()), (1, 0));
        assert!(bench.is_error_control(&boot_ups[0].frame) && !bench.is_boot_up(&boot_ups[0].frame));
        assert!(bench.is_boot_up(&frame("73F#00")) && !bench.is_boot_up(&frame("73E#00")));
    });
}

/// A restart that the case may cause is no surprise.
#[test]
fn a_restart_that_may_come_is_no_surprise() {
    const ROWS: &[(&str, &str)] = &[("123#", "73F#00")];
    let restarted = |may: bool| {
        with_bench(table(ROWS), |bench| {
            if may {
                bench.watch_restart();
            }
            bench.send_bytes(0x123, &[]).unwrap();
            bench.listen(MS(5)).unwrap();
            bench.finish().boots.unasked.is_some()
        })
    };
    assert_eq!((restarted(true), restarted(false)), (false, true));
}

/// The writes to these objects, in order.
fn written_to(bench: &mut super::Bench<'_>) -> Vec<String> {
    bench.drain().unwrap();
    let frames = bench.evidence().frames().map(|exhibit| exhibit.text.clone());
    frames.filter(|text| text.starts_with("63F#2")).collect()
}

/// Guarding is preferred to a heartbeat that can be ended; nothing is written if the heartbeat is off or fixed.
#[test]
fn a_heartbeat_is_ended_only_where_it_comes() {
    let written = |value: u8, writable: bool| {
        let row: Row = ((0x1017, 0), vec![value, 0], writable);
        with_bench(dictionary(vec![row]), |bench| {
            bench.heartbeats().unwrap();
            let before = written_to(bench).len();
            bench.prefer_guarding().unwrap();
            written_to(bench).split_off(before)
        })
    };
    // Finding out the period has left 50 ms in 1017h, until the case is over.
    assert_eq!(written(100, true), ["63F#2B17100000000000"]);
    assert_eq!(written(100, false), Vec::<String>::new());
    let none = with_bench(dictionary(Vec::new()), |bench| {
        bench.prefer_guarding().unwrap();
        written_to(bench)
    });
    assert_eq!(none, Vec::<String>::new());
}

/// Some devices answer guarding only with a life time: it is set if both of its objects can be written and the device
/// does not answer without it.
#[test]
fn a_life_time_is_set_where_it_is_needed() {
    let shown = |rows: Vec<Row>, answers: bool| {
        let mut others = dictionary(rows);
        let script = move |request: &Frame| match request.to_string().as_str() {
            "73F#R1" if answers => vec![(MS(1), frame("73F#7F"))],
            _ => others(request),
        };
        with_bench(script, |bench| {
            bench.show_state().unwrap();
            let life = written_to(bench).into_iter().filter(|text| text.starts_with("63F#2B0C10001027"));
            (life.count(), written_to(bench).iter().any(|text| text.starts_with("63F#2F0D100064")))
        })
    };
    let (guard, life): (Row, Row) = (((0x100C, 0), vec![0, 0], true), ((0x100D, 0), vec![0], true));
    assert_eq!(shown(vec![guard.clone(), life.clone()], false), (1, true));
    assert_eq!(shown(vec![guard.clone(), life.clone()], true), (0, false), "it shows its state as it is");
    assert_eq!(shown(vec![guard.clone()], false), (0, false));
    assert_eq!(shown(vec![life], false), (0, false));
    let fixed = ((0x100D, 0), vec![0], false);
    assert_eq!(shown(vec![guard, fixed], false), (0, false));
}

/// A boot-up message is no state, nor is a message of another node; the first real state counts.
#[test]
fn a_state_is_read_from_the_device_alone() {
    let state = |answers: &'static [&'static str]| {
        let script = move |request: &Frame| match request.to_string().as_str() {
            "73F#R1" => (1..).zip(answers).map(|(ms, answer)| (MS(ms), frame(answer))).collect(),
            _ => Vec::new(),
        };
        with_bench(script, |bench| bench.guard().unwrap())
    };
    assert_eq!(state(&["73F#00", "73E#05", "73F#04", "73F#05"]), Some(State::STOPPED));
    assert_eq!(state(&["73F#85"]), Some(State::OPERATIONAL), "with its toggle bit");
    assert_eq!((state(&["73F#00"]), state(&["73E#05"]), state(&["1BF#05"])), (None, None, None));
}
