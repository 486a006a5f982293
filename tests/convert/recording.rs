//! A recording with all kinds of frames that a capture can have, as a candump log.

use std::fmt::Write;

pub const FRAMES: usize = 6_000;

/// A recording that never changes: standard, extended, remote, error, CAN FD and CAN XL frames, raw DLCs, directions
/// known and not, on three channels, with times of a nanosecond.
pub fn log() -> String {
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    let mut nanos = 1_700_000_000_000_000_123_u64;
    (0..FRAMES).fold(String::new(), |mut log, _| {
        nanos += random.below(2_000_000);
        let channel = ["can0", "can1", "vcan-test"][random.below(3) as usize];
        let frame = frame(&mut random);
        let direction = ["", " R", " T"][random.below(3) as usize];
        writeln!(log, "({}.{:09}) {channel} {frame}{direction}", nanos / 1_000_000_000, nanos % 1_000_000_000).unwrap();
        log
    })
}

fn frame(random: &mut Random) -> String {
    let id = match random.below(2) {
        0 => format!("{:03X}", random.below(0x800)),
        _ => format!("{:08X}", random.below(0x2000_0000)),
    };
    let bytes = |random: &mut Random, len: u64| (0..len).fold(String::new(), |hex, _| hex + &byte(random));
    match random.below(20) {
        0 => format!("{id}#R"),
        1 => format!("{id}#R{}", 1 + random.below(8)),
        2 => format!("20000080#{}", "00".repeat(8)),
        3 => format!("{:08X}#{}", 0x2000_0000 | random.below(0x400), bytes(random, 8)),
        4..=7 => {
            const LENGTHS: [u64; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
            let len = LENGTHS[random.below(16) as usize];
            format!("{id}##{:X}{}", 4 + random.below(4), bytes(random, len))
        }
        8 => {
            let (len, priority) = (1 + random.below(2048), random.below(0x800));
            format!(
                "{:02X}{priority:03X}#81:05:{:08X}#{}",
                random.below(256),
                random.below(1 << 32),
                bytes(random, len)
            )
        }
        9 => format!("{id}#{}_{:X}", bytes(random, 8), 9 + random.below(7)),
        _ => {
            let len = random.below(9);
            format!("{id}#{}", bytes(random, len))
        }
    }
}

fn byte(random: &mut Random) -> String {
    format!("{:02X}", random.below(256))
}

/// Random numbers that are the same on all machines (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % limit
    }
}
