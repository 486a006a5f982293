//! Unusual behaviour of a healthy bus, which is no fault.

use crate::traffic::{END, Traffic, diagnose, machine};
use canvass_traces::{ChannelId, Timestamp};

/// Two machines of the same kind are recorded together.
#[test]
fn two_buses() {
    let first = machine().records();
    let mut second = machine().records();
    for record in &mut second {
        record.channel = ChannelId(1);
        record.timestamp = Timestamp(record.timestamp.nanos() + 31_415_927);
    }
    let mut records = [first, second].concat();
    records.sort_by_key(|record| record.timestamp);
    let findings = diagnose(&records, |_| {}).findings;
    assert!(findings.is_empty(), "{findings:#?}");
}

/// Another protocol on the same wires: CAN FD, and 29-bit identifiers whose low bits look like CAN-IDs of CANopen.
#[test]
fn other_protocols_in_between() {
    let mut traffic = machine();
    traffic.every(2_002, END, 40, |n| format!("183##1{:02X}00000000000000", n & 0xFF));
    traffic.every(2_004, END, 40, |n| format!("00000703#{:02X}", n & 0x7F));
    traffic.every(2_006, END, 40, |_| "18FF0080#0102".to_owned());
    traffic.only(&[]);
}

/// A firmware update: program control, silence, the program, and a boot-up.
#[test]
fn a_bootloader() {
    let mut traffic = machine();
    traffic.silence(0x704, 12_050, 20_000).silence(0x184, 12_000, 20_000);
    traffic.sdo(12_000, 4, "2F511F0100000000", "60511F0100000000").at(13_000, "704#00");
    traffic.sdo(13_200, 4, "21501F010E000000", "60501F0100000000");
    traffic.sdo(13_300, 4, "0011223344556677", "2000000000000000");
    traffic.sdo(13_400, 4, "1111223344556677", "3000000000000000");
    traffic.sdo(16_000, 4, "2F511F0101000000", "60511F0100000000").at(17_500, "704#00");
    traffic.every(17_700, 20_000, 200, |_| "704#7F".to_owned());
    traffic.sdo(18_000, 4, "4018100300000000", "4318100302000100").only(&[]);
}

/// A master that looks for new nodes once in a second.
#[test]
fn an_lss_master_that_searches() {
    let mut traffic = machine();
    traffic.every(2_015, END, 1_000, |_| "7E5#4C00000000000000".to_owned());
    traffic.every(2_016, END, 1_000, |_| "7E5#0400000000000000".to_owned());
    traffic.every(2_017, END, 1_000, |_| "7E5#5100000000800000".to_owned());
    traffic.only(&[]);
    // The search hides no other finding.
    traffic.silence(0x703, 15_000, 15_250).finds("nodes/heartbeat-missing", Some(3), 14_960);
}

/// Heartbeat and PDO parameters are changed in operation.
#[test]
fn a_reconfiguration() {
    let mut traffic = machine();
    traffic.sdo(12_101, 3, "2B1710002C010000", "6017100000000000").silence(0x703, 12_104, END);
    traffic.every(12_404, END, 300, |_| "703#05".to_owned());
    traffic.sdo(14_111, 3, "2B011805C8000000", "6001180500000000").silence(0x283, 14_114, END);
    traffic.every(14_314, END, 200, |_| "283#0000".to_owned());
    traffic.sdo(16_121, 3, "2B17100000000000", "6017100000000000").silence(0x703, 16_124, END);
    traffic.only(&[]);
}

/// A second client has an SDO channel of its own, and sends requests while the first client does.
#[test]
fn two_sdo_clients() {
    let mut traffic = machine();
    traffic.sdo(600, 3, "2301120141020000", "6001120100000000").sdo(610, 3, "23011202C1010000", "6001120200000000");
    for n in 0..40 {
        traffic.at(2_002 + n * 500, "241#4000100000000000").at(2_004 + n * 500, "1C1#4300100096010200");
    }
    traffic.only(&[]);
}

/// Some recorders omit remote frames, so that guarding shows only its answers.
#[test]
fn a_recorder_without_remote_frames() {
    machine().remove(|_, frame| frame.is_remote()).only(&[]);
}

/// A node that enters operational by itself, and one whose boot-up is an EMCY without data, as before CiA 301 V4.
#[test]
fn old_and_self_starting_nodes() {
    let mut traffic = machine();
    traffic.at(2_000, "705#00").every(2_100, END, 100, |_| "705#05".to_owned());
    traffic.every(2_050, END, 200, |n| format!("185#{:02X}", n & 0xFF));
    traffic.at(2_500, "087#").at(2_600, "000#0107").every(2_700, END, 100, |n| format!("187#{:02X}", n & 0xFF));
    traffic.only(&[]);
}

/// Times in whole milliseconds, as many tools write them.
#[test]
fn times_in_milliseconds() {
    let mut records = machine().records();
    for record in &mut records {
        record.timestamp = Timestamp(record.timestamp.nanos() / 1_000_000 * 1_000_000);
    }
    let findings = diagnose(&records, |_| {}).findings;
    assert!(findings.iter().all(|finding| finding.rule.id == "capture/coarse-timestamps"), "{findings:#?}");
}

/// A recorder of a busy computer: each time is up to 2 ms late, in the order of the frames.
#[test]
fn times_of_a_busy_computer() {
    let mut records = machine().records();
    let mut last = 0;
    for (n, record) in (0_u64..).zip(&mut records) {
        last = (record.timestamp.nanos() + n * 7_919 % 2_003 * 1_000).max(last + 1_000);
        record.timestamp = Timestamp(last);
    }
    let findings = diagnose(&records, |_| {}).findings;
    assert!(findings.is_empty(), "{findings:#?}");
}

/// Only a configuration tool sends: the capture has no frame of the nodes.
#[test]
fn only_a_master() {
    let mut traffic = Traffic::default();
    traffic.every(0, 10_000, 100, |_| "080#".to_owned()).at(500, "000#0100").at(5_000, "000#8200");
    traffic.only(&[]);
}
