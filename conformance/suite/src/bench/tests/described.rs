//! The description decides which objects serve a case, and with which values.

#![cfg(test)]

use super::super::objects::Scratch;
use super::super::pdo::{Mapped, RPDO, TPDO};
use super::super::{Bench, Options, Target};
use crate::scripted::{Row, described, dictionary, table, with_bench, with_target};
use crate::verdict::Stop;
use canvass_analyzer::{CobId, Multiplexer};

fn row(index: u16, sub: u8, value: &[u8]) -> Row {
    ((index, sub), value.to_vec(), true)
}

fn at(index: u16) -> Multiplexer {
    Multiplexer::new(index, 0)
}

/// Runs `test` on a device with this description and these values.
fn on<T>(target: &Target, rows: Vec<Row>, test: impl FnOnce(&mut Bench<'_>) -> T) -> T {
    with_target(dictionary(rows), target, &Options::default(), test)
}

/// The other value is the nearest one within the limits, if there is one.
#[test]
fn another_value_is_within_its_limits() {
    let target = described(&[
        ("2000", "DataType=0x0005"),
        ("2001", "DataType=0x0005\nLowLimit=10\nHighLimit=20"),
        ("2002", "DataType=0x0005\nHighLimit=10"),
        ("2003", "DataType=0x0005\nLowLimit=11"),
        ("2004", "DataType=0x0003\nLowLimit=-10\nHighLimit=-5"),
        ("2005", "DataType=0x0005\nLowLimit=7\nHighLimit=7"),
        ("2006", "DataType=0x0005\nLowLimit=$NODEID"),
        ("2007", "DataType=0x0007\nHighLimit=0x10000"),
    ]);
    on(&target, Vec::new(), |bench| {
        let other = |index, now: &[u8]| bench.other_value(at(index), now);
        assert_eq!((other(0x2000, &[4]), other(0x2000, &[5])), (vec![5], vec![4]));
        assert_eq!((other(0x2FFF, &[4, 1]), other(0x2FFF, &[])), (vec![5, 1], vec![]), "nothing is known of it");
        assert_eq!((other(0x2001, &[10]), other(0x2001, &[15]), other(0x2001, &[20])), (vec![11], vec![14], vec![19]));
        // A value outside its limits has no neighbour within them.
        assert_eq!((other(0x2001, &[40]), other(0x2001, &[2])), (vec![10], vec![10]));
        assert_eq!((other(0x2002, &[40]), other(0x2003, &[2])), (vec![10], vec![11]));
        assert_eq!((other(0x2002, &[10]), other(0x2003, &[11])), (vec![9], vec![12]));
        assert_eq!(other(0x2004, &(-10_i16).to_le_bytes()), (-9_i16).to_le_bytes());
        assert_eq!(other(0x2004, &(-5_i16).to_le_bytes()), (-6_i16).to_le_bytes());
        assert_eq!(other(0x2005, &[7]), [6], "there is no other");
        assert_eq!((other(0x2006, &[63]), other(0x2006, &[64])), (vec![64], vec![65]));
        assert_eq!(other(0x2007, &0x1_0000_u32.to_le_bytes()), 0xFFFF_u32.to_le_bytes());
        let within = |index, number| bench.is_within_limits(at(index), number);
        assert_eq!([9, 10, 20, 21].map(|number| within(0x2001, number)), [false, true, true, false]);
        assert_eq!([10, 11].map(|number| within(0x2002, number)), [true, false]);
        assert_eq!([10, 11].map(|number| within(0x2003, number)), [false, true]);
        assert_eq!([62, 63].map(|number| within(0x2006, number)), [false, true]);
        assert!(within(0x2000, 300) && within(0x2FFF, -1));
    });
    with_bench(dictionary(Vec::new()), |bench| {
        assert_eq!((bench.other_value(at(0x2000), &[8, 8]), bench.is_within_limits(at(0x2000), 1)), (vec![9, 8], true));
    });
}

/// A scratch object: its multiplexer, its value, and the other value.
fn scratch(index: u16, sub: u8, value: &[u8], other: &[u8]) -> Scratch {
    Scratch { multiplexer: Multiplexer::new(index, sub), value: value.to_vec(), other: other.to_vec() }
}

/// Objects that can be written without side effects serve, best first, each with another value that is legal on any
/// device with the object.
#[test]
fn scratch_objects_are_those_that_do_nothing() {
    let rows = vec![
        row(0x6200, 0, &[5, 0]),
        row(0x6401, 0, &[16, 0, 0, 0]),
        row(0x1007, 0, &[0; 4]),
        row(0x1006, 0, &[0; 4]),
        row(0x1029, 1, &[1]),
        row(0x1800, 5, &[100, 0]),
        row(0x1015, 0, &[0, 0]),
        row(0x100C, 0, &[0xE8, 3]),
        row(0x1017, 0, &[0xE8, 3]),
        row(0x1800, 2, &[1]),
    ];
    let found = with_bench(dictionary(rows.clone()), |bench| bench.scratch_objects().unwrap());
    let expected = [
        scratch(0x1017, 0, &[0xE8, 3], &[0xD0, 7]),
        scratch(0x100C, 0, &[0xE8, 3], &[0xD0, 7]),
        scratch(0x1015, 0, &[0, 0], &[100, 0]),
        scratch(0x1800, 5, &[100, 0], &[200, 0]),
        scratch(0x1029, 1, &[1], &[0]),
        scratch(0x1006, 0, &[0; 4], &100_000_u32.to_le_bytes()),
        scratch(0x1007, 0, &[0; 4], &100_000_u32.to_le_bytes()),
        scratch(0x6401, 0, &[16, 0, 0, 0], &[32, 0, 0, 0]),
        scratch(0x6200, 0, &[5, 0], &[100, 0]),
    ];
    assert_eq!(found, expected);
    // An object with another length than the standard's does not serve; the transmission type serves if there is
    // nothing else.
    let odd = vec![row(0x1017, 0, &[0; 4]), row(0x1800, 2, &[1])];
    let found = with_bench(dictionary(odd), |bench| bench.scratch_objects().unwrap());
    assert_eq!(found, [scratch(0x1800, 2, &[1], &[2])]);
    with_bench(dictionary(rows), |bench| {
        assert_eq!(bench.scratch(&[4, 1]).map(|found| found.multiplexer), Ok(Multiplexer::new(0x1029, 1)));
        let Err(Stop::NotApplicable(reason)) = bench.scratch(&[3, 5]) else { panic!("there is none") };
        assert_eq!(reason.duty, "an object of 3 or 5 bytes can be written without consequence");
    });
    assert_eq!(with_bench(dictionary(Vec::new()), |bench| bench.scratch_objects()), Ok(Vec::new()));
}

/// An object that is described as writable, but refuses to be written, serves only if all objects refuse. The bench
/// finds this out once, and puts the value back.
#[test]
fn an_object_that_is_refused_does_not_serve() {
    let target = described(&[("1017", "DataType=0x0006"), ("100C", "DataType=0x0006")]);
    let fixed = |index| ((index, 0), vec![0, 0], false);
    let found = |rows: Vec<Row>| -> Vec<u16> {
        on(&target, rows, |bench| {
            let first = bench.scratch_objects().unwrap();
            let asked = bench.evidence().frames().count();
            assert_eq!(bench.scratch_objects().unwrap(), first);
            let again = bench.evidence().frames().count() - asked;
            assert_eq!(again, 2 * first.len().max(2), "read once more, and not written");
            assert_eq!(bench.take_breaches(None), [], "a refusal is the matter of other cases");
            first.iter().map(|scratch| scratch.multiplexer.index.0).collect()
        })
    };
    assert_eq!(found(vec![fixed(0x1017), row(0x100C, 0, &[0, 0])]), [0x100C]);
    assert_eq!(found(vec![fixed(0x1017), fixed(0x100C)]), [0x1017, 0x100C]);
}

/// A PDO parameter does not serve if it can't be written while the PDO is valid. Any other object serves, even if the
/// device refuses to write it.
#[test]
fn a_locked_pdo_parameter_does_not_serve() {
    let target =
        described(&[("1800sub5", "DataType=0x0006"), ("1BFFsub1", "DataType=0x0007"), ("1006", "DataType=0x0007")]);
    let rows = vec![((0x1800, 5), vec![0, 0], false), ((0x1006, 0), vec![0; 4], false)];
    let found = on(&target, rows, |bench| bench.scratch_objects().unwrap());
    assert_eq!(found, [scratch(0x1006, 0, &[0; 4], &100_000_u32.to_le_bytes())]);
}

/// If no other object serves, objects that RPDOs carry do: one of each length up to four bytes.
#[test]
fn received_values_serve_where_nothing_else_does() {
    let target = described(&[
        ("2000", "DataType=0x0005\nPDOMapping=1\nAccessType=rww"),
        ("2001", "DataType=0x0005\nPDOMapping=1\nAccessType=rww"),
        ("2002", "DataType=0x0007\nPDOMapping=1"),
        ("2003", "DataType=0x001B\nPDOMapping=1"),
        ("2004", "DataType=0x0006\nPDOMapping=1\nAccessType=ro"),
        ("2005", "DataType=0x0006\nPDOMapping=0"),
    ]);
    let rows: Vec<Row> = [(0x2000, 1), (0x2001, 1), (0x2002, 4), (0x2003, 4), (0x2004, 2), (0x2005, 2)]
        .iter()
        .map(|&(index, length)| row(index, 0, &vec![6; length]))
        .collect();
    on(&target, rows, |bench| {
        let found = bench.scratch_objects().unwrap();
        assert_eq!(found, [scratch(0x2000, 0, &[6], &[7]), scratch(0x2002, 0, &[6; 4], &[7, 6, 6, 6])]);
        assert_eq!(bench.application_scratch(), Ok(Some(scratch(0x2000, 0, &[6], &[7]))));
        let mapped = |objects: Vec<Mapped>| -> Vec<(u16, u8)> {
            objects.iter().map(|mapped| (mapped.at.index.0, mapped.bits)).collect()
        };
        assert_eq!(mapped(bench.rpdo_objects()), [(0x2000, 8), (0x2001, 8), (0x2002, 32), (0x2003, 64)]);
        assert_eq!(mapped(bench.tpdo_objects()), [(0x2002, 32), (0x2003, 64), (0x2004, 16)]);
        // The first object that SDO can write and that fits into the PDO.
        let (mapped, other) = bench.changeable().unwrap();
        assert_eq!((mapped.at, other), (at(0x2002), vec![7, 6, 6, 6]));
        let uses = bench.finish().uses;
        assert_eq!(
            uses.last().map(|used| (used.multiplexer, used.purpose)),
            Some((at(0x2002), "mapped into TPDO 1, and written"))
        );
    });
}

/// PDOs carry objects of the application that have whole bytes and are mappable, not bits or communication objects.
#[test]
fn what_a_pdo_can_carry() {
    let target = described(&[
        ("1001", "DataType=0x0005\nPDOMapping=1\nAccessType=ro"),
        ("1FFF", "DataType=0x0005\nPDOMapping=1"),
        ("2000", "DataType=0x0001\nPDOMapping=1"),
        ("2001", "DataType=0x0009\nPDOMapping=1"),
        ("2002", "DataType=0x0010\nPDOMapping=1"),
        ("2003", "DataType=0x0005\nPDOMapping=1\nAccessType=wo"),
        ("2004", "DataType=0x0005\nPDOMapping=1\nAccessType=ro"),
    ]);
    on(&target, Vec::new(), |bench| {
        let indexes = |objects: Vec<Mapped>| objects.iter().map(|mapped| mapped.at.index.0).collect::<Vec<_>>();
        assert_eq!(indexes(bench.tpdo_objects()), [0x2002, 0x2004], "24 bits are whole bytes");
        assert_eq!(indexes(bench.rpdo_objects()), [0x2002], "what only can be written can't be looked at");
        let Err(Stop::NotApplicable(reason)) = bench.require_one(RPDO.numbered(2), &[]) else { panic!("one") };
        assert_eq!(reason.duty, "RPDO 2 can carry an object");
        assert!(bench.require_one(TPDO, &bench.tpdo_objects()).is_ok());
    });
    with_bench(dictionary(Vec::new()), |bench| {
        assert!(bench.tpdo_objects().is_empty() && bench.rpdo_objects().is_empty());
        assert!(matches!(bench.changeable(), Err(Stop::NotApplicable(_))));
    });
}

/// Objects of the profile come before those of a manufacturer; a value of more than four bytes does not serve.
#[test]
fn an_application_object_serves() {
    let known = |rows: Vec<Row>| with_bench(dictionary(rows), |bench| bench.application_scratch().unwrap());
    let area = row(0x6402, 0, &[0; 4]);
    assert_eq!(known(vec![area]), Some(scratch(0x6402, 0, &[0; 4], &[0xE8, 3, 0, 0])));
    assert_eq!(
        known(vec![row(0x6402, 1, &[0xE8, 3, 0, 0])]),
        Some(scratch(0x6402, 1, &[0xE8, 3, 0, 0], &[0xD0, 7, 0, 0]))
    );
    assert_eq!(known(vec![row(0x6401, 0, &[0; 4])]), Some(scratch(0x6401, 0, &[0; 4], &[16, 0, 0, 0])));
    assert_eq!(known(vec![row(0x2140, 1, &[1, 0, 0, 0])]), Some(scratch(0x2140, 1, &[1, 0, 0, 0], &[2, 0, 0, 0])));
    assert_eq!(known(vec![row(0x1017, 0, &[0, 0])]), None);
    let target = described(&[
        ("2000", "DataType=0x0005\nPDOMapping=1"),
        ("5FFF", "DataType=0x0005\nPDOMapping=1"),
        ("6000", "DataType=0x001B\nPDOMapping=1"),
        ("6001", "DataType=0x0007\nPDOMapping=1"),
    ]);
    let rows = vec![row(0x2000, 0, &[1]), row(0x5FFF, 0, &[1]), row(0x6000, 0, &[1; 4]), row(0x6001, 0, &[1; 4])];
    let found = on(&target, rows.clone(), |bench| bench.application_scratch().unwrap());
    assert_eq!(found, Some(scratch(0x6001, 0, &[1; 4], &[0, 1, 1, 1])));
    // Objects of the profile begin at 6000h.
    let target = described(&[("5FFF", "DataType=0x0005\nPDOMapping=1"), ("6000", "DataType=0x0007\nPDOMapping=1")]);
    let found = on(&target, rows, |bench| bench.application_scratch().unwrap());
    assert_eq!(found, Some(scratch(0x6000, 0, &[1; 4], &[0, 1, 1, 1])));
}

/// A string of the application that is readable and writable, and does not load programs.
#[test]
fn a_string_that_can_be_written() {
    let serves = |index: &str, lines: &str| {
        let target = described(&[(index, lines)]);
        on(&target, Vec::new(), |bench| {
            let found = bench.long_writable();
            let used = bench.long_scratch();
            assert_eq!(used.is_ok(), found.is_some());
            assert_eq!(bench.finish().uses.len(), usize::from(found.is_some()));
            found.is_some()
        })
    };
    for data_type in ["0x0009", "0x000A"] {
        assert!(serves("2000", &format!("DataType={data_type}")), "{data_type}");
    }
    assert!(serves("9FFF", "DataType=0x0009"));
    for (index, lines) in [
        ("2000", "DataType=0x0007"),
        ("2000", "DataType=0x000B"),
        ("2000", "DataType=0x000F"),
        ("1F50", "DataType=0x000F"),
        ("1FFF", "DataType=0x0009"),
        ("A000", "DataType=0x0009"),
        ("2000", "DataType=0x0009\nAccessType=ro"),
        ("2000", "DataType=0x0009\nAccessType=wo"),
        ("2000", "DataType=0x0009\nObjFlags=1"),
        ("2000", "DataType=0x0009\nObjFlags=2"),
    ] {
        assert!(!serves(index, lines), "{index} {lines}");
    }
    with_bench(dictionary(Vec::new()), |bench| assert_eq!(bench.long_writable(), None));
}

/// Names come first, then objects described as long, unless they must not be read.
#[test]
fn long_values_are_those_that_the_server_announces() {
    use canvass_traces::{Duration, Frame};
    // Each object answers with the size that it announces; 2003h announces none, and 2004h has four bytes.
    let script = |request: &Frame| {
        let answer = match request.to_string().get(..10).unwrap_or_default() {
            "63F#400820" => "5BF#4108200009000000",
            "63F#400120" => "5BF#4101200008000000",
            "63F#400220" => "5BF#4102200007000000",
            "63F#400320" => "5BF#4003200000000000",
            "63F#400420" => "5BF#4304200041424344",
            "63F#600000" => "5BF#0141424344454647",
            _ => return Vec::new(),
        };
        vec![(Duration::from_millis(1), crate::scripted::frame(answer))]
    };
    let target = described(&[
        ("1FFF", "DataType=0x0007"),
        ("2001", "DataType=0x0009"),
        ("2002", "DataType=0x000F"),
        ("2003", "DataType=0x000A"),
        ("2004", "DataType=0x001B"),
        ("2008", "DataType=0x0009\nObjFlags=2"),
        ("2009", "DataType=0x0009\nAccessType=wo"),
    ]);
    with_target(script, &target, &Options::default(), |bench| {
        assert_eq!(bench.long_object(8), Ok(Some(at(0x2001))));
        assert_eq!(bench.long_object(9), Ok(None), "2008h must not be read");
        assert_eq!(bench.long_object(7), Ok(Some(at(0x2001))));
        assert_eq!(bench.long_objects(7, 5), Ok(vec![at(0x2001), at(0x2003)]), "2002h is no text");
        assert_eq!(bench.long_objects(7, 1), Ok(vec![at(0x2001)]));
        let uses = bench.finish().uses;
        assert_eq!(uses.iter().map(|used| used.multiplexer).collect::<Vec<_>>(), [at(0x2001)]);
    });
}

/// A text that is empty by its description and on the device; the device may also answer 0800 0024h.
#[test]
fn an_empty_text_is_looked_for() {
    use canvass_traces::{Duration, Frame};
    let found = |lines: &str, answer: Option<&'static str>| {
        let script = move |request: &Frame| match request.to_string().starts_with("63F#400020") {
            true => {
                answer.map(|answer| (Duration::from_millis(1), crate::scripted::frame(answer))).into_iter().collect()
            }
            false => Vec::new(),
        };
        let target = described(&[("2000", lines)]);
        with_target(script, &target, &Options::default(), |bench| bench.empty_object().unwrap().is_some())
    };
    const TEXT: &str = "DataType=0x0009\nAccessType=ro";
    let no_data = Some("5BF#8000200024000008");
    assert!(found(TEXT, no_data) && found(TEXT, None) && found(TEXT, Some("5BF#4100200000000000")));
    assert!(!found(TEXT, Some("5BF#4300200041424344")), "it is not empty");
    assert!(!found(TEXT, Some("5BF#8000200000000206")), "it is not there");
    assert!(!found("DataType=0x0009\nAccessType=wo", no_data) && !found("DataType=0x0007", no_data));
    assert!(!found("DataType=0x0009\nObjFlags=2", no_data) && !found("DataType=0x0009\nDefaultValue=text", no_data));
    assert!(found("DataType=0x000A", no_data) && found("DataType=0x000B", no_data));
    with_bench(dictionary(Vec::new()), |bench| assert_eq!(bench.empty_object(), Ok(None)));
}

/// Of many texts that are described as empty, eight are read.
#[test]
fn eight_texts_are_asked_whether_they_are_empty() {
    let sections: Vec<(String, &str)> =
        (0..10).map(|n| (format!("200{n}"), "DataType=0x0009\nAccessType=ro")).collect();
    let sections: Vec<(&str, &str)> = sections.iter().map(|(name, lines)| (name.as_str(), *lines)).collect();
    let target = described(&sections);
    let found = |empty: u8| {
        let script = move |request: &canvass_traces::Frame| match request.bytes() {
            [0x40, number, 0x20, ..] if number != empty => {
                let answer = crate::scripted::frame(&format!("5BF#43{number:02X}200041424344"));
                vec![(canvass_traces::Duration::from_millis(1), answer)]
            }
            _ => Vec::new(),
        };
        with_target(script, &target, &Options::default(), |bench| bench.empty_object().unwrap())
    };
    assert_eq!((found(0), found(7), found(8)), (Some(at(0x2000)), Some(at(0x2007)), None));
}

/// TPDO 1 is set up with objects that SDO can write, then with other objects; the error register, if it can be mapped,
/// is last.
#[test]
fn a_tpdo_is_set_up_with_the_best_object() {
    const PDO: [(&str, &str); 3] =
        [("1800sub1", "DataType=0x0007"), ("1A00sub0", "DataType=0x0005"), ("1A00sub1", "DataType=0x0007")];
    let of = |more: &[(&str, &str)]| described(&[&PDO[..], more].concat());
    let candidate =
        |target: &Target| on(target, Vec::new(), |bench| bench.tpdo_candidate().map(|mapped| mapped.at.index.0));
    let register = ("1001", "DataType=0x0005\nAccessType=ro\nPDOMapping=1");
    let (read, written) =
        (("2000", "DataType=0x0005\nAccessType=ro\nPDOMapping=1"), ("2001", "DataType=0x0005\nPDOMapping=1"));
    assert_eq!(candidate(&of(&[register, read, written])), Some(0x2001));
    assert_eq!(candidate(&of(&[register, read])), Some(0x2000));
    assert_eq!(candidate(&of(&[register])), Some(0x1001));
    assert_eq!(candidate(&of(&[("1001", "DataType=0x0005\nAccessType=ro")])), None);
    with_bench(dictionary(Vec::new()), |bench| assert_eq!(bench.tpdo_candidate(), None));
    let rows = |valid: u8, count: u8| {
        vec![row(0x1800, 1, &[0xBF, 1, 0, valid]), row(0x1A00, 0, &[count]), row(0x1A00, 1, &[0; 4])]
    };
    let target = of(&[register, read, written]);
    // The PDO is first switched off if it is on; then come the entry, the count, and the PDO with its own CAN-ID.
    let provided = |valid: u8| {
        on(&target, rows(valid, 0), |bench| {
            assert_eq!(bench.provide_tpdo(), Ok(Ok(())));
            let values = [(0x1800, 1), (0x1A00, 0), (0x1A00, 1)]
                .map(|(index, sub)| bench.read_number(Multiplexer::new(index, sub)).unwrap());
            let uses: Vec<String> = bench.finish().uses.iter().map(|used| used.multiplexer.to_string()).collect();
            assert_eq!(uses, ["2001h:00", "1800h:01"]);
            values
        })
    };
    assert_eq!(provided(0x40), [0x4000_01BF, 1, 0x2001_0008]);
    assert_eq!(provided(0xC0), [0x4000_01BF, 1, 0x2001_0008]);
    let refused =
        |rows: Vec<Row>, target: &Target| on(target, rows, |bench| bench.provide_tpdo()).unwrap().unwrap_err();
    let mut fixed_entry = rows(0xC0, 0);
    fixed_entry[2].2 = false;
    assert!(
        refused(fixed_entry, &target).starts_with("TPDO 1 maps no object (1A00h:00 is 0), and 1A00h:01 can't be set: ")
    );
    let mut fixed_id = rows(0x40, 0);
    fixed_id[0].2 = false;
    assert!(refused(fixed_id, &target).contains("and 1800h:01 can't be set: "));
    assert_eq!(
        refused(rows(0xC0, 0), &of(&[])),
        "TPDO 1 maps no object (1A00h:00 is 0), and the description names no object for it"
    );
    let described_fixed = described(&[("1800sub1", "DataType=0x0007\nAccessType=ro"), PDO[1], PDO[2], written]);
    let off = "TPDO 1 is switched off (1800h:01 is C00001BFh), and 1800h:01 can't be written";
    assert_eq!(refused(rows(0xC0, 1), &described_fixed), off);
    let fixed_mapping = described(&[PDO[0], ("1A00sub0", "DataType=0x0005\nAccessType=ro"), PDO[2], written]);
    assert_eq!(
        refused(rows(0xC0, 0), &fixed_mapping),
        "TPDO 1 maps no object (1A00h:00 is 0), and 1A00h:00 can't be written"
    );
}

/// A COB-ID without CAN-ID gets the predefined one of its PDO, if there is one.
#[test]
fn a_pdo_that_is_off_without_a_can_id_is_on_with_the_predefined_one() {
    let rows = vec![row(0x1800, 1, &[0, 0, 0, 0xC0]), row(0x1A00, 0, &[1])];
    with_bench(dictionary(rows), |bench| {
        assert_eq!(bench.provide_tpdo(), Ok(Ok(())));
        assert_eq!(bench.pdo_cob_id(TPDO), Ok(CobId(0x4000_01BF)));
        bench.pdo_off(TPDO).unwrap();
        bench.pdo_on(TPDO, CobId(0x8000_0123)).unwrap();
        assert_eq!(bench.pdo_cob_id(TPDO), Ok(CobId(0x123)));
    });
}

/// A server may leave the number of bytes open in one answer (42h) and tell it in another: the value is the same.
#[test]
fn a_value_of_unstated_size_has_the_size_of_its_type() {
    let target = described(&[("2000", "DataType=0x0005"), ("2001", "DataType=0x0009")]);
    let script =
        table(&[("63F#4000200000000000", "5BF#4200200007000000"), ("63F#4001200000000000", "5BF#4201200061620000")]);
    with_target(script, &target, &Options::default(), |bench| {
        assert_eq!(bench.read(at(0x2000)).unwrap(), [7]);
        assert_eq!(bench.read(at(0x2001)).unwrap(), *b"ab\0\0", "a string has no size");
    });
}
