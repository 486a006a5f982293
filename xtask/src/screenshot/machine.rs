//! A capture of a machine with an encoder that loses its supply.

use anyhow::Result;
use std::fmt::Write;

/// Half a minute: node 5 has no supply from 12 to 20.3 s, node 2 misses the heartbeat of node 5 and becomes
/// pre-operational, and a master resets node 5 twice in vain.
pub fn machine() -> Result<String> {
    let mut frames: Vec<(u64, String)> = [
        (211, "702#00"),
        (217, "705#00"),
        (223, "707#00"),
        (300, "605#2B171000F4010000"),
        (302, "585#6017100000000000"),
        (310, "602#23161001DC050500"),
        (312, "582#6016100100000000"),
        (800, "000#0100"),
        (13_530, "082#3081110000000000"),
        (14_200, "605#4041600000000000"),
        (15_000, "000#8105"),
        (16_500, "605#8041600000000405"),
        (18_000, "000#8105"),
        (20_300, "705#00"),
        (20_900, "000#0105"),
        (22_000, "082#0000000000000000"),
        (22_400, "000#0102"),
    ]
    .map(|(at, frame)| (at, frame.to_owned()))
    .to_vec();
    let (lost, stopped) = (12_000..20_500, 13_600..22_500);
    for at in (0..30_000).step_by(500) {
        let state = |is_waiting: bool| if at < 1_000 || is_waiting { "7F" } else { "05" };
        frames.push((at + 3, "701#05".to_owned()));
        if at > 0 {
            frames.push((at + 11, format!("702#{}", state(stopped.contains(&at)))));
            frames.push((at + 23, format!("707#{}", state(false))));
        }
        if at > 0 && !lost.contains(&at) {
            frames.push((at + 17, format!("705#{}", state(at < 21_000 && at > lost.end - 1))));
        }
    }
    for at in (1_000..30_000).step_by(20) {
        let [low, high, ..] = (at / 20 * 37_u64).to_le_bytes();
        frames.push((at, "080#".to_owned()));
        frames.push((at + 3, format!("187#{low:02X}")));
        if !(lost.start..21_000).contains(&at) {
            frames.push((at + 1, format!("185#{low:02X}{high:02X}0000")));
        }
        if !stopped.contains(&at) {
            frames.push((at + 2, format!("182#{low:02X}0200")));
        }
    }
    frames.sort();
    let mut log = String::new();
    for (at, frame) in frames {
        writeln!(log, "({}.{:03}000) can0 {frame}", 1_700_000_000 + at / 1_000, at % 1_000)?;
    }
    Ok(log)
}
