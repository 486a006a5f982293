//! Equal seeds give equal bytes at equal times.

use canvass_device::address::open_seeded;
use canvass_traces::{CanId, Duration, Frame, Record, Timestamp};

/// One hour of a network with a master's requests. With another seed the devices answer at other times.
#[test]
fn a_simulated_hour() {
    let run = |seed| {
        let address = "sim:reference-406@250k~sine=3,7+reference-301+kuebler-sendix-58x8~rpm=100+heartbeat-burst";
        let mut bus = open_seeded(address, seed).unwrap().bus;
        let send = |bus: &mut dyn canvass_bus::Bus, id: u32, bytes: &[u8]| {
            bus.send(&Frame::new(CanId::standard_masked(id), bytes).unwrap()).unwrap();
        };
        let mut records: Vec<Record> = Vec::new();
        let listen = |bus: &mut dyn canvass_bus::Bus, records: &mut Vec<Record>, millis: u64| {
            let deadline = bus.now() + Duration::from_millis(millis);
            while let Some(record) = bus.receive(deadline).unwrap() {
                records.push(record);
            }
        };
        listen(bus.as_mut(), &mut records, 1_000);
        for node in [20_u8, 10, 63] {
            send(bus.as_mut(), 0x600 + u32::from(node), &[0x2B, 0x17, 0x10, 0, 0xE8, 3, 0, 0]);
            listen(bus.as_mut(), &mut records, 50);
        }
        // TPDO 1 is sent only by its timer: on every change it would be sent a thousand times a second.
        send(bus.as_mut(), 0x614, &[0x2F, 0x00, 0x18, 2, 0xFF, 0, 0, 0]);
        listen(bus.as_mut(), &mut records, 50);
        send(bus.as_mut(), 0x614, &[0x2B, 0x00, 0x62, 0, 0xF4, 1, 0, 0]);
        listen(bus.as_mut(), &mut records, 50);
        send(bus.as_mut(), 0x000, &[1, 0]);
        while bus.now() < Timestamp(3_600_000_000_000) {
            send(bus.as_mut(), 0x614, &[0x40, 0x04, 0x60, 0, 0, 0, 0, 0]);
            send(bus.as_mut(), 0x60A, &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
            listen(bus.as_mut(), &mut records, 5_000);
        }
        records
    };
    let first = run(7);
    assert!(first.len() > 15_000, "{}", first.len());
    assert!(first == run(7));
    assert!(first != run(8));
}
