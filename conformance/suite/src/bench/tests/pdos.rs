//! PDO parameters and mappings: changed in the order of CiA 301 (7.5.2.37, 7.5.2.38), and put back.

#![cfg(test)]

use super::super::objects::{TPDO_COB_ID, TPDO_MAPPED};
use super::super::pdo::{Mapped, RPDO, TPDO};
use super::{Bench, on_device};
use crate::scripted::{dictionary, with_bench};
use crate::verdict::Stop;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::Subject;
use canvass_traces::{Direction, Duration};

/// The objects that were written since, in their order, with their values.
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

/// 0 need not be written to a timer that the device does not have; the transmission type has no such value, and every PDO has
/// it.
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

/// A COB-ID without CAN-ID is that of the predefined connection set.
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

/// Off, count 0, the entries, count, on.
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

/// Of other objects nothing is mapped, and bits are whole bytes.
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

/// SYNC is where 1005h says, and its counter and its producer are switched off for a case.
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

/// A device delivered with its TPDO switched off, or empty, gets one.
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
