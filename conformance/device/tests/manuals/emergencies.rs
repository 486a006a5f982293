//! The EMCY messages that the manuals print, each caused by the error that it reports.

use crate::bench::Bench;
use canvass_analyzer::wire::emcy::EmcyCode;

/// Section 5.8: each error sends one EMCY, and EMCY 0000h when it is gone; 1001h and 1003h show the same error.
#[test]
fn kuebler() {
    let text = include_str!("kuebler-emergencies.csv");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let mut sent = 0;
    for row in rows {
        let [section, models, code, bytes, _] = row.split(';').collect::<Vec<_>>()[..] else { panic!("{row}") };
        let (code, bytes) = (u16::from_str_radix(code, 16).unwrap(), bytes.replace(' ', ""));
        for model in models.split(' ') {
            let (mut bench, _) = Bench::started(&format!("kuebler-sendix-{model}"), 63);
            let set = |bench: &mut Bench, present| {
                bench.device.set_error(bench.now, EmcyCode(code), present);
                bench.run(50)
            };
            let printed = format!("0BF#{bytes}");
            assert_eq!(set(&mut bench, true), [printed], "{section} {model}");
            assert_eq!(set(&mut bench, true), [""; 0], "{section} {model}: once");
            let register = u32::from_str_radix(&bytes[4..6], 16).unwrap();
            assert_eq!(bench.read_from(63, 0x1001, 0), Ok(register), "{section} {model}");
            assert_eq!(
                bench.read_from(63, 0x1003, 1).map(|entry| entry & 0xFFFF),
                Ok(code.into()),
                "{section} {model}"
            );
            assert_eq!(set(&mut bench, false), ["0BF#0000000000000000"], "{section} {model}");
            assert_eq!(bench.read_from(63, 0x1001, 0), Ok(0), "{section} {model}");
            sent += 1;
        }
    }
    assert_eq!(sent, 40);
}

/// Section 5.5.12: the NMT state after an error, by the class of the error.
#[test]
fn error_behaviour_by_class() {
    for (code, sub) in [(0x8120, 1), (0xFF00, 2), (0x5051, 2), (0x5000, 3)] {
        for (behaviour, state) in [(0, "7F"), (1, "05"), (2, "04")] {
            let (mut bench, _) = Bench::started("kuebler-sendix-58x8", 63);
            bench.ask(&format!("63F#2F2910{sub:02X}{behaviour:02X}000000"));
            bench.ask("63F#2B17100032000000");
            bench.ask("000#013F");
            bench.device.set_error(bench.now, EmcyCode(code), true);
            let sent = bench.run(110);
            assert_eq!(
                sent.last(),
                Some(&format!("73F#{state}")),
                "{code:04X}h, 1029h:{sub:02X} = {behaviour}: {sent:?}"
            );
        }
    }
}
