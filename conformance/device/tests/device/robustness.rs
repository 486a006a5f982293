//! For any frames in any state: the device does not panic or loop for ever, and can still be reset and read.

use crate::rig::{Rig, model};
use canvass_analyzer::NodeId;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::Fault;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_traces::{CanId, Duration, Frame};
use proptest::prelude::*;

/// Frames that have a meaning for the device more often than random frames do.
fn frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        6 => Just(0x63F_u32), 2 => Just(0x000), 1 => Just(0x080), 2 => Just(0x7E5), 1 => 0x700_u32..0x780,
        1 => Just(0x1BF), 1 => Just(0x23F), 1 => Just(0x43F), 1 => Just(0x100), 1 => 0_u32..0x800,
    ];
    let command = prop_oneof![
        prop::sample::select(vec![
            0x00_u8, 0x01, 0x10, 0x11, 0x20, 0x21, 0x22, 0x23, 0x27, 0x2B, 0x2F, 0x40, 0x60, 0x70, 0x80, 0x81, 0x82,
            0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0xC0, 0xC2, 0xC6, 0xD5, 0x04, 0x11, 0x13, 0x17, 0x51, 0x5E, 0x02,
        ]),
        any::<u8>(),
    ];
    let index = prop_oneof![
        prop::sample::select(vec![
            0x1003_u16, 0x1005, 0x1008, 0x100C, 0x100D, 0x1010, 0x1015, 0x1016, 0x1017, 0x1029, 0x1800, 0x1801, 0x1A00,
            0x2101, 0x2105, 0x2120, 0x2140, 0x1006, 0x1012, 0x1014, 0x1019, 0x1028, 0x1201, 0x1400, 0x1402, 0x1600,
            0x1602, 0x1F80, 0x2010, 0x2030, 0x2041, 0x6200, 0x6411, 0x6000, 0x6001, 0x6002, 0x6003, 0x6200, 0x3F3F,
        ]),
        any::<u16>(),
    ];
    let tail = (
        0_u8..9,
        prop_oneof![Just(*b"save"), Just([0; 4]), Just([0xFF; 4]), Just([0xBF, 1, 0, 0x80]), any::<[u8; 4]>()],
    );
    (id, command, index, tail, 0_u8..40).prop_map(|(id, command, index, (sub, tail), shape)| {
        let [low, high] = index.to_le_bytes();
        let bytes = [command, low, high, sub, tail[0], tail[1], tail[2], tail[3]];
        let id = CanId::standard_masked(id);
        match shape {
            0 => Frame::remote(id, sub.min(8)).unwrap(),
            1 => Frame::full(CanId::extended_masked(id.raw()), bytes),
            2..8 => Frame::new(id, &bytes[..usize::from(sub.min(8))]).unwrap(),
            8..14 => Frame::new(id, &[command, 63]).unwrap(),
            _ => Frame::full(id, bytes),
        }
    })
}

fn faults() -> impl Strategy<Value = Faults> {
    prop_oneof![
        3 => Just(Faults::NONE),
        1 => prop::sample::subsequence(Fault::ALL.to_vec(), 0..6).prop_map(|some| some.into_iter().collect()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_frames(
        frames in prop::collection::vec((frame(), 0_u64..30_000), 0..60), faults in faults(), milli_rpm in -1_000_000_i64..1_000_000,
        configured in prop::bool::weighted(0.9),
    ) {
        let node = configured.then(|| NodeId::new(63).unwrap());
        let mut bus = SimulatedBus::new(1_000_000);
        bus.attach(Box::new(Device::with_motion(model(), node, faults, 3, &Motion::constant(0, milli_rpm))));
        let mut received = 0_u32;
        for (frame, pause) in &frames {
            bus.send(frame).unwrap();
            let deadline = bus.now() + Duration::from_micros(*pause);
            while bus.receive(deadline).unwrap().is_some() {
                received += 1;
            }
        }
        // The run lasts at most 1.8 s, in which a bus at 1 Mbit/s transmits fewer frames.
        prop_assert!(received < 50_000);
    }

    /// No frames make any model in any state panic, and the device can be switched off and on again.
    #[test]
    fn any_frames_to_any_model(
        frames in prop::collection::vec((frame(), 0_u64..20_000), 0..60), faults in faults(), state in 0_u8..5,
    ) {
        for model in Model::all() {
            let node = (state != 4).then(|| NodeId::new(63).unwrap());
            let mut bus = SimulatedBus::new(1_000_000);
            bus.attach(Box::new(Device::with_motion(model, node, faults, 3, &Motion::constant(0, 77_777))));
            // State 0 is initialisation; the other states are pre-operational, operational, stopped, and a device
            // without node-ID.
            let begin = bus.now() + Duration::from_millis(if state == 0 { 1 } else { 400 });
            while bus.receive(begin).unwrap().is_some() {}
            if let Some(command) = [None, None, Some(1), Some(2), None].get(usize::from(state)).copied().flatten() {
                bus.send(&Frame::new(CanId::standard_masked(0), &[command, 63]).unwrap()).unwrap();
            }
            for (frame, pause) in &frames {
                bus.send(frame).unwrap();
                let deadline = bus.now() + Duration::from_micros(*pause);
                while bus.receive(deadline).unwrap().is_some() {}
            }
            bus.power_cycle(0);
            let deadline = bus.now() + Duration::from_millis(400);
            while bus.receive(deadline).unwrap().is_some() {}
        }
    }

    /// After any frames and a reset, a fault-free device answers again, and never sends frames that nobody requested.
    #[test]
    fn alive_after_a_reset(frames in prop::collection::vec((frame(), 0_u64..30_000), 0..40)) {
        let mut rig = Rig::new();
        for (frame, pause) in &frames {
            rig.bus.send(frame).unwrap();
            rig.records(*pause / 1000);
        }
        rig.run(1000);
        for node in 1..=127 {
            rig.send(&format!("000#81{node:02X}"));
        }
        let boots = rig.run(1000);
        prop_assert!(boots.iter().any(|frame| frame.starts_with('7') && frame.ends_with("#00")), "{boots:?}");
    }
}
