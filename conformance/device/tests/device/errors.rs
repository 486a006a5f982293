//! EMCY, error register and history.

use crate::rig::Rig;

const HOT: &str = "63F#2F20210350000000";
const COOL: &str = "63F#2F202103A2000000";

#[test]
fn one_message_for_each_change() {
    let mut rig = Rig::new();
    assert_eq!(rig.ask(HOT).len(), 2);
    assert_eq!(rig.ask(HOT), ["5BF#6020210300000000"], "still the same error");
    assert!(rig.run(10_000).is_empty());
    assert_eq!(rig.ask(COOL), ["0BF#0000000000000000", "5BF#6020210300000000"]);
    assert_eq!(rig.read(0x1001, 0), Ok(0));
    assert_eq!(rig.read(0x1003, 0), Ok(1));
    assert_eq!(rig.read(0x1003, 1), Ok(0x5680_4200));
    assert_eq!(rig.read(0x1003, 2), Err("08000024".to_owned()));
    assert_eq!(rig.write(0x1003, 0, 0, 1), "ok");
    assert_eq!(rig.read(0x1003, 0), Ok(0));
}

#[test]
fn the_history_keeps_the_newest() {
    let mut rig = Rig::new();
    for _ in 0..10 {
        rig.ask(HOT);
        rig.ask(COOL);
    }
    assert_eq!(rig.read(0x1003, 0), Ok(8));
    assert_eq!(rig.read(0x1003, 8), Ok(0x5680_4200));
    assert_eq!(rig.read(0x1003, 9), Err("06090011".to_owned()));
}

#[test]
fn inhibit_time() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x1015, 0, 10_000, 4), "ok", "1 s");
    rig.ask(HOT);
    assert_eq!(rig.ask(COOL), ["5BF#6020210300000000"]);
    assert!(rig.run(850).is_empty());
    assert_eq!(rig.run(100), ["0BF#0000000000000000"], "not lost");
}

#[test]
fn silent_when_stopped() {
    let mut rig = Rig::new();
    rig.write(0x100C, 0, 100, 2);
    rig.write(0x100D, 0, 1, 1);
    rig.ask("73F#R1");
    rig.ask("000#023F");
    assert!(rig.run(500).is_empty());
    assert_eq!(rig.ask("000#803F"), ["0BF#3081110000000000"], "kept until it may be sent");
}
