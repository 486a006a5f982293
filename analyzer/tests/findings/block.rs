//! Captures that begin inside an SDO block transfer.

use crate::traffic::Traffic;

/// Segments of a block, 1 ms apart; the last one of the transfer has bit 7 set. The data of the segments look like
/// requests.
fn segments(traffic: &mut Traffic, ms: u64, cob_id: u16, count: u8, last: bool) {
    for n in 1..=count {
        let sequence = n | u8::from(last && n == count) << 7;
        traffic.at(ms + u64::from(n), &format!("{cob_id:03X}#{sequence:02X}{n:02X}200340061700"));
    }
}

/// Heartbeats of node 9, and a read of 1000h before and after the block transfer.
fn around() -> Traffic {
    let mut traffic = Traffic::default();
    traffic.every(40, 5_000, 500, |_| "709#7F".to_owned());
    traffic.sdo(1_000, 9, "4000100000000000", "4300100091010000").sdo(1_500, 9, "4000100000000000", "4300100091010000");
    traffic
}

/// A block download of 100 segments in blocks of 70: the sequence numbers equal many command bytes.
fn download() -> Traffic {
    let mut traffic = around();
    traffic.sdo(100, 9, "C2501F01BC020000", "A0501F0146000000");
    segments(&mut traffic, 110, 0x609, 70, false);
    traffic.at(190, "589#A246460000000000");
    segments(&mut traffic, 200, 0x609, 30, true);
    traffic.at(240, "589#A21E460000000000");
    traffic.sdo(250, 9, "C100000000000000", "A100000000000000");
    traffic
}

fn upload() -> Traffic {
    let mut traffic = around();
    traffic.sdo(100, 9, "A0501F0146000000", "C2501F01BC020000").at(110, "609#A300000000000000");
    segments(&mut traffic, 110, 0x589, 70, false);
    traffic.at(190, "609#A246460000000000");
    segments(&mut traffic, 200, 0x589, 30, true);
    traffic.at(240, "609#A21E460000000000");
    traffic.at(250, "589#C100000000000000").at(253, "609#A100000000000000");
    traffic
}

/// Wherever inside the transfer the capture begins, only a later request without an answer is found.
fn begins_inside(transfer: &Traffic) {
    // The last segment alone (at 230 ms) cannot be distinguished from an abort.
    for begin in (111..230).chain(231..260) {
        let mut traffic = transfer.clone();
        traffic.remove(|ms, _| ms < begin).only(&[]);
        traffic.at(2_000, "609#4000100000000000").finds("sdo/unanswered", Some(9), 2_000);
    }
}

#[test]
fn a_capture_that_begins_inside_a_block_download() {
    begins_inside(&download());
}

#[test]
fn a_capture_that_begins_inside_a_block_upload() {
    begins_inside(&upload());
}
