use crate::traffic::{Traffic, diagnose, frame, machine};
use canvass_analyzer::findings::Severity;
use canvass_traces::{INTERMISSION, bit_length};

#[test]
fn a_full_bus() {
    let mut traffic = machine();
    // 2000 frames of 8 bytes in a second fill a bus of 500 kbit/s by half; 4400 by more than nine tenths.
    for n in 0..10_000_u64 {
        traffic.micros(5_000_000 + n * 227, &format!("3A{:X}#0123456789ABCDEF", n % 8));
    }
    let found = traffic.results().findings;
    let load = found.iter().find(|finding| finding.rule.id == "bus/load").expect("the load");
    assert!(load.message.contains("of 500 kbit/s"), "{}", load.message);
    assert_eq!(diagnose(&machine().records(), |_| {}).buses[0].1.bit_rate, Some(500_000));
}

#[test]
fn a_restricted_can_id() {
    let mut traffic = machine();
    traffic.sdo(600, 4, "2301180101010040", "6001180100000000");
    traffic.finds("bus/restricted-cob-id", Some(4), 603);
    let mut switched_off = machine();
    switched_off.sdo(600, 4, "23011801010100C0", "6001180100000000").only(&[]);
}

#[test]
fn two_nodes_with_one_cob_id() {
    let mut traffic = machine();
    traffic.sdo(600, 4, "2301180183010040", "6001180100000000");
    // From now on the PDO counts as a PDO of node 4.
    let wrong = ["bus/overlapping-cob-id", "nodes/pdo-outside-operational", "bus/before-boot-up"];
    let finding = traffic.finds_among(&wrong, wrong[0], Some(4), 603);
    assert!(finding.message.contains("of node 3"), "{}", finding.message);
}

#[test]
fn a_second_sync_producer() {
    let mut traffic = machine();
    traffic.remove(|_, frame| frame.id().as_standard() == Some(0x080));
    traffic.every(1_020, 30_000, 20, |_| "080#".to_owned()).every(15_007, 30_000, 20, |_| "080#".to_owned());
    let found = traffic.results().findings;
    assert!(found.iter().any(|finding| finding.rule.id == "bus/two-producers"), "{found:?}");
}

#[test]
fn two_devices_with_one_node_id() {
    let all = ["bus/duplicate-node-id", "nodes/boot-up-without-command", "nodes/heartbeat-jitter", "nodes/state-lost"];
    // The second device is not started, so its heartbeats show another state.
    let mut states = machine();
    states.every(5_025, 30_000, 100, |_| "703#7F".to_owned());
    let found = states.only(&[all[0], all[2], all[3], "nodes/heartbeat-late"]);
    assert!(found.iter().any(|finding| finding.rule.id == all[0] && finding.node.is_some_and(|node| node.raw() == 3)));
    // The heartbeats of the second device show the same state at another moment of the period.
    let mut phases = machine();
    phases.every(5_085, 30_000, 100, |_| "703#05".to_owned());
    phases.finds_among(&[all[0], all[2]], all[0], Some(3), 5_560);
    // One request gets two answers.
    let mut answers = machine();
    answers.sdo(6_100, 3, "4018100400000000", "4318100439300000").at(6_104, "583#4318100400000001");
    let found = answers.only(&[all[0], "sdo/protocol-violation"]);
    assert!(found.iter().any(|finding| finding.rule.id == all[0]), "{found:?}");
    // A second read returns another serial number.
    let mut identity = machine();
    identity.sdo(6_100, 3, "4018100400000000", "4318100400000001");
    identity.finds(all[0], Some(3), 6_103);
}

#[test]
fn a_heartbeat_before_the_boot_up() {
    let mut traffic = machine();
    traffic.at(20_110, "704#7F");
    traffic.finds("bus/before-boot-up", Some(4), 20_110);
}

#[test]
fn can_ids_of_nobody() {
    let mut traffic = machine();
    traffic.every(2_000, 3_000, 100, |_| "6E1#0102".to_owned());
    let finding = traffic.finds("bus/unknown-ids", None, 2_000);
    assert!(finding.message.contains("10 frames on 1 CAN-IDs: 6E1h"), "{}", finding.message);
}

#[test]
fn a_capture_of_many_channels_is_bounded() {
    let mut records = Vec::new();
    for channel in 0..100 {
        let mut record = Traffic::default().at(0, "701#05").records().remove(0);
        record.channel = canvass_traces::ChannelId(channel);
        records.push(record);
    }
    let results = diagnose(&records, |_| {});
    assert_eq!((results.buses.len(), results.unwatched), (64, 36));
}

#[test]
fn a_second_producer_of_time_and_of_a_pdo() {
    let mut time = machine();
    time.every(15_830, 30_000, 1_000, |n| format!("100#{} 0010", crate::traffic::hex(3_600_000 + 14_330 + n * 1000)));
    // The commands at 20 000 and 20 500 ms restart the detection.
    time.finds("bus/two-producers", None, 25_500);
    // 283h has an event timer of 50 ms; from here on the PDO comes twice in that time.
    let mut timed = machine();
    timed.every(15_019, 30_000, 50, |_| "283#FFFF".to_owned());
    timed.finds("bus/two-producers", Some(3), 15_250);
    let mut synchronous = machine();
    for cycle in 0..100_u64 {
        synchronous.micros(15_000_900 + cycle * 20_000, &format!("183#{}", crate::traffic::hex(6_200 + cycle * 3)));
    }
    synchronous.finds("bus/two-producers", Some(3), 15_080);
}

/// An input that goes on and off lets one device send at alternating intervals.
#[test]
fn an_event_that_alternates_has_one_producer() {
    let mut traffic = machine();
    traffic.silence(0x184, 5_000, 10_000);
    traffic.every(5_000, 10_000, 500, |_| "184#01".to_owned()).every(5_100, 10_000, 500, |_| "184#00".to_owned());
    traffic.only(&[]);
}

#[test]
fn two_series_of_sync_counters() {
    let mut traffic = machine();
    traffic.remove(|ms, frame| ms >= 15_000 && frame.cob_id() == Some(0x183));
    for n in 0..200_u64 {
        traffic.at(15_009 + n * 20, &format!("080#{:02X}", (n + 5) % 10 + 1));
    }
    let found = traffic.results().findings;
    assert!(found.iter().any(|finding| finding.rule.id == "bus/two-producers"), "{found:?}");
}

/// Two devices of the same type give equal answers.
#[test]
fn two_devices_that_answer_alike() {
    let mut traffic = machine();
    for n in 0..4 {
        traffic.sdo(6_100 + n * 100, 3, "4000100000000000", "4300100096010200");
        traffic.micros(6_104_200 + n * 100_000, "583#4300100096010200");
    }
    let found = traffic.only(&["bus/duplicate-node-id", "sdo/protocol-violation"]);
    assert!(found.iter().any(|finding| finding.message.contains("the same answer twice")), "{found:?}");
}

/// Another device replaces the first one, which was switched off.
#[test]
fn a_device_that_was_replaced() {
    let mut traffic = machine();
    traffic.sdo(20_200, 4, "4018100400000000", "4318100401000000");
    traffic.sdo(15_000, 4, "4018100400000000", "4318100402000000").only(&[]);
}

/// Frames of the same length come at the rate of 500 kbit/s with pauses of their own length, so that they seem to
/// follow each other without a pause at 250 kbit/s. Further frames would not fit into this bit rate.
#[test]
fn an_inferred_bit_rate_fits_the_frames() {
    let mut traffic = Traffic::default();
    let bits = u64::from(bit_length(&frame("3A1#0123456789ABCDEF")).unwrap() + INTERMISSION);
    for n in 0..300 {
        traffic.micros(n * bits * 4, "3A1#0123456789ABCDEF");
    }
    assert_eq!(traffic.results().buses[0].1.bit_rate, Some(250_000));
    // Further frames, at times that agree on no bit rate.
    for n in 0..7_000 {
        traffic.micros(500_000 + n * bits * 5 / 2 + n * n % 7, "3A1#0123456789ABCDEF");
    }
    let bus = &traffic.results().buses[0].1;
    assert_eq!((bus.bit_rate, bus.is_inferred), (Some(500_000), true));
    assert!(bus.peak_load().is_some_and(|(_, percent)| percent <= 100.0), "{:?}", bus.peak_load());
    let said = diagnose(&traffic.records(), |diagnosis| diagnosis.set_bit_rate(250_000));
    let load = said.findings.iter().find(|finding| finding.rule.id == "bus/load").expect("the load");
    assert!(load.message.contains("the bit rate must be higher"), "{}", load.message);
}

#[test]
fn nothing_of_canopen() {
    let mut traffic = Traffic::default();
    traffic.every(0, 5_000, 10, |n| format!("18FEF100#{n:016X}")).every(3, 5_000, 50, |n| format!("011#{n:04X}"));
    let found = traffic.only(&["bus/no-canopen", "bus/unknown-ids"]);
    let own = found.iter().find(|finding| finding.rule.id == "bus/no-canopen").unwrap();
    assert!(own.message.contains("500 CAN FD, CAN XL or with 29-bit identifiers, 100 with"), "{}", own.message);
    // A single heartbeat is enough for CANopen.
    traffic.at(6_000, "705#05").only(&["bus/unknown-ids"]);
}

/// One node, and a recorder that was off for three days.
#[test]
fn days_without_a_frame_are_no_missing_heartbeats() {
    const DAYS: u64 = 3 * 86_400_000;
    let mut traffic = Traffic::default();
    traffic.every(0, 20_000, 100, |_| "705#05".to_owned()).every(DAYS, DAYS + 20_000, 100, |_| "705#05".to_owned());
    traffic.only(&["capture/gaps"]);
    // A silence of one second is the node's own.
    let mut second = Traffic::default();
    second.every(0, 20_000, 100, |_| "705#05".to_owned()).every(21_000, 30_000, 100, |_| "705#05".to_owned());
    second.finds_among(&["nodes/lost", "capture/gaps"], "nodes/lost", Some(5), 19_900);
}

/// One answer gives the product code although the vendor-ID was requested.
#[test]
fn an_answer_about_another_sub_index_tells_no_identity() {
    let mut traffic = machine();
    traffic.sdo(600, 4, "4018100100000000", "43181001D1020000").sdo(610, 4, "4018100200000000", "4318100211470000");
    traffic.sdo(6_100, 4, "4018100100000000", "43181002D1020000");
    traffic.finds("sdo/protocol-violation", Some(4), 6_103);
    let results = traffic.results();
    let node = results.buses[0].1.nodes.iter().find(|node| node.0.raw() == 4).unwrap();
    assert_eq!(node.1.identity.numbers[1], Some(0x4711));
}

/// A master requests a detection on 075h. The other masters answer on 074h. The active master reports itself on 071h.
#[test]
fn negotiations_of_flying_masters() {
    let negotiation = |rows: &[&str]| {
        let mut traffic = machine();
        for (at, row) in (5_000..).step_by(50).zip(rows) {
            traffic.at(at, row);
        }
        traffic
    };
    negotiation(&["075#", "074#", "073#", "076#", "072#", "071#007F"]).only(&[]);
    let two = negotiation(&["075#", "074#", "072#", "071#007F", "071#016A"]).finds("bus/flying-master", None, 5_200);
    assert!(two.message.contains("node 127 and node 106"), "{}", two.message);
    negotiation(&["072#", "071#007F", "072#", "071#016A"]).only(&[]);
    assert_eq!(two.severity, Severity::Warning);
    let informs = |rows: &[&str], at: u64| {
        assert_eq!(negotiation(rows).finds("bus/flying-master", None, at).severity, Severity::Info);
    };
    informs(&["071#037F"], 5_000);
    informs(&["076#", "074#"], 5_050);
    informs(&["075#", "073#", "071#007F"], 5_000);
    // A master without another one.
    negotiation(&["075#", "071#007F"]).only(&[]);
}
