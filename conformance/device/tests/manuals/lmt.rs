//! LMT of the LMP-30 and LA-41 (manual 004, 4.7 and 5.5).

use crate::bench::Bench;

const NONE: [&str; 0] = [];

fn lmp30() -> Bench {
    Bench::new("tr-lmp30")
}

fn configuring() -> Bench {
    let mut bench = lmp30();
    assert_eq!(bench.ask("7E5#0401000000000000"), NONE);
    bench
}

/// 5.5.1: node-ID 12 is stored, and takes effect at power-off and on, not before.
#[test]
fn node_id() {
    let mut bench = configuring();
    assert_eq!(bench.ask("7E5#110C000000000000"), ["7E4#1100000000000000"]);
    assert_eq!(bench.ask("7E5#1700000000000000"), ["7E4#1700000000000000"]);
    assert_eq!(bench.read(0x100B, 0), Ok(1), "still the old node-ID");
    bench.reset("81");
    assert_eq!(bench.read(0x100B, 0), Ok(1), "not by reset node");
    assert_eq!(bench.power_cycle(), NONE, "a linear device starts silently");
    assert_eq!(bench.read_from(12, 0x100B, 0), Ok(12));
    assert_eq!(bench.read_from(12, 0x1800, 1), Ok(0x18C), "COB-IDs follow");
    assert_eq!(bench.ask("601#400B100000000000"), NONE);
    bench.power_cycle();
    assert_eq!(bench.read_from(12, 0x100B, 0), Ok(12), "for good");
}

#[test]
fn what_is_not_stored_is_lost_at_power_off() {
    let mut bench = configuring();
    bench.ask("7E5#110C000000000000");
    bench.ask("7E5#1300040000000000");
    bench.power_cycle();
    assert_eq!(bench.read(0x100B, 0), Ok(1));
    assert_eq!(bench.device.bit_rate_kbit(), 500);
    assert_eq!(bench.ask("7E5#2400000000000000"), NONE, "in operation again");
    bench.ask("7E5#0401000000000000");
    bench.ask("7E5#1700000000000000");
    bench.power_cycle();
    assert_eq!(bench.read(0x100B, 0), Ok(1), "and forgotten");
}

/// 5.5.2: a bit rate of 125 kbit/s is activated and stored. The device is silent for two delays.
#[test]
fn bit_rate() {
    let mut bench = lmp30();
    bench.ask("000#0201");
    bench.ask("7E5#0401000000000000");
    assert_eq!(bench.ask("7E5#1300040000000000"), ["7E4#1300000000000000"]);
    assert_eq!(bench.device.bit_rate_kbit(), 500, "not before it is activated");
    assert_eq!(bench.ask("7E5#15E8030000000000"), NONE);
    assert_eq!(bench.device.bit_rate_kbit(), 500, "not before the first delay");
    bench.run(1_000);
    assert_eq!(bench.device.bit_rate_kbit(), 125);
    bench.run(900);
    assert_eq!(bench.ask("7E5#1700000000000000"), NONE, "in the second delay");
    bench.run(100);
    assert_eq!(bench.ask("7E5#1700000000000000"), ["7E4#1700000000000000"]);
    bench.power_cycle();
    assert_eq!(bench.device.bit_rate_kbit(), 125);
}

/// 4.7.4.2: rows 5, 6 and 7 are 50, 20 and 10 kbit/s; in the table of LSS row 5 is empty.
#[test]
fn table_of_bit_rates() {
    for (index, kbit) in (0..).zip([1_000, 800, 500, 250, 125, 50, 20, 10]) {
        let mut bench = configuring();
        assert_eq!(bench.ask(&format!("7E5#1300{index:02X}0000000000")), ["7E4#1300000000000000"], "{kbit}");
        bench.ask("7E5#1700000000000000");
        bench.power_cycle();
        assert_eq!(bench.device.bit_rate_kbit(), kbit);
    }
    let mut bench = configuring();
    for wrong in ["7E5#1300080000000000", "7E5#1300FF0000000000", "7E5#1301000000000000"] {
        assert_eq!(bench.ask(wrong), ["7E4#1301000000000000"], "{wrong}");
    }
}

/// "Switch mode selective" (4.7.3.2) needs its parts in order and is not answered. In configuration mode it has no
/// effect.
#[test]
fn switch_mode_selective() {
    const PARTS: [&str; 3] = ["7E5#0154522D454C4543", "7E5#024C4D5033300000", "7E5#0332200044002100"];
    let selected = |parts: &[&str]| {
        let mut bench = lmp30();
        for part in parts {
            assert_eq!(bench.ask(part), NONE, "{part}");
        }
        !bench.ask("7E5#2400000000000000").is_empty()
    };
    assert!(selected(&PARTS));
    let [manufacturer, product, serial] = PARTS;
    assert!(!selected(&[serial]) && !selected(&[manufacturer, serial]) && !selected(&[product, manufacturer, serial]));
    assert!(!selected(&[manufacturer, product, "7E5#0332200044002200"]));
    assert!(!selected(&[manufacturer, "7E5#024C415F34310000", serial]));
    assert!(selected(&[serial, manufacturer, product, serial]), "begins anew with the first part");
}

/// 4.7.1: the services that work in each mode.
#[test]
fn modes() {
    let mut bench = lmp30();
    let configuration = [
        "7E5#1105000000000000",
        "7E5#1300040000000000",
        "7E5#1700000000000000",
        "7E5#2400000000000000",
        "7E5#2500000000000000",
        "7E5#2600000000000000",
    ];
    for frame in configuration {
        assert_eq!(bench.ask(frame), NONE, "in operation: {frame}");
    }
    bench.ask("7E5#0402000000000000");
    assert_eq!(bench.ask("7E5#2400000000000000"), NONE, "a reserved mode");
    bench.ask("7E5#0401000000000000");
    for frame in configuration {
        assert_eq!(bench.ask(frame).len(), 1, "in configuration: {frame}");
    }
    bench.ask("7E5#0400000000000000");
    assert_eq!(bench.ask("7E5#2400000000000000"), NONE);
    // The slave ignores frames that are no LMT requests: by their length or command specifier, or as remote frames.
    bench.ask("7E5#0401000000000000");
    for frame in ["7E5#24", "7E5#", "7E5#4400000000000000", "7E5#5A00000000000000", "7E5#0900000000000000", "7E5#R"] {
        assert_eq!(bench.ask(frame), NONE, "{frame}");
    }
}

#[test]
fn node_ids_that_do_not_exist() {
    let mut bench = configuring();
    for bad in [0x00, 0x80, 0xFE, 0xFF] {
        let answer = bench.ask(&format!("7E5#11{bad:02X}000000000000"));
        assert_eq!(answer, ["7E4#11FF030000000000"], "{bad:02X}");
    }
    assert_eq!(bench.ask("7E5#117F000000000000"), ["7E4#1100000000000000"]);
}

/// 4.7.6: in both modes, 09h answers the slave's own names and a range that contains its serial number.
#[test]
fn identify_remote_slave() {
    let mut bench = lmp30();
    let mut ask = |low: &str, high: &str| -> Vec<String> {
        let bounds = [format!("07{low}"), format!("08{high}")];
        let frames = ["0554522D454C4543", "064C4D5033300000", &bounds[0], &bounds[1]];
        frames.iter().flat_map(|frame| bench.ask(&format!("7E5#{frame}"))).collect()
    };
    let found = ["7E4#0900000000000000"];
    assert_eq!(ask("32200044002100", "32200044002100"), found);
    assert_eq!(ask("00000000000000", "99999999999999"), found);
    assert_eq!(ask("32200044002101", "99999999999999"), NONE);
    assert_eq!(ask("00000000000000", "32200044002199"), found);
    assert_eq!(ask("00000000000000", "32200044002000"), NONE);
    assert_eq!(ask("99999999999999", "00000000000000"), NONE);
}

/// 4.7: rotary devices have DIP switches and no LMT slave.
#[test]
fn only_where_there_are_no_dip_switches() {
    let mut bench = Bench::new("tr-c65");
    bench.ask("7E5#0401000000000000");
    assert_eq!(bench.ask("7E5#2400000000000000"), NONE);
    assert_eq!(bench.ask("7E5#5E00000000000000"), NONE, "nor LSS");
}
