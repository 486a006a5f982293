use super::*;
use crate::{CanId, ErrorClass, Flags, XlHeader};

const ID: CanId = CanId::standard_masked(0x123);

fn at(nanos: u64) -> Record {
    Record::new(Timestamp(nanos), ChannelId(0), Frame::full(ID, [0; 8]))
}

fn quality(times: impl IntoIterator<Item = u64>) -> Quality {
    let mut quality = Quality::default();
    for (n, time) in times.into_iter().enumerate() {
        quality.record(&at(time).at(n as u64 + 1, 0));
    }
    quality
}

const MILLI: u64 = 1_000_000;
const SECOND: u64 = 1_000 * MILLI;

#[test]
fn every_frame_has_one_kind() {
    let extended = CanId::extended_masked(0x123);
    let mut quality = Quality::default();
    let frames = [
        Frame::full(ID, [0; 8]),
        Frame::full(extended, [0; 8]),
        Frame::remote(extended, 0).unwrap(),
        Frame::error(ErrorClass(0x80), &[]).unwrap(),
        Frame::fd(extended, Flags::BRS, &[]).unwrap(),
    ];
    for (n, frame) in frames.into_iter().enumerate() {
        quality.record(&Record::new(Timestamp(1), ChannelId(2 * (n as u16 & 1)), frame));
    }
    quality.record(&Record::xl(Timestamp(1), ChannelId(2), ID, XlHeader::default(), &[1]).unwrap());
    assert_eq!(quality.frames, FrameCounts { standard: 1, extended: 1, remote: 1, error: 1, fd: 1, xl: 1 });
    assert_eq!(quality.channels, [3, 0, 3]);
    assert_eq!(quality.frames.total(), 6);
}

#[test]
fn the_resolution_is_the_largest_power_of_ten() {
    let seen = |times: &[u64]| quality(times.iter().copied()).resolution.get().map(Duration::nanos);
    assert_eq!(seen(&[]), None);
    assert_eq!(seen(&[7, 7]), None, "a clock that stands still tells nothing");
    assert_eq!(seen(&[0, 10 * MILLI, 130 * MILLI]), Some(10 * MILLI));
    assert_eq!(seen(&[SECOND, 2 * SECOND + 1_000]), Some(1_000));
    assert_eq!(seen(&[0, u64::MAX]), Some(1));
    assert_eq!(seen(&[0, 1_000_000 * SECOND]), Some(SECOND), "coarser than a second is not told");
    assert!(quality([0, MILLI]).resolution.is_coarse());
    assert!(!quality([0, MILLI / 10]).resolution.is_coarse());
}

#[test]
fn the_clock_steps_back() {
    let quality = quality([5 * SECOND, 6 * SECOND, 4 * SECOND, 5 * SECOND, 5 * SECOND - 1]);
    assert_eq!((quality.steps.count, quality.steps.largest), (2, Duration(2 * SECOND)));
    let first = Sighting { time: Timestamp(4 * SECOND), place: Place { number: 3, offset: 0 } };
    assert_eq!(quality.steps.first, Some(first));
    assert_eq!(quality.duration(), Duration::ZERO);
}

#[test]
fn ten_seconds_are_a_gap_at_the_begin() {
    assert_eq!(quality([0, 10 * SECOND]).gaps.count, 0);
    let quality = quality([0, 10 * SECOND + 1, 11 * SECOND]);
    assert_eq!(quality.gaps.count, 1);
    let gap = quality.gaps.largest.unwrap();
    assert_eq!((gap.length.nanos(), gap.end.place.number), (10 * SECOND + 1, 2));
}

#[test]
fn pauses_between_bursts_are_no_gaps() {
    // A SYNC every 100 ms, with 40 answers that follow each other in 130 µs.
    let burst = |n: u64| (0..41).map(move |frame| n * 100 * MILLI + frame * 130_000);
    let regular = quality((0..1_000).flat_map(burst));
    assert_eq!(regular.gaps.count, 0);
    let lost = quality((0..1_000).filter(|n| !(500..520).contains(n)).flat_map(burst));
    assert_eq!(lost.gaps.count, 1, "two seconds are missing");
}

#[test]
fn short_losses_of_a_fast_bus_are_gaps() {
    let lost = quality((0..10_000).filter(|n| !(5_000..5_150).contains(n)).map(|n| n * MILLI));
    assert_eq!(lost.gaps.count, 1);
    assert_eq!(lost.gaps.largest.unwrap().usual, Gaps::LEAST);
}

#[test]
fn a_slow_rhythm_becomes_usual() {
    let heartbeats_only = quality((0..1_000).map(|n| n * 60 * SECOND));
    assert!((1..20).contains(&heartbeats_only.gaps.count), "{}", heartbeats_only.gaps.count);
    assert_eq!(quality((0..1_000).map(|n| n * SECOND)).gaps.count, 0);
}

#[test]
fn sources_are_added_up() {
    let mut total = quality([5 * SECOND, 4 * SECOND]);
    let mut other = quality([SECOND, 30 * SECOND]);
    other.damage(&Damage::new(DamageKind::Dropped(u64::MAX), Place::default(), "", b""));
    other.damage(&Damage::new(DamageKind::Dropped(5), Place::default(), "", b""));
    other.damage(&Damage::new(DamageKind::Malformed, Place::default(), "", b""));
    total.add(&other);
    assert_eq!((total.first, total.last), (Some(Timestamp(SECOND)), Some(Timestamp(30 * SECOND))));
    assert_eq!((total.frames.total(), total.gaps.count, total.steps.count), (4, 1, 1));
    assert_eq!(total.damages, DamageCounts { dropped: u64::MAX, malformed: 1, ..DamageCounts::default() });
}

#[test]
fn any_times_are_taken() {
    proptest::proptest!(|(times in proptest::collection::vec(proptest::num::u64::ANY, 0..200))| {
        let quality = quality(times.iter().copied());
        let back = times.windows(2).filter(|pair| pair[1] < pair[0]).count() as u64;
        proptest::prop_assert_eq!(quality.steps.count, back);
        if let Some(unit) = quality.resolution.get() {
            proptest::prop_assert!(times.iter().all(|time| time.is_multiple_of(unit.nanos())));
        }
    });
}

#[test]
fn frames_with_the_same_time_are_counted_by_channel() {
    assert_eq!(quality([1, 1, 1, 2, 3, 3]).simultaneous, 3);
    let mut two_buses = Quality::default();
    let mut other = at(5);
    other.channel = ChannelId(1);
    two_buses.record(&at(5));
    two_buses.record(&other);
    assert_eq!(two_buses.simultaneous, 0);
}
