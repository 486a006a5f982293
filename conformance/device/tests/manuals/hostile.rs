//! For any frames: a device does not panic, and works after a power cycle.

use crate::bench::Bench;
use canvass_bus::Machine;
use canvass_traces::{CanId, Frame};
use proptest::prelude::*;

const MODELS: [&str; 3] = ["lika-ax58", "tr-c65", "tr-lmp30"];

/// Frames that have a meaning for these devices more often than random frames do.
fn frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![4 => Just(0x601_u32), 3 => Just(0x7E5), 1 => Just(0x000), 1 => Just(0x080), 1 => Just(0x701),
        1 => Just(0x281), 1 => 0_u32..0x800];
    let command = prop_oneof![
        prop::sample::select(vec![
            0x01_u8, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x11, 0x13, 0x15, 0x17, 0x22, 0x23, 0x24, 0x25, 0x26,
            0x2B, 0x2F, 0x40, 0x60, 0x70, 0x80, 0x81, 0x82,
        ]),
        any::<u8>(),
    ];
    let index = prop_oneof![
        prop::sample::select(vec![
            0x1001_u16, 0x1003, 0x1008, 0x100C, 0x100D, 0x1010, 0x1011, 0x1800, 0x1802, 0x2104, 0x2105, 0x3000, 0x3001,
            0x6000, 0x6001, 0x6002, 0x6003, 0x6200,
        ]),
        any::<u16>(),
    ];
    let tail = prop_oneof![Just(*b"save"), Just(*b"load"), Just([0; 4]), Just([0xFF; 4]), any::<[u8; 4]>()];
    (id, command, index, 0_u8..4, tail, 0_u8..30).prop_map(|(id, command, index, sub, tail, shape)| {
        let [low, high] = index.to_le_bytes();
        let bytes = [command, low, high, sub, tail[0], tail[1], tail[2], tail[3]];
        let id = CanId::standard_masked(id);
        match shape {
            0 | 1 => Frame::remote(id, sub).unwrap(),
            2..5 => Frame::new(id, &bytes[..usize::from(command % 9)]).unwrap(),
            5..8 => Frame::new(id, &[command, 1]).unwrap(),
            _ => Frame::full(id, bytes),
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn any_frames(
        model in prop::sample::select(MODELS.to_vec()),
        frames in prop::collection::vec((frame(), 0_u64..400, prop::bool::weighted(0.02)), 0..80),
    ) {
        let mut bench = Bench::new(model);
        for (frame, pause, power) in frames {
            bench.device.handle(bench.now, &frame);
            prop_assert!(bench.run(pause).len() <= 256 + pause as usize * 2);
            if power {
                bench.power_cycle();
            }
        }
        bench.power_cycle();
        bench.run(1_000);
        let node = bench.device.node().map(canvass_analyzer::NodeId::raw);
        prop_assert!(node.is_some());
        prop_assert!(bench.read_from(node.unwrap(), 0x1000, 0).is_ok());
    }
}
