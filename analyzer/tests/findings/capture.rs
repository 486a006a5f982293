use crate::traffic::{Traffic, diagnose, machine};
use canvass_analyzer::findings::{Diagnosis, SourceQuality, Thresholds};
use canvass_traces::{ChannelId, Damage, DamageKind, ErrorClass, Frame, Place, Quality, Record, Timestamp};

fn with_error(class: u32, detail: [u8; 8]) -> Vec<Record> {
    let mut records = machine().records();
    let at = records.len() / 2;
    let error = Frame::error(ErrorClass(class), &detail).unwrap();
    records.insert(at, Record::new(records[at].timestamp, ChannelId(0), error).at(77, 0));
    records
}

fn rules(records: &[Record]) -> Vec<&'static str> {
    diagnose(records, |_| {}).findings.iter().map(|finding| finding.rule.id).collect()
}

#[test]
fn error_frames_by_what_they_say() {
    assert_eq!(rules(&with_error(0x088, [0, 0, 4, 8, 0, 0, 0, 0])), ["capture/error-frames"]);
    assert_eq!(rules(&with_error(0x004, [0, 0x08, 0, 0, 0, 0, 100, 0])), ["capture/error-frames"]);
    assert_eq!(rules(&with_error(0x004, [0, 0x20, 0, 0, 0, 0, 130, 0])), ["capture/error-passive"]);
    assert_eq!(rules(&with_error(0x040, [0; 8])), ["capture/bus-off"]);
    assert_eq!(rules(&with_error(0x004, [0, 0x01, 0, 0, 0, 0, 0, 0])), ["capture/overrun"]);
    // A lost arbitration, and a controller that has recovered.
    assert_eq!(rules(&with_error(0x002, [0; 8])), [""; 0]);
    assert_eq!(rules(&with_error(0x004, [0, 0x40, 0, 0, 0, 0, 0, 0])), [""; 0]);
}

fn with_damages(kinds: &[DamageKind]) -> Vec<String> {
    let mut quality = Quality::default();
    for kind in kinds {
        quality.damage(&Damage::new(*kind, Place { number: 3, offset: 0 }, "a frame", b"x"));
    }
    let results =
        Diagnosis::new(Thresholds::default()).finish(&[SourceQuality { name: "a\x1b.log", quality: &quality }]);
    results.findings.iter().map(|finding| format!("{}: {}", finding.rule.id, finding.message)).collect()
}

#[test]
fn damage_is_counted_by_kind() {
    assert_eq!(
        with_damages(&[DamageKind::Malformed, DamageKind::Malformed, DamageKind::Truncated]),
        ["capture/damaged: a\\u{1b}.log: 2 malformed, 1 truncated"]
    );
    assert_eq!(
        with_damages(&[DamageKind::Dropped(12)]),
        ["capture/dropped: a\\u{1b}.log: 12 frames lost by the recorder"]
    );
}

#[test]
fn a_clock_that_steps_back() {
    let mut records = machine().records();
    let at = records.len() / 2;
    for record in &mut records[at..] {
        record.timestamp = Timestamp(record.timestamp.nanos() - 5_000_000_000);
    }
    assert_eq!(rules(&records), ["capture/clock-steps"]);
}

#[test]
fn times_in_hundredths_of_a_second() {
    let mut records = machine().records();
    for record in &mut records {
        record.timestamp = Timestamp(record.timestamp.nanos() / 10_000_000 * 10_000_000);
    }
    assert_eq!(rules(&records), ["capture/coarse-timestamps"]);
}

/// All nodes are silent for ten seconds, so no node is blamed.
#[test]
fn a_pause_of_the_recorder() {
    let paused: Traffic = machine().remove(|ms, _| (12_000..17_000).contains(&ms)).clone();
    paused.only(&["capture/gaps", "pdo/time-jump"]);
    assert_eq!(paused.only(&["capture/gaps"]).len(), 1);
}

/// An interface records twice the frames that it sends: here the frames of the master and of node 3.
#[test]
fn frames_that_are_recorded_twice() {
    let mut records = Vec::new();
    for record in machine().records() {
        let doubled =
            matches!(record.frame.cob_id(), Some(0x000 | 0x080 | 0x100 | 0x701 | 0x183 | 0x583 | 0x603 | 0x703));
        if doubled {
            let mut copy = record.clone();
            copy.timestamp = Timestamp(record.timestamp.nanos() + 20_000);
            records.extend([record, copy]);
        } else {
            records.push(record);
        }
    }
    let results = diagnose(&records, |_| {});
    let found: Vec<_> = results.findings.iter().map(|finding| finding.rule.id).collect();
    assert_eq!(found, ["capture/copies"]);
    let bus = &results.buses[0].1;
    assert_eq!(bus.total(), records.len() as u64);
    assert_eq!(bus.total() - bus.copies, machine().records().len() as u64);
}
