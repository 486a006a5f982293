//! The order and duration of frames on the simulated bus.

use crate::rig::{Rig, model, parse};
use canvass_analyzer::NodeId;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::{Device, Faults};
use canvass_traces::{Direction, Timestamp, bit_length};

#[test]
fn frames_take_their_bits_and_three_more_in_between() {
    let mut bus = SimulatedBus::new(1_000_000);
    let frames = [parse("123#"), parse("7FF#0000000000000000"), parse("1ABCDEF0#R8")];
    frames.iter().for_each(|frame| bus.send(frame).unwrap());
    let mut begin = 0;
    for frame in &frames {
        let end = begin + 1_000 * u64::from(bit_length(frame).unwrap());
        let record = bus.receive(Timestamp(10_000_000)).unwrap().unwrap();
        assert_eq!((record.timestamp, record.frame, record.direction), (Timestamp(end), *frame, Direction::Tx));
        begin = end + 3_000;
    }
    assert_eq!(bus.receive(Timestamp(10_000_000)).unwrap(), None);
    assert_eq!(bus.now(), Timestamp(10_000_000));
}

#[test]
fn the_lowest_identifier_wins() {
    let mut bus = SimulatedBus::new(250_000);
    for node in [70, 5, 63] {
        bus.attach(Box::new(Device::new(model(), NodeId::new(node), Faults::NONE, 0)));
    }
    let boots: Vec<String> = std::iter::from_fn(|| bus.receive(Timestamp(1_000_000_000)).unwrap())
        .map(|record| record.frame.to_string())
        .collect();
    assert_eq!(boots, ["705#00", "73F#00", "746#00"]);
    bus.send(&parse("000#0100")).unwrap();
    bus.send(&parse("080#")).unwrap();
    let ids: Vec<u16> = std::iter::from_fn(|| bus.receive(Timestamp(2_000_000_000)).unwrap())
        .filter_map(|record| record.frame.cob_id())
        .collect();
    assert_eq!(ids[..2], [0x000, 0x080], "SYNC goes before all PDOs");
    // Each device has at most one frame in arbitration at a time.
    assert_eq!(ids[2..5], [0x185, 0x1BF, 0x1C6]);
    assert!(ids.contains(&0x285), "{ids:X?}");
}

/// The bus refuses frames that no classical controller can send.
#[test]
fn only_classical_frames() {
    let id = parse("123#").id();
    let fd = canvass_traces::Frame::fd(id, canvass_traces::Flags::NONE, &[0; 12]).unwrap();
    assert!(Rig::new().bus.send(&fd).unwrap_err().to_string().contains("classical"));
}

/// Equal seeds give equal bytes at equal times; another seed gives other times.
#[test]
fn runs_repeat_exactly() {
    let run = |seed| {
        let mut bus = SimulatedBus::new(250_000);
        bus.attach(Box::new(Device::new(model(), NodeId::new(63), Faults::NONE, seed)));
        let mut records = Vec::new();
        for n in 0..50 {
            bus.send(&parse(if n % 3 == 0 { "000#013F" } else { "63F#4008100000000000" })).unwrap();
            let deadline = Timestamp(300_000_000 + n * 5_000_000);
            while let Some(record) = bus.receive(deadline).unwrap() {
                records.push(record);
            }
        }
        records
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}
