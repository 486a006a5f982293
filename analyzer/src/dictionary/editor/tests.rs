//! Tests of the editor functions in a typical file.

use super::*;
use crate::dictionary::source::Source;

const TEXT: &str = "\
[DeviceInfo]
VendorName=Example
LSS_Supported=

[OptionalObjects]
SupportedObjects=2
1=0x1018
2=0x1A00

[1000]
ParameterName=Device type
DefaultValue=0x00020196

[1018]
ParameterName=Identity
ObjectType=0x9
SubNumber=2

[1018sub1]
ParameterName=Vendor-ID
DataType=0x0007

[1A00]
ParameterName=TPDO mapping
[1A00sub1]
ParameterName=First
DefaultValue=0x60040020

[6004]
ParameterName=Position
";

/// The place `more` characters after the start of a text.
fn at(what: &str, more: usize) -> usize {
    TEXT.find(what).unwrap() + more
}

#[test]
fn entries_stand_below_their_objects() {
    let all = outline(&Source::of_text(TEXT));
    let names: Vec<_> = all.iter().map(|symbol| (symbol.name.as_str(), symbol.entries.len())).collect();
    let expected = [("DeviceInfo", 0), ("OptionalObjects", 0), ("1000", 0), ("1018", 1), ("1A00", 1), ("6004", 0)];
    assert_eq!(names, expected);
    let identity = &all[3];
    assert_eq!((identity.detail.as_str(), identity.entries[0].detail.as_str()), ("Identity", "Vendor-ID"));
    assert_eq!(&TEXT[identity.selected.clone()], "1018");
    assert!(TEXT[identity.whole.clone()].ends_with("DataType=0x0007"));
}

#[test]
fn what_stands_under_the_cursor() {
    let shown =
        |what: &str, more| hover(&Source::of_text(TEXT), at(what, more)).map(|hover| hover.text).unwrap_or_default();
    assert!(
        shown("[1018sub1]", 3).contains("CiA 301 7.5.2.21: Identity object, Vendor-ID"),
        "{}",
        shown("[1018sub1]", 3)
    );
    assert!(shown("0x0007", 2).contains("UNSIGNED32"));
    let mapped = shown("0x60040020", 4);
    assert!(mapped.contains("6004h:00") && mapped.contains("Position") && mapped.contains("32 bits"), "{mapped}");
    assert!(mapped.contains("CiA 406"), "1000h says that it is an encoder: {mapped}");
    assert!(shown("LSS_Supported", 2).contains("LSS"));
    assert_eq!(hover(&Source::of_text(TEXT), at("Example", 2)), None);
}

#[test]
fn from_a_name_to_its_section_and_back() {
    let goes = |what: &str, more| definition(&Source::of_text(TEXT), at(what, more)).map(|range| &TEXT[range]);
    assert_eq!(goes("1=0x1018", 5), Some("1018"));
    assert_eq!(goes("0x60040020", 5), Some("6004"));
    assert_eq!(goes("[1018sub1]", 3), Some("1018sub1"));
    assert_eq!(goes("DataType=0x0007", 12), None, "a data type is no object of the file");
    let named: Vec<_> =
        references(&Source::of_text(TEXT), at("[6004]", 2)).into_iter().map(|range| &TEXT[range]).collect();
    assert_eq!(named, ["0x60040020", "6004"]);
}

#[test]
fn what_may_come_next() {
    let labels = |text: &str| -> Vec<String> {
        let at = text.find('|').unwrap();
        complete(&Source::of_text(text.replace('|', "")), at).into_iter().map(|found| found.label).collect()
    };
    let fields = labels("[1000]\nParameterName=x\nD|\n[1001]\n");
    assert_eq!(fields, ["DataType", "DefaultValue", "Denotation"]);
    assert!(!labels("[1000]\nParameterName=x\n|").contains(&"ParameterName".to_owned()));
    assert_eq!(labels("[1000]\nPDOMapping=|"), ["0", "1"]);
    assert!(labels("[1000]\nDataType=|").contains(&"0x0007".to_owned()));
    assert_eq!(
        labels("[1000]\nx=1\n[101|"),
        ["[1010]", "[1011]", "[1012]", "[1013]", "[1014]", "[1015]", "[1016]", "[1017]", "[1018]", "[1019]"]
    );
    let text = "[1000]\n[1018]\n[1A|";
    assert_eq!(labels(text), ["[1A00]"], "of many of a kind the first that is missing");
    let made = complete(&Source::of_text("[1017"), 5).remove(0);
    assert!(made.text.contains("DataType=0x0006") && made.text.starts_with("[1017]\n"), "{}", made.text);
}

proptest::proptest! {
    /// No text and no place causes a panic; offered places are in the text.
    #[test]
    fn any_text_and_any_place(text in "(\\[|\\]|=|0x1018|sub|1A00|DefaultValue|é|\r?\n| |;|[a-z0-9]){0,40}", at in 0usize..200) {
        let at = (0..=text.len()).rev().find(|&place| place <= at && text.is_char_boundary(place)).unwrap_or(0);
        let source = Source::of_text(text.as_str());
        let is_in = |range: &std::ops::Range<usize>| text.get(range.clone()).is_some();
        proptest::prop_assert!(hover(&source, at).is_none_or(|hover| is_in(&hover.range)));
        proptest::prop_assert!(definition(&source, at).is_none_or(|range| is_in(&range)));
        proptest::prop_assert!(references(&source, at).iter().all(is_in));
        proptest::prop_assert!(complete(&source, at).iter().all(|found| is_in(&found.range)));
        proptest::prop_assert!(outline(&source).iter().all(|symbol| is_in(&symbol.whole) && is_in(&symbol.selected)));
    }
}

/// An object gets another index wherever it is named; entries of other objects stay.
#[test]
fn an_object_gets_another_index() {
    let source = Source::of_text(TEXT);
    let renamed = |what: &str, more, index| {
        let edits = rename(&source, at(what, more), index)?;
        let mut text = TEXT.to_owned();
        for (range, digits) in edits.into_iter().rev() {
            text.replace_range(range, &digits);
        }
        Some(text)
    };
    let identity = renamed("[1018sub1]", 3, 0x2018).unwrap();
    assert_eq!(identity, TEXT.replace("1018", "2018"));
    let mapped = renamed("0x60040020", 5, 0x6104).unwrap();
    assert_eq!(mapped, TEXT.replace("6004", "6104"));
    assert_eq!(renamed("0x60040020", 5, 0x1018), None, "there is an object with this index");
    assert_eq!(renamed("VendorName", 2, 0x2018), None);
    assert_eq!(index_at(&source, at("1=0x1018", 5)), Some(at("1=0x1018", 4)..at("1=0x1018", 8)));
}

/// What belongs to an object moves with it: lists of values and names, and links to it.
#[test]
fn what_stands_beside_an_object_moves_with_it() {
    const LINKED: &str = "[2000]\nCompactSubObj=3\n[2000Value]\nNrOfEntries=1\n1=5\n[2000Name]\nNrOfEntries=0\n\
                          [2001]\nParameterName=Other\n[2001ObjectLinks]\nObjectLinks=1\n1=0x2000\n";
    let source = Source::of_text(LINKED);
    let mut text = LINKED.to_owned();
    for (range, digits) in rename(&source, LINKED.find("Value").unwrap(), 0x2F00).unwrap().into_iter().rev() {
        text.replace_range(range, &digits);
    }
    assert_eq!(text, LINKED.replace("2000", "2F00"));
}
