//! PDO parameters and mappings: changed in the order of CiA 301 (7.5.2.37, 7.5.2.38), and put back.

#![cfg(test)]

use super::super::Options;
use super::super::objects::{TPDO_COB_ID, TPDO_MAPPED};
use super::super::pdo::{Mapped, RPDO, TPDO};
use super::{Bench, on_device};
use crate::scripted::{Row, described, dictionary, frame, with_bench, with_target};
use crate::verdict::Stop;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::Subject;
use canvass_traces::{Direction, Duration, Frame};

/// The objects written after the first `since` frames, in order, with their values.
fn written(bench: &Bench<'_>, since: usize) -> Vec<String> {
    let sent = bench.evidence().frames().skip(since).filter(|exhibit| exhibit.record.direction == Direction::Tx);
    let downloads = sent.filter_map(|exhibit| {
        let [command, low, high, sub, value @ ..] = exhibit.record.frame.bytes();
        let bytes = 4 - usize::from(command >> 2 & 3);
        let value: String = value.iter().take(bytes).map(|byte| format!("{byte:02X}")).collect();
        (command & 0xE3 == 0x23).then(|| format!("{high:02X}{low:02X}:{sub:02X} {value}"))
    });
    downloads.collect()
}

fn seen(bench: &Bench<'_>) -> usize {
    bench.evidence().frames().count()
}

fn own_id(bench: &Bench<'_>) -> u32 {
    0x180 + u32::from(bench.node().raw())
}

#[test]
fn a_pdo_has_its_numbers() {
    let (third, second) = (TPDO.numbered(3), RPDO.numbered(2));
    assert_eq!((third.parameter(1), third.entry(0)), (Multiplexer::new(0x1802, 1), Multiplexer::new(0x1A02, 0)));
    assert_eq!((second.parameter(2), second.entry(4)), (Multiplexer::new(0x1401, 2), Multiplexer::new(0x1601, 4)));
    assert_eq!(third.subject(), Subject::Pdo { transmit: true, number: 3 });
    assert_eq!((RPDO.subject(), TPDO.numbered(1)), (Subject::Pdo { transmit: false, number: 1 }, TPDO));
    assert_eq!(Mapped { at: Multiplexer::new(0x6004, 2), bits: 32 }.entry(), 0x6004_0220);
}

#[test]
fn a_parameter_is_set_while_the_pdo_is_off() {
    on_device(|bench| {
        bench.prepare().unwrap();
        let before = bench.pdo_cob_id(TPDO).unwrap();
        assert_eq!((before.can_id(), before.is_valid()), (own_id(bench), true));
        let since = seen(bench);
        bench.set_pdo(TPDO, &[(2, &[1]), (3, &[0x0A, 0])]).unwrap();
        let [off, on] = [before.0 | 1 << 31, before.0].map(|id| format!("1800:01 {:08X}", id.swap_bytes()));
        assert_eq!(written(bench, since), [off, "1800:02 01".to_owned(), "1800:03 0A00".to_owned(), on]);
        assert_eq!(bench.pdo_inhibit_time(TPDO), Ok(Duration::from_millis(1)));
        assert_eq!(bench.pdo_off(TPDO), Ok(before));
        assert!(!bench.pdo_cob_id(TPDO).unwrap().is_valid());
        bench.pdo_on(TPDO, CobId(before.0 | 1 << 31)).unwrap();
        assert_eq!(bench.pdo_cob_id(TPDO), Ok(before));
        bench.set_event_timer(TPDO, 250).unwrap();
        assert_eq!(bench.read_number(TPDO.parameter(5)), Ok(250));
        let remains = bench.finish();
        assert_eq!((remains.notes, bench.read_number(TPDO.parameter(5))), (Vec::new(), Ok(0)));
        assert_eq!((bench.pdo_cob_id(TPDO), bench.pdo_inhibit_time(TPDO)), (Ok(before), Ok(Duration::ZERO)));
    });
}

/// A timer that the device does not have need not be set to 0; the transmission type has no such value, and every PDO
/// has it.
#[test]
fn a_timer_that_is_not_there_is_off() {
    let row = |sub, value: &[u8]| ((0x1800, sub), value.to_vec(), true);
    let without = vec![row(1, &[0xBF, 1, 0, 0x40]), row(2, &[255])];
    with_bench(dictionary(without), |bench| {
        assert_eq!(bench.set_pdo(TPDO, &[(2, &[0]), (3, &[0, 0]), (5, &[0, 0])]), Ok(()));
        assert_eq!(bench.read_number(TPDO.parameter(2)), Ok(0));
        for timer in [[1, 0], [0, 1]] {
            assert!(matches!(bench.set_pdo(TPDO, &[(3, &timer)]), Err(Stop::Inconclusive(_))), "{timer:?}");
        }
        assert!(bench.set_pdo(TPDO.numbered(2), &[(2, &[0])]).is_err(), "there is no such PDO");
    });
    let only_its_id = vec![row(1, &[0xBF, 1, 0, 0x40])];
    with_bench(dictionary(only_its_id), |bench| {
        assert!(bench.set_pdo(TPDO, &[(2, &[0])]).is_err(), "a transmission type of 0 is no timer that is off");
    });
    let with = vec![row(1, &[0xBF, 1, 0, 0x40]), row(3, &[5, 0])];
    with_bench(dictionary(with), |bench| {
        assert_eq!(bench.set_pdo(TPDO, &[(3, &[0, 0])]), Ok(()));
        assert_eq!(bench.read_number(TPDO.parameter(3)), Ok(0), "one that is there is switched off");
    });
}

/// A COB-ID without CAN-ID gets the CAN-ID of the predefined connection set.
#[test]
fn a_cob_id_is_made_valid() {
    on_device(|bench| {
        let node = u32::from(bench.node().raw());
        assert_eq!(bench.valid_cob_id(TPDO, CobId(0xC000_0000)), CobId(0x4000_0180 + node));
        assert_eq!(bench.valid_cob_id(RPDO, CobId(0x8000_0000)), CobId(0x200 + node));
        assert_eq!(bench.valid_cob_id(TPDO, CobId(0xC000_0123)), CobId(0x4000_0123));
        assert_eq!(bench.valid_cob_id(TPDO.numbered(2), CobId(0x8000_0000)), CobId(0));
    });
}

/// The order of a mapping change: PDO off, count 0, the entries, the count, PDO on.
#[test]
fn a_mapping_is_changed_step_by_step() {
    on_device(|bench| {
        bench.prepare().unwrap();
        let before = bench.mapping(TPDO).unwrap();
        let objects = bench.tpdo_objects();
        assert!(!before.is_empty() && objects.len() > 1, "{objects:?}");
        let other: Vec<Mapped> = objects.iter().filter(|mapped| mapped.bits <= 32).take(2).copied().collect();
        let order = |bench: &Bench<'_>, since| -> Vec<String> {
            let short = |line: String| line.split(' ').next().unwrap_or_default().to_owned();
            written(bench, since).into_iter().map(short).collect()
        };
        let expected = ["1800:01", "1A00:00", "1A00:01", "1A00:02", "1A00:00", "1800:01"];
        let since = seen(bench);
        bench.set_mapping(TPDO, &other).unwrap();
        assert_eq!(
            (order(bench, since), bench.mapping(TPDO)),
            (expected.map(str::to_owned).to_vec(), Ok(other.clone()))
        );
        let cob_id = bench.pdo_cob_id(TPDO).unwrap();
        let since = seen(bench);
        bench.remap(TPDO, &other, cob_id).unwrap();
        assert_eq!((order(bench, since), bench.mapping(TPDO)), (expected.map(str::to_owned).to_vec(), Ok(other)));
        assert_eq!(bench.require_mapped(TPDO), Ok(()));
        assert_eq!(bench.open_mapping(TPDO), Ok(cob_id));
        assert!(matches!(bench.require_mapped(TPDO), Err(Stop::NotApplicable(_))));
        assert_eq!((bench.read_number(TPDO_MAPPED), bench.pdo_cob_id(TPDO).unwrap().is_valid()), (Ok(0), false));
        bench.finish();
        assert_eq!((bench.mapping(TPDO), bench.read_number(TPDO_COB_ID)), (Ok(before), Ok(cob_id.0)));
        assert!(bench.require_one(TPDO, &[]).is_err());
    });
}

/// Only objects of the application are mapped, and only if they have one to eight whole bytes.
#[test]
fn mappable_objects_are_those_of_the_description() {
    on_device(|bench| {
        for mapped in bench.tpdo_objects().into_iter().chain(bench.rpdo_objects()) {
            assert!(
                mapped.at.index.0 >= 0x2000 && mapped.bits % 8 == 0 && (8..=64).contains(&mapped.bits),
                "{mapped:?}"
            );
        }
        assert!(!bench.rpdo_objects().is_empty());
        let (mapped, other) = bench.changeable().unwrap();
        let now = bench.read(mapped.at).unwrap();
        assert_ne!(now, other);
        assert_eq!((now.len(), other.len()), (usize::from(mapped.bits / 8), usize::from(mapped.bits / 8)));
        bench.write(mapped.at, &other).unwrap();
    });
}

/// SYNC has the CAN-ID in 1005h; its counter and its producer are switched off for a case.
#[test]
fn sync_is_made_plain() {
    on_device(|bench| {
        bench.prepare().unwrap();
        assert_eq!(bench.sync_id(), Ok(0x80));
        let (period, overflow) = (Multiplexer::new(0x1006, 0), Multiplexer::new(0x1019, 0));
        bench.write(overflow, &[10]).unwrap();
        bench.write(period, &100_000_u32.to_le_bytes()).unwrap();
        bench.expect_plain_sync().unwrap();
        assert_eq!((bench.read_number(period), bench.read_number(overflow)), (Ok(0), Ok(0)));
        let since = seen(bench);
        bench.expect_plain_sync().unwrap();
        bench.stop_sync_period().unwrap();
        assert_eq!(written(bench, since), Vec::<String>::new(), "nothing is to be done");
    });
}

/// If TPDO 1 is off, the bench switches it on for the case. If its mapping is empty, the bench maps an object to it.
#[test]
fn a_tpdo_is_provided() {
    on_device(|bench| {
        bench.prepare().unwrap();
        let since = seen(bench);
        assert_eq!(bench.provide_tpdo(), Ok(Ok(())));
        assert_eq!(written(bench, since), Vec::<String>::new(), "it is there");
        let cob_id = bench.pdo_off(TPDO).unwrap();
        assert_eq!(bench.provide_tpdo(), Ok(Ok(())));
        assert_eq!(bench.pdo_cob_id(TPDO), Ok(cob_id));
        bench.open_mapping(TPDO).unwrap();
        assert_eq!(bench.provide_tpdo(), Ok(Ok(())));
        assert_eq!((bench.pdo_cob_id(TPDO), bench.read_number(TPDO_MAPPED)), (Ok(cob_id), Ok(1)));
    });
}

/// A device with this dictionary, which refuses some requests with 0800 0022h while TPDO 1 is valid, and others always.
fn refusing(
    rows: Vec<Row>,
    while_valid: &'static [&'static str],
    always: &'static [&'static str],
) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
    let (mut others, mut valid) = (dictionary(rows), true);
    move |request| {
        let text = request.to_string();
        let begins = |begins: &[&str]| begins.iter().any(|begin| text.starts_with(begin));
        if begins(always) || valid && begins(while_valid) {
            return vec![(Duration::from_millis(1), frame(&format!("5BF#80{}22000008", &text[6..12])))];
        }
        if text.starts_with("63F#23001801") {
            valid = request.bytes()[7] & 0x80 == 0;
        }
        others(request)
    }
}

fn tpdo(sub: u8, value: &[u8]) -> Row {
    ((0x1800, sub), value.to_vec(), true)
}

/// A device that refuses changes to a PDO in use gets its event timer while the PDO is off. A device that is silent, or
/// refuses even then, has no event timer.
#[test]
fn an_event_timer_is_set_however_the_device_takes_it() {
    const TIMER: &[&str] = &["63F#2B001805"];
    let rows = || vec![tpdo(1, &[0xBF, 1, 0, 0x40]), tpdo(5, &[0, 0])];
    let set = |while_valid, always| {
        with_bench(refusing(rows(), while_valid, always), |bench| {
            let set = bench.set_event_timer(TPDO, 250);
            let since = written(bench, 0);
            let now = bench.uncancelled(|bench| bench.read_number(TPDO.parameter(5)));
            (set.is_ok(), since, now, bench.pdo_cob_id(TPDO).unwrap().is_valid())
        })
    };
    let timer = "1800:05 FA00".to_owned();
    assert_eq!(set(&[], &[]), (true, vec![timer.clone()], Ok(250), true));
    let off_and_on = vec![timer.clone(), "1800:01 BF0100C0".to_owned(), timer, "1800:01 BF010040".to_owned()];
    assert_eq!(set(TIMER, &[]), (true, off_and_on, Ok(250), true));
    let (refused, _, now, _) = set(&[], TIMER);
    assert_eq!((refused, now), (false, Ok(0)));
    let silent = with_bench(
        |request: &Frame| match request.to_string().starts_with("63F#2B") {
            true => Vec::new(),
            false => dictionary(vec![tpdo(5, &[0, 0])])(request),
        },
        |bench| (bench.set_event_timer(TPDO, 250), written(bench, 0).len()),
    );
    assert!(matches!(silent, (Err(Stop::Inconclusive(_)), 1)), "{silent:?}");
}

/// The inhibit time is in units of 100 µs; a PDO need not have one.
#[test]
fn an_inhibit_time_may_be_missing() {
    let time = |rows| with_bench(dictionary(rows), |bench| bench.pdo_inhibit_time(TPDO)).unwrap();
    assert_eq!(time(vec![tpdo(3, &[0x2C, 1])]), Duration::from_millis(30));
    assert_eq!((time(vec![tpdo(1, &[0; 4])]), time(Vec::new())), (Duration::ZERO, Duration::ZERO));
}

/// A mapping with an impossible count is read only up to the limit of a PDO: 64 entries.
#[test]
fn a_mapping_has_no_more_than_64_entries() {
    let mapped = |count: u8, entries: u8| {
        let mut rows = vec![((0x1A00, 0), vec![count], true)];
        rows.extend((1..=entries).map(|sub| ((0x1A00, sub), vec![1, sub, 0, 0x20], true)));
        with_bench(dictionary(rows), |bench| bench.mapping(TPDO).map(|mapping| mapping.len()))
    };
    assert_eq!((mapped(0, 70), mapped(1, 70), mapped(64, 70), mapped(65, 70)), (Ok(0), Ok(1), Ok(64), Ok(64)));
    assert!(mapped(3, 2).is_err());
    let entries = with_bench(
        dictionary(vec![((0x1A00, 0), vec![1], true), ((0x1A00, 1), vec![0x10, 2, 4, 0x60], true)]),
        |bench| bench.mapping(TPDO),
    );
    assert_eq!(entries, Ok(vec![Mapped { at: Multiplexer::new(0x6004, 2), bits: 16 }]));
}

/// The first refused step of the five is a breach, and the following steps are not tried.
#[test]
fn a_step_that_is_refused_ends_the_mapping() {
    const MAPPED: [Mapped; 1] = [Mapped { at: Multiplexer::new(0x2000, 0), bits: 8 }];
    let rows = || {
        let entry = |sub, value: &[u8]| ((0x1A00, sub), value.to_vec(), true);
        vec![tpdo(1, &[0xBF, 1, 0, 0]), entry(0, &[0]), entry(1, &[0; 4])]
    };
    let remapped = |always: &'static [&'static str]| {
        with_bench(refusing(rows(), &[], always), |bench| {
            let outcome = bench.remap(TPDO, &MAPPED, CobId(0x1BF));
            let count = written(bench, 0).len();
            (outcome.is_ok(), matches!(outcome, Err(Stop::Breach(_))), count)
        })
    };
    assert_eq!(remapped(&[]), (true, false, 5));
    assert_eq!(remapped(&["63F#23001801"]), (false, true, 1));
    assert_eq!(remapped(&["63F#2F001A0000"]), (false, true, 2));
    assert_eq!(remapped(&["63F#23001A01"]), (false, true, 3));
    assert_eq!(remapped(&["63F#2F001A0001"]), (false, true, 4));
}

/// If the best objects are refused, the next are tried: four of them, and the error register.
#[test]
fn what_a_tpdo_does_not_take_is_followed_by_the_next() {
    let sections: Vec<(String, &str)> =
        (0..6).map(|n| (format!("200{n}"), "DataType=0x0005\nPDOMapping=1\nAccessType=ro")).collect();
    let mut sections: Vec<(&str, &str)> = sections.iter().map(|(name, lines)| (name.as_str(), *lines)).collect();
    sections.extend([
        ("1800sub1", "DataType=0x0007"),
        ("1A00sub0", "DataType=0x0005"),
        ("1A00sub1", "DataType=0x0007"),
        ("1001", "DataType=0x0005\nAccessType=ro\nPDOMapping=1"),
    ]);
    let target = described(&sections);
    const BUT_THE_LAST: &[&str] =
        &["63F#23001A0108000020", "63F#23001A0108000120", "63F#23001A0108000220", "63F#23001A0108000320"];
    let entry = |sub, value: &[u8]| ((0x1A00, sub), value.to_vec(), true);
    // The entries that were tried, and whether the device accepted one.
    let tried = |always: &'static [&'static str]| {
        let rows = vec![tpdo(1, &[0xBF, 1, 0, 0xC0]), entry(0, &[0]), entry(1, &[0; 4])];
        with_target(refusing(rows, &[], always), &target, &Options::default(), |bench| {
            let met = bench.provide_tpdo().unwrap();
            let entries =
                written(bench, 0).into_iter().filter_map(|line| Some(line.strip_prefix("1A00:01 ")?.to_owned()));
            (met.is_ok(), entries.collect::<Vec<String>>())
        })
    };
    let entries = |last: &[&str]| last.iter().map(|entry| (*entry).to_owned()).collect::<Vec<String>>();
    let all = ["08000020", "08000120", "08000220", "08000320", "08000110"];
    assert_eq!(tried(&[]), (true, entries(&all[..1])));
    assert_eq!(tried(&["63F#23001A0108000020"]), (true, entries(&all[..2])));
    // An object whose count is refused is no better than one whose entry is refused.
    assert_eq!(tried(&["63F#2F001A0001"]), (false, entries(&all)));
    assert_eq!(tried(&["63F#23001A01"]), (false, entries(&all)));
    assert_eq!(tried(BUT_THE_LAST), (true, entries(&all)));
}

/// SYNC has no counter if 1019h is 0 or absent; a SYNC consumer need not have a period.
#[test]
fn a_plain_sync_is_expected_where_it_is_not() {
    let sent = |rows: Vec<Row>| with_bench(dictionary(rows), |bench| (bench.expect_plain_sync(), written(bench, 0)));
    let overflow = |value| ((0x1019, 0), vec![value], true);
    let period = |value| ((0x1006, 0), vec![value, 0, 0, 0], true);
    assert_eq!(sent(Vec::new()), (Ok(()), Vec::new()));
    assert_eq!(sent(vec![overflow(0), period(1)]), (Ok(()), Vec::new()), "its period disturbs nobody");
    assert_eq!(sent(vec![overflow(10)]), (Ok(()), vec!["1019:00 00".to_owned()]));
    assert_eq!(sent(vec![overflow(10), period(0)]), (Ok(()), vec!["1019:00 00".to_owned()]));
    let both = vec!["1006:00 00000000".to_owned(), "1019:00 00".to_owned()];
    assert_eq!(sent(vec![overflow(10), period(1)]), (Ok(()), both));
}
