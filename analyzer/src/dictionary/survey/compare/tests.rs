//! Each kind of difference is made in the answers of a device and found.

use super::{Mismatch, MismatchKind, Weight, compare};
use crate::dictionary::survey::{Answer, Survey};
use crate::dictionary::{DeviceDescription, Value};
use crate::identity::{Multiplexer, NodeId};
use crate::wire::sdo::AbortCode;
use std::collections::BTreeSet;

const EDS: &str = include_str!("../../../../tests/difference/old.eds");
const NODE: NodeId = NodeId::MIN;

fn read(text: &str) -> DeviceDescription {
    DeviceDescription::read(text.as_bytes()).unwrap()
}

/// The answers of a device that matches its description; a value without default is zero.
fn as_described(description: &DeviceDescription) -> Survey {
    let answer = |entry: &crate::dictionary::Entry| {
        let zeros = || Some(vec![0; entry.data_type.bytes()?]);
        let start = entry.start_value(NODE).and_then(|value: Value| value.encode(entry.data_type).ok());
        match entry.access.is_readable() {
            true => Answer::Value(start.or_else(zeros).unwrap_or_default()),
            false => Answer::Aborted(AbortCode::WRITE_ONLY),
        }
    };
    description.dictionary.entries().map(|(at, entry)| (at, answer(entry))).collect()
}

fn shown(mismatch: &Mismatch) -> String {
    let weight = match mismatch.weight {
        Weight::Differs => "",
        Weight::MayBeConfiguration => "?",
        Weight::MayBeState => "??",
    };
    format!("{}{weight} {} {} -> {}", mismatch.kind.id(), mismatch.subject, mismatch.described, mismatch.found)
}

/// The differences found if the device gives these answers, and the description is changed from `from` to `to`.
fn found((from, to): (&str, &str), answers: &[(u16, u8, Answer)]) -> Vec<String> {
    assert!(EDS.contains(from), "{from}");
    // A DCF in part: one object keeps a configured value, which the device does not have.
    let text = EDS.replace("ParameterValue=0x85\n", "").replace("ParameterValue=1\n", "").replacen(from, to, 1);
    let description = read(&text);
    let mut survey = as_described(&description);
    for (index, sub, answer) in answers {
        survey.insert(Multiplexer::new(*index, *sub), answer.clone());
    }
    compare(&description, &survey, NODE).iter().map(shown).collect()
}

fn bytes(bytes: &[u8]) -> Answer {
    Answer::Value(bytes.to_vec())
}

const ABSENT: Answer = Answer::Aborted(AbortCode::NO_OBJECT);
const NO_SUB: Answer = Answer::Aborted(AbortCode::NO_SUB_INDEX);
const AS_IT_IS: (&str, &str) = ("", "");

#[test]
fn a_device_as_described_has_no_difference() {
    assert_eq!(found(AS_IT_IS, &[]), [""; 0]);
    // An entry that was not read is no difference.
    assert_eq!(compare(&read(EDS), &Survey::default(), NODE), []);
}

#[test]
fn what_is_missing_or_not_described_is_found() {
    assert_eq!(
        found(AS_IT_IS, &[(0x2002, 0, ABSENT), (0x2002, 1, ABSENT), (0x2002, 2, ABSENT)]),
        ["missing-object 2002h described -> abort 0602 0000h object does not exist in the object dictionary"]
    );
    let missing = found(AS_IT_IS, &[(0x2002, 2, NO_SUB)]);
    assert!(missing.len() == 1 && missing[0].starts_with("missing-sub-index 2002h:02 described -> abort 0609 0011h"));
    let more =
        [(0x1017, 0, bytes(&[0, 0])), (0x1018, 2, bytes(&[7, 0, 0, 0])), (0x1800, 3, NO_SUB), (0x1F50, 0, ABSENT)];
    assert_eq!(
        found(AS_IT_IS, &more),
        [
            "identity ProductNumber 00000002h -> 00000007h",
            "undescribed-object 1017h nothing -> 2 bytes: 00 00",
            "undescribed-sub-index 1018h:02 nothing -> 4 bytes: 07 00 00 00"
        ]
    );
    let hidden = [(0x2F00, 0, Answer::Aborted(AbortCode::WRITE_ONLY)), (0x2F00, 1, bytes(&[1]))];
    assert_eq!(found(AS_IT_IS, &hidden).len(), 1);
}

#[test]
fn lengths_and_values_are_held_against_types_and_limits() {
    assert_eq!(found(AS_IT_IS, &[(0x2000, 0, bytes(&[5]))]), ["length 2000h:00 UNSIGNED16 -> 1 byte"]);
    let both = found(AS_IT_IS, &[(0x2000, 0, bytes(&[0xE9, 3]))]);
    assert_eq!(both, ["limits 2000h:00 0 to 1000 -> 1001", "setting? 2000h:00 5 -> 1001"]);
    let flag = (
        "[2001]\nParameterName=State\nObjectType=0x7\nDataType=0x0005",
        "[2001]\nParameterName=State\nObjectType=0x7\nDataType=0x0001",
    );
    assert_eq!(found(flag, &[(0x2001, 0, bytes(&[9]))]), ["no-value 2001h:00 BOOLEAN -> 1 byte: 09"]);
    assert_eq!(
        found(AS_IT_IS, &[(0x1000, 0, Answer::Long(4_096))]),
        ["length 1000h:00 UNSIGNED32 -> more than 4096 bytes"]
    );
}

#[test]
fn access_is_told_as_far_as_reading_tells() {
    let write_only = Answer::Aborted(AbortCode::WRITE_ONLY);
    let refused = found(AS_IT_IS, &[(0x2001, 0, write_only)]);
    assert_eq!(refused, ["access 2001h:00 ro -> abort 0601 0001h attempt to read a write only object"]);
    let hidden = ("DataType=0x0005\nAccessType=ro\nPDOMapping=1", "DataType=0x0005\nAccessType=wo\nPDOMapping=1");
    assert_eq!(found(hidden, &[]), [""; 0]);
    assert_eq!(found(hidden, &[(0x2001, 0, bytes(&[0]))]), ["access 2001h:00 wo -> 1 byte: 00"]);
    // A value that is not available at the moment is no difference.
    assert_eq!(found(AS_IT_IS, &[(0x2001, 0, Answer::Aborted(AbortCode::NO_DATA))]), [""; 0]);
    let other = found(AS_IT_IS, &[(0x2001, 0, Answer::Aborted(AbortCode::HARDWARE))]);
    assert!(other.len() == 1 && other[0].starts_with("refused 2001h:00 ro -> abort 0606 0000h"), "{other:?}");
    assert_eq!(found(AS_IT_IS, &[(0x2001, 0, Answer::Silent)]), ["no-answer 2001h:00 ro -> no answer"]);
    let violated = Answer::Violated("a toggle bit".to_owned());
    assert_eq!(found(AS_IT_IS, &[(0x2001, 0, violated)]), ["violation 2001h:00 ro -> a toggle bit"]);
}

#[test]
fn values_weigh_what_they_can() {
    assert_eq!(found(AS_IT_IS, &[(0x1000, 0, bytes(&[0x91, 1, 0, 0]))]), ["identity 1000h:00 406 -> 401"]);
    assert_eq!(found(AS_IT_IS, &[(0x1018, 1, bytes(&[9, 0, 0, 0]))]), ["identity 1018h:01 17 -> 9"]);
    assert_eq!(found(AS_IT_IS, &[(0x2002, 0, bytes(&[4]))]), ["count 2002h:00 2 -> 4"]);
    assert_eq!(found(AS_IT_IS, &[(0x1800, 2, bytes(&[1]))]), ["setting? 1800h:02 255 -> 1"]);
    let fixed = ("AccessType=rw\nDefaultValue=255", "AccessType=ro\nDefaultValue=255");
    assert_eq!(found(fixed, &[(0x1800, 2, bytes(&[1]))]), ["constant 1800h:02 255 -> 1"]);
    let own = ("AccessType=rw\nDefaultValue=5\nPDOMapping=1", "AccessType=ro\nDefaultValue=5\nPDOMapping=0");
    assert_eq!(found(own, &[(0x2000, 0, bytes(&[6, 0]))]), ["state?? 2000h:00 5 -> 6"]);
    let constant = ("AccessType=rw\nDefaultValue=5\nPDOMapping=1", "AccessType=const\nDefaultValue=5\nPDOMapping=0");
    assert_eq!(found(constant, &[(0x2000, 0, bytes(&[6, 0]))]), ["constant 2000h:00 5 -> 6"]);
    // A measured value is no difference.
    let measured = ("AccessType=rw\nDefaultValue=5\nPDOMapping=1", "AccessType=ro\nDefaultValue=5\nPDOMapping=1");
    assert_eq!(found(measured, &[(0x2000, 0, bytes(&[6, 0]))]), [""; 0]);
    let configured = ("AccessType=rw\nDefaultValue=5\n", "AccessType=rw\nDefaultValue=5\nParameterValue=7\n");
    assert_eq!(found(configured, &[(0x2000, 0, bytes(&[5, 0]))]), [""; 0], "an EDS has no configured values");
    let configured = (configured.0, "AccessType=rw\nParameterValue=7\n[DeviceComissioning]\nNodeID=5\n");
    assert_eq!(found(configured, &[(0x2000, 0, bytes(&[5, 0]))]), ["configured 2000h:00 7 -> 5"]);
}

#[test]
fn the_release_is_held_against_its_description() {
    let named = (
        "[1014]",
        "[100A]\nParameterName=Software\nObjectType=7\nDataType=9\nAccessType=const\nDefaultValue=1.2\n[1014]",
    );
    assert_eq!(found(named, &[(0x100A, 0, bytes(b"1.3"))]), ["release 100Ah:00 \"1.2\" -> \"1.3\""]);
    assert_eq!(found(named, &[(0x100A, 0, bytes(b"1.2  \0"))]), [""; 0]);
}

#[test]
fn pdos_are_told_as_a_whole() {
    let other = [(0x1A00, 1, bytes(&[0x10, 0, 0, 0x20]))];
    assert_eq!(found(AS_IT_IS, &other), ["mapping? TPDO 1 2001h:00 (8 bits) -> 2000h:00 (16 bits)"]);
    let wrong = [(0x1A00, 1, bytes(&[0x10, 1, 2, 0x20]))];
    assert_eq!(
        found(AS_IT_IS, &wrong),
        [
            "unmappable TPDO 1 not mappable -> 2002h:01 (16 bits)",
            "mapping? TPDO 1 2001h:00 (8 bits) -> 2002h:01 (16 bits)"
        ]
    );
    let short = found(AS_IT_IS, &[(0x1A00, 1, bytes(&[0x08, 0, 0, 0x20]))]);
    assert_eq!(short[0], "unmappable TPDO 1 2000h:00 (16 bits) -> 2000h:00 (8 bits)");
    assert_eq!(found(AS_IT_IS, &[(0x1A00, 0, bytes(&[0]))]), ["mapping? TPDO 1 2001h:00 (8 bits) -> nothing"]);
    let cob_id = [(0x1800, 1, bytes(&[0x82, 2, 0, 0]))];
    assert_eq!(found(AS_IT_IS, &cob_id), ["cob-id? 1800h:01 00000181h -> 00000282h"]);
    let fixed = ("AccessType=rw\nDefaultValue=$NODEID+0x180", "AccessType=ro\nDefaultValue=$NODEID+0x180");
    assert_eq!(found(fixed, &cob_id), ["cob-id 1800h:01 00000181h -> 00000282h"]);
}

/// Reports and the programs that read them use the ids.
#[test]
fn ids_and_meanings_are_each_their_own() {
    let ids: BTreeSet<&str> = MismatchKind::ALL.iter().map(|kind| kind.id()).collect();
    let meanings: BTreeSet<&str> = MismatchKind::ALL.iter().map(|kind| kind.meaning()).collect();
    assert_eq!((ids.len(), meanings.len()), (MismatchKind::ALL.len(), MismatchKind::ALL.len()));
}

/// Whatever a device answers, nothing panics, and control characters are shown escaped.
#[test]
fn hostile_answers_are_only_shown() {
    for length in 0..20u8 {
        let answer = bytes(&vec![0x1B; usize::from(length)]);
        let description = read(EDS);
        let survey: Survey = description.dictionary.entries().map(|(at, _)| (at, answer.clone())).collect();
        for mismatch in compare(&description, &survey, NODE) {
            assert!(!shown(&mismatch).chars().any(char::is_control), "{mismatch:?}");
        }
    }
}
