//! The bus of PEAK's adapters, with a stand-in for PEAK's library that follows the documentation of its interface.
#![cfg(test)]
#![cfg(any(windows, target_os = "linux"))]

mod stand_in;

use canvass_bus::pcan::{Opening, Pcan, PcanError};
use canvass_bus::{Bus, BusError};
use canvass_traces::{CanId, Direction, Duration, Frame, Record};
use stand_in::{Function, Message, StandIn};

const EXTENDED: u8 = 2;
const ERROR: u8 = 0x40;
const STATUS: u8 = 0x80;

fn frame(id: u32, data: &[u8]) -> Frame {
    Frame::new(CanId::standard(id).unwrap(), data).unwrap()
}

fn message(id: u32, kind: u8, data: &[u8]) -> Message {
    let mut message = Message { id, kind, length: data.len() as u8, data: [0; 8] };
    message.data[..data.len()].copy_from_slice(data);
    message
}

/// The next record, which must exist.
fn next(bus: &mut Pcan) -> Record {
    bus.receive(bus.now() + Duration::from_secs(20)).unwrap().expect("a frame")
}

/// Waits until a condition holds.
fn until(bus: &mut Pcan, so: impl Fn(&Pcan) -> bool) {
    let end = bus.now() + Duration::from_secs(20);
    while !so(bus) {
        assert!(bus.now() < end, "{:?}", bus.health());
        bus.receive(bus.now() + Duration::from_millis(5)).unwrap();
    }
}

fn reason(opened: Result<Pcan, PcanError>) -> String {
    opened.err().expect("an error").to_string()
}

#[test]
fn frames_go_out_and_come_in() {
    let stand_in = StandIn::plugged(1);
    let mut bus = stand_in.open(250_000).unwrap();
    assert_eq!(stand_in.open_with(), Some((0x011C, false, 1)));
    assert_eq!((bus.bit_rate(), bus.is_live()), (Some(250_000), true));
    let extended = Frame::new(CanId::extended(0x1234_5678).unwrap(), &[9; 8]).unwrap();
    let remote = Frame::remote(CanId::standard(0x705).unwrap(), 1).unwrap();
    for frame in [frame(0x600, &[1, 2, 3]), extended, remote] {
        bus.send(&frame).unwrap();
        let own = next(&mut bus);
        assert_eq!((own.frame, own.direction), (frame, Direction::Tx));
    }
    let sent = stand_in.sent();
    assert_eq!(sent, [message(0x600, 0, &[1, 2, 3]), message(0x1234_5678, 2, &[9; 8]), message(0x705, 1, &[0])]);
    stand_in.receive(message(0x1ABC_DEF0, EXTENDED, &[7, 8]), 1_000_000, 1);
    let came = next(&mut bus);
    assert_eq!((came.frame.to_string().as_str(), came.direction), ("1ABCDEF0#0708", Direction::Rx));
    let fd = Frame::fd(CanId::standard(1).unwrap(), canvass_traces::Flags::BRS, &[0; 12]).unwrap();
    assert!(matches!(bus.send(&fd), Err(BusError::Unsendable { .. })));
    drop(bus);
    assert_eq!(stand_in.open_with(), None, "the channel is closed");
}

/// The intervals between frames follow the adapter's clock, whatever its origin and however late the frames are
/// fetched.
#[test]
fn times_are_those_of_the_adapter() {
    let stand_in = StandIn::plugged(2);
    let mut bus = stand_in.open(1_000_000).unwrap();
    let before = bus.now();
    // The counter of milliseconds overflows between the second and the third frame.
    let begin = (u64::from(u32::MAX) - 1) * 1_000 + 250;
    stand_in.receive(message(0x181, 0, &[1]), begin, 5);
    let times: Vec<_> = (0..5).map(|_| next(&mut bus).timestamp).collect();
    let intervals: Vec<u64> = times.windows(2).map(|pair| pair[1].since(pair[0]).nanos()).collect();
    assert!(intervals[..3].iter().all(|interval| *interval <= 1_000_000), "{intervals:?}");
    assert!(times[0] + Duration::from_millis(10) >= before && times[4] <= bus.now(), "{times:?}");
    // Once the offset is known, the interval is right to the microsecond.
    std::thread::sleep(std::time::Duration::from_millis(30));
    stand_in.receive(message(0x182, 0, &[1]), begin + 10_003, 1);
    let interval = next(&mut bus).timestamp.since(times[4]).nanos();
    assert!(interval.abs_diff(6_003_000) <= 1_000, "{interval}");
}

/// Every loss is counted: frames for which the library had no room, and losses that the state of the bus reports.
#[test]
fn overruns_are_counted_and_told() {
    let stand_in = StandIn::plugged(3);
    let mut bus = stand_in.open(500_000).unwrap();
    stand_in.receive(message(0x181, 0, &[1]), 5_000_000, 600);
    let received = (0..512).filter(|_| next(&mut bus).frame.cob_id() == Some(0x181)).count();
    assert_eq!(received, 512);
    until(&mut bus, |bus| bus.health().lost >= 1);
    let trouble = bus.health().trouble.unwrap();
    assert!(trouble.contains("PCAN_USBBUS3") && trouble.contains("not fetched in time"), "{trouble}");
    // The library reports a loss by a message, too.
    let lost = bus.health().lost;
    stand_in.receive(message(0, STATUS, &[0, 0, 0, 0x02]), 6_000_000, 1);
    until(&mut bus, |bus| bus.health().lost > lost);
    // A state that persists is counted once.
    let lost = bus.health().lost;
    stand_in.bus(0x40);
    until(&mut bus, |bus| bus.health().lost > lost);
    let end = bus.now() + Duration::from_millis(300);
    while bus.now() < end {
        bus.receive(end).unwrap();
    }
    assert_eq!(bus.health().lost, lost + 1);
}

#[test]
fn error_frames_and_the_state_of_the_bus_are_seen() {
    let stand_in = StandIn::plugged(4);
    let mut bus = stand_in.open(250_000).unwrap();
    stand_in.receive(message(4, ERROR, &[1, 10, 7, 0]), 1_000_000, 1);
    let error = next(&mut bus).frame;
    assert!(error.is_error() && bus.health().error_frames == 1);
    assert_eq!(error.data()[2..4], [0x04, 10], "a stuff error in the data");
    stand_in.bus(0x40000);
    until(&mut bus, |bus| bus.health().trouble.is_some());
    let trouble = bus.health().trouble.unwrap();
    assert!(trouble.contains("error-passive") && trouble.contains("check the wiring"), "{trouble}");
    assert_eq!(bus.health().interruptions, 0);
    stand_in.bus(0x10);
    let class = |record: &Record| record.frame.error_class().map(|class| class.0);
    assert_eq!(class(&next(&mut bus)), Some(0x40), "bus-off");
    assert_eq!(bus.health().interruptions, 1);
    let off = bus.send(&frame(1, &[])).unwrap_err().to_string();
    assert!(off.contains("can't send on PCAN_USBBUS4") && off.contains("bus-off"), "{off}");
    assert!(bus.receive(bus.now()).unwrap().is_none(), "what was not sent was not on the bus");
    stand_in.bus(0);
    assert_eq!(class(&next(&mut bus)), Some(0x100), "restarted");
    bus.send(&frame(1, &[])).unwrap();
}

#[test]
fn a_full_transmit_queue_is_waited_for() {
    let stand_in = StandIn::plugged(5);
    let mut bus = stand_in.open(250_000).unwrap();
    stand_in.hold(true);
    (0..16).for_each(|n| bus.send(&frame(n, &[])).unwrap());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            stand_in.hold(false);
        });
        bus.send(&frame(16, &[])).unwrap();
    });
    assert!(bus.health().waits > 0 && bus.health().transmit.longest() > Some(Duration::from_millis(20)));
    stand_in.hold(true);
    (0..16).for_each(|n| bus.send(&frame(n, &[])).unwrap());
    stand_in.bus(0x08);
    let full = bus.send(&frame(1, &[])).unwrap_err().to_string();
    assert!(full.contains("has sent nothing for 2") && full.contains("BUSHEAVY"), "{full}");
    // No node acknowledges, so the silence of the device proves nothing.
    assert!(bus.health().interrupted_since.is_some(), "{:?}", bus.health());
    stand_in.hold(false);
    bus.send(&frame(1, &[])).unwrap();
    assert_eq!((bus.health().interruptions, bus.health().interrupted_since), (1, None));
}

#[test]
fn a_listener_sends_and_acknowledges_nothing() {
    let stand_in = StandIn::plugged(6);
    let opening = Opening { channel: stand_in.channel, bit_rate: 125_000, listen_only: true };
    let mut bus = stand_in.open_as(opening).unwrap();
    assert_eq!(stand_in.open_with(), Some((0x031C, true, 1)));
    let refused = bus.send(&frame(1, &[])).unwrap_err().to_string();
    assert!(refused.contains("only listens") && refused.contains("+listen-only"), "{refused}");
    assert!(stand_in.sent().is_empty());
    stand_in.receive(message(0x701, 0, &[5]), 1_000, 1);
    assert_eq!(next(&mut bus).frame.to_string(), "701#05");
}

#[test]
fn an_adapter_that_is_unplugged_is_opened_again() {
    let stand_in = StandIn::plugged(7);
    let mut bus = stand_in.open(250_000).unwrap();
    stand_in.plug(0);
    until(&mut bus, |bus| bus.health().interruptions == 1);
    let trouble = bus.health().trouble.unwrap();
    assert!(trouble.contains("PCAN_USBBUS7 was disconnected") && trouble.contains("ILLHW"), "{trouble}");
    let refused = bus.send(&frame(1, &[])).unwrap_err();
    assert!(bus.is_interrupted() && refused.is_interruption() && refused.to_string().contains("plug it in"));
    stand_in.plug(1);
    until(&mut bus, |_| stand_in.open_with() == Some((0x011C, false, 2)));
    stand_in.receive(message(0x701, 0, &[5]), 1_000, 1);
    until(&mut bus, |bus| bus.health().receive.count() > 0);
    assert!(!bus.is_interrupted());
    let health = bus.health();
    assert_eq!(health.interruptions, 1);
    // The receiving thread looks for a lost adapter every 200 ms.
    assert!(health.interrupted_for >= Duration::from_millis(150), "{health:?}");
}

#[test]
fn the_bit_rate_is_changed_with_the_channel_closed() {
    let stand_in = StandIn::plugged(8);
    let mut bus = stand_in.open(250_000).unwrap();
    bus.set_bit_rate(500_000).unwrap();
    assert_eq!((stand_in.open_with(), bus.bit_rate()), (Some((0x001C, false, 2)), Some(500_000)));
    let wrong = bus.set_bit_rate(123_456).unwrap_err().to_string();
    assert!(wrong.contains("123456") && wrong.contains("125k"), "{wrong}");
    assert_eq!((stand_in.open_with(), bus.bit_rate()), (Some((0x001C, false, 2)), Some(500_000)));
    bus.listen_at(125_000).unwrap();
    assert_eq!((stand_in.open_with(), bus.bit_rate()), (Some((0x031C, true, 3)), Some(125_000)));
    bus.set_bit_rate(500_000).unwrap();
    assert_eq!((stand_in.open_with(), bus.bit_rate()), (Some((0x001C, false, 4)), Some(500_000)));
    bus.send(&frame(5, &[1])).unwrap();
    assert_eq!((stand_in.sent().len(), bus.health().interruptions), (1, 0));
}

#[test]
fn whatever_the_library_answers_the_error_says_what_to_do() {
    let stand_in = StandIn::plugged(9);
    for (status, says) in [
        (0x200, "PEAK's driver is not loaded (PCAN_ERROR_NODRIVER): install it"),
        (0x400, "another program has the adapter, at another bit rate (PCAN_ERROR_HWINUSE): close that program"),
        (0x1400, "there is no such adapter (PCAN_ERROR_ILLHW): plug it in"),
        (0x1C00, "there is no such channel (PCAN_ERROR_ILLHANDLE): plug it in"),
        (0x2000, "PCAN_ERROR_RESOURCE"),
        (0x4000000, "PCAN_ERROR_INITIALIZE"),
        (0x40000000, "status 40000000h"),
    ] {
        stand_in.answer(Function::Initialize, status);
        let text = reason(stand_in.open(250_000));
        assert!(text.starts_with("can't open PCAN_USBBUS9: ") && text.contains(says), "{status:X}h: {text}");
    }
    stand_in.answer(Function::Initialize, 0);
    stand_in.plug(2);
    assert!(reason(stand_in.open(250_000)).contains("HWINUSE"));
    assert!(reason(stand_in.open(123_456)).contains("expected one of 5k"));
    stand_in.plug(1);
    let mut bus = stand_in.open(250_000).unwrap();
    stand_in.answer(Function::Write, 0x20000);
    assert!(bus.send(&frame(1, &[])).unwrap_err().to_string().contains("ILLDATA"));
    for function in [Function::Read, Function::GetStatus] {
        let before = bus.health().interruptions;
        stand_in.answer(function, 0x200);
        until(&mut bus, |bus| bus.health().interruptions > before);
        assert!(bus.health().trouble.is_some_and(|trouble| trouble.contains("NODRIVER")));
        stand_in.answer(function, 0);
        until(&mut bus, |_| stand_in.open_with().is_some());
    }
}

#[test]
fn a_library_that_is_not_there_or_is_another_one() {
    let channel = "PCAN_USBBUS1".parse().unwrap();
    let opening = Opening { channel, bit_rate: 250_000, listen_only: false };
    let folder = tempfile::tempdir().unwrap();
    let missing = Pcan::open_with(&folder.path().join("libpcanbasic.so"), opening);
    let missing = reason(missing);
    assert!(missing.contains("can't load") && missing.contains("PCAN-Basic"), "{missing}");
    let other = if cfg!(windows) { "kernel32.dll" } else { "libc.so.6" };
    let other = reason(Pcan::open_with(std::path::Path::new(other), opening));
    assert!(other.contains("has no CAN_Initialize") && other.contains("current version"), "{other}");
}
