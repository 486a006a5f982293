//! Descriptions made from answers: types, access, defaults, and marks of guesses.

use super::{Guess, Scan, Scanned};
use crate::dictionary::check::check;
use crate::dictionary::survey::compare::compare;
use crate::dictionary::survey::{Answer, Survey};
use crate::dictionary::{DeviceDescription, Entry, FileInfo, ObjectCode, Severity};
use crate::identity::{Index, Multiplexer, NodeId};
use crate::wire::sdo::AbortCode;
use proptest::prelude::*;

fn node() -> NodeId {
    NodeId::new(5).unwrap()
}

fn value(bytes: &[u8]) -> Answer {
    Answer::Value(bytes.to_vec())
}

/// The description of an encoder with a PDO that also gives the answers in `more`.
fn scanned(more: &[(u16, u8, Answer)]) -> Scanned {
    let mut survey: Survey = [
        (0x1000, 0, value(&[0x96, 1, 2, 0])),
        (0x1001, 0, value(&[0])),
        (0x1003, 0, value(&[0])),
        (0x1008, 0, value(b"Encoder\0\0")),
        (0x1014, 0, value(&[0x85, 0, 0, 0])),
        (0x1017, 0, value(&[0xE8, 3])),
        (0x1018, 0, value(&[1])),
        (0x1018, 1, value(&[0x13, 0, 0, 0])),
        (0x1800, 0, value(&[2])),
        (0x1800, 1, value(&[0x85, 1, 0, 0x40])),
        (0x1800, 2, value(&[255])),
        (0x1A00, 0, value(&[1])),
        (0x1A00, 1, value(&[0x20, 0, 4, 0x60])),
        (0x6004, 0, value(&[1, 2, 3, 4])),
    ]
    .into_iter()
    .map(|(index, sub, answer)| (Multiplexer::new(index, sub), answer))
    .collect();
    for (index, sub, answer) in more {
        survey.insert(Multiplexer::new(*index, *sub), answer.clone());
    }
    Scan { survey: &survey, node: node(), bit_rate: Some(250), file: FileInfo::default() }.describe()
}

fn entry(scanned: &Scanned, index: u16, sub: u8) -> &Entry {
    scanned.description.dictionary.entry(Multiplexer::new(index, sub)).unwrap()
}

/// An entry such as `UNSIGNED32 rw $NODEID+180h`, with its guesses.
fn shown(scanned: &Scanned, index: u16, sub: u8) -> String {
    let entry = entry(scanned, index, sub);
    let default = entry.default.as_ref().map(|default| format!(" {default}")).unwrap_or_default();
    let guesses = scanned.guesses.get(&Multiplexer::new(index, sub)).into_iter().flatten();
    let guesses: String = guesses.map(|guess| format!(" ({guess:?})")).collect();
    format!("{} {}{default}{guesses}", entry.data_type, entry.access)
}

#[test]
fn standard_objects_are_as_their_standard_says() {
    let one = scanned(&[]);
    assert_eq!(shown(&one, 0x1000, 0), "UNSIGNED32 ro 131478");
    assert_eq!(shown(&one, 0x1001, 0), "UNSIGNED8 ro");
    assert_eq!(shown(&one, 0x1017, 0), "UNSIGNED16 rw 1000");
    assert_eq!(shown(&one, 0x1014, 0), "UNSIGNED32 rw $NODEID+80h");
    assert_eq!(shown(&one, 0x1800, 1), "UNSIGNED32 rw $NODEID+40000180h");
    assert_eq!(shown(&one, 0x6004, 0), "UNSIGNED32 ro");
    let position = one.description.dictionary.object(Index(0x6004)).unwrap();
    assert_eq!((position.name.as_str(), position.code), ("Position value", ObjectCode::VAR));
    assert!(entry(&one, 0x6004, 0).pdo_mappable && !entry(&one, 0x1017, 0).pdo_mappable);
    assert_eq!(entry(&one, 0x1A00, 1).name, "Application object 1");
    // 1003h is an array even if no error has happened yet.
    assert_eq!(one.description.dictionary.object(Index(0x1003)).unwrap().code, ObjectCode::ARRAY);
    let device = &one.description.device;
    assert_eq!((device.vendor_number, device.product_name.as_str(), device.tpdos), (Some(0x13), "Encoder", 1));
    assert_eq!((&device.bit_rates[..], device.granularity), (&[250][..], 8));
}

#[test]
fn other_objects_are_guessed_and_said_to_be() {
    let other = scanned(&[
        (0x2000, 0, value(&[1, 0])),
        (0x2001, 0, value(b"V1.2 of 2026")),
        (0x2002, 0, value(&[0; 9])),
        (0x2003, 0, Answer::Long(4_096)),
        (0x2004, 0, Answer::Aborted(AbortCode::WRITE_ONLY)),
        (0x2005, 0, value(&[0; 8])),
        (0x2006, 0, Answer::Aborted(AbortCode::NO_OBJECT)),
        (0x2007, 0, Answer::Aborted(AbortCode::NO_DATA)),
    ]);
    assert_eq!(shown(&other, 0x2000, 0), "UNSIGNED16 ro (TypeOf(2)) (Access)");
    assert_eq!(shown(&other, 0x2001, 0), "VISIBLE_STRING ro (TypeOf(12)) (Access)");
    assert_eq!(shown(&other, 0x2002, 0), "DOMAIN ro (TypeOf(9)) (Access)");
    assert_eq!(shown(&other, 0x2003, 0), "DOMAIN ro (TypeOf(4096)) (Access)");
    assert_eq!(shown(&other, 0x2004, 0), "UNSIGNED32 wo (Type)");
    assert_eq!(shown(&other, 0x2005, 0), "UNSIGNED64 ro (TypeOf(8)) (Access)");
    assert_eq!(shown(&other, 0x2007, 0), "UNSIGNED32 ro (Type) (Access)");
    assert!(other.description.dictionary.object(Index(0x2006)).is_none());
    let eds = other.eds();
    assert!(
        eds.contains(
            "[2000]\r\n; guessed: the data type, from 2 bytes; the access type, which only writing would show\r\n"
        ),
        "{eds}"
    );
}

#[test]
fn sub_indexes_make_arrays_and_records() {
    let parts =
        |first: &[u8], second: &[u8]| [(0x2100, 0, value(&[2])), (0x2100, 1, value(first)), (0x2100, 2, value(second))];
    let code = |scanned: &Scanned| scanned.description.dictionary.object(Index(0x2100)).unwrap().code;
    assert_eq!(code(&scanned(&parts(&[1], &[2]))), ObjectCode::ARRAY);
    let record = scanned(&parts(&[1], &[2, 0]));
    assert_eq!((code(&record), shown(&record, 0x2100, 0)), (ObjectCode::RECORD, "UNSIGNED8 ro 2".to_owned()));
    // Sub-index 0 is no count, or does not exist.
    assert_eq!(code(&scanned(&[(0x2100, 0, value(&[2, 0])), (0x2100, 2, value(&[1]))])), ObjectCode::RECORD);
    let headless = scanned(&[(0x2100, 0, Answer::Aborted(AbortCode::NO_SUB_INDEX)), (0x2100, 1, value(&[1]))]);
    assert_eq!(headless.description.dictionary.object(Index(0x2100)).unwrap().entries().len(), 1);
    // The standard has an array, the device a single value.
    let single = scanned(&[(0x6020, 0, value(&[1, 2, 3, 4]))]);
    assert_eq!(single.description.dictionary.object(Index(0x6020)).unwrap().code, ObjectCode::VAR);
    assert_eq!(shown(&single, 0x6020, 0), "UNSIGNED32 ro (TypeOf(4)) (Access)");
}

#[test]
fn what_pdos_carry_tells_access_and_type() {
    let mapped = scanned(&[
        (0x1600, 0, value(&[2])),
        (0x1600, 1, value(&[8, 0, 0, 0x20])),
        (0x1600, 2, value(&[8, 0, 5, 0])),
        (0x2000, 0, value(&[1])),
        (0x6030, 0, value(&[1])),
        (0x6030, 1, value(&[0; 4])),
    ]);
    assert_eq!(shown(&mapped, 0x2000, 0), "UNSIGNED8 rww (TypeOf(1))");
    assert!(entry(&mapped, 0x2000, 0).pdo_mappable);
    assert_eq!(mapped.description.dummy_usage.get(&5), Some(&true));
    // The value has four bytes, as in a later version of the profile.
    assert_eq!(shown(&mapped, 0x6030, 1), "INTEGER32 ro (TypeBeside(4))");
    assert_eq!(mapped.guesses[&Multiplexer::new(0x6030, 1)], [Guess::TypeBeside(4)]);
}

#[test]
fn what_the_device_has_wrong_is_waived_in_the_file() {
    let wrong = scanned(&[(0x1A00, 1, value(&[0x10, 0, 4, 0x60]))]);
    let eds = wrong.eds();
    assert!(eds.contains("[1A00sub1]\r\n; canvass: allow eds/pdo/length the device has it so\r\n"), "{eds}");
}

fn errors(eds: &str) -> Vec<String> {
    let checked = check(eds.as_bytes(), None).unwrap();
    let open = checked.findings.iter().filter(|finding| finding.waived.is_none());
    open.filter(|finding| finding.severity() == Severity::Error).map(|finding| format!("{finding:?}")).collect()
}

fn any_answer() -> impl Strategy<Value = Answer> {
    prop_oneof![
        6 => proptest::collection::vec(any::<u8>(), 0..12).prop_map(Answer::Value),
        1 => Just(Answer::Aborted(AbortCode::WRITE_ONLY)),
        1 => Just(Answer::Aborted(AbortCode::NO_OBJECT)),
        1 => Just(Answer::Aborted(AbortCode::NO_SUB_INDEX)),
        1 => Just(Answer::Aborted(AbortCode::NO_DATA)),
        1 => Just(Answer::Long(4_096)),
        1 => Just(Answer::Silent),
    ]
}

fn any_index() -> impl Strategy<Value = u16> {
    prop_oneof![
        0x1000u16..0x1030,
        0x1200u16..0x1202,
        0x1400u16..0x1402,
        0x1600u16..0x1602,
        0x1800u16..0x1802,
        0x1A00u16..0x1A02,
        0x2000u16..0x2003,
        0x6000u16..0x6050
    ]
}

proptest! {
    /// Whatever a device answers, the file reads back as the same description, has no error without waiver, and does
    /// not differ from the device.
    #[test]
    fn any_device_is_as_its_own_description(answers in proptest::collection::vec((any_index(), 0u8..4, any_answer()), 0..40)) {
        let answers = answers.into_iter().map(|(index, sub, answer)| (Multiplexer::new(index, sub), answer));
        let survey: Survey = answers.collect();
        let file = FileInfo { name: "device.eds".to_owned(), ..FileInfo::default() };
        let eds = Scan { survey: &survey, node: node(), bit_rate: None, file }.describe().eds();
        prop_assert!(errors(&eds).is_empty(), "{:#?}\n{}", errors(&eds), eds);
        let description = DeviceDescription::read(eds.as_bytes()).unwrap();
        let differs = compare(&description, &survey, node());
        prop_assert!(differs.is_empty(), "{differs:#?}\n{eds}");
    }
}
