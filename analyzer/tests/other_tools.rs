//! Descriptions as the tools of other makers write them, within CiA 306 and CiA 311.

// `cfg(test)` changes nothing here, but tells clippy that a test may unwrap.
#![cfg(test)]

use canvass_analyzer::dictionary::{DeviceDescription, Severity, consistency};
use canvass_analyzer::{Index, Multiplexer};

const PLAIN: &str = include_str!("eds/plain.eds");
const PARAMETERS: &str = include_str!("xdd/parameters.xdd");

/// The problems after one replacement in a text, in its form and its meaning; without hints, and without the problems
/// of the text itself.
fn problems(text: &str, from: &str, to: &str) -> Vec<String> {
    assert!(text.contains(from), "{from}");
    let all = |text: &str| {
        let description = DeviceDescription::read(text.as_bytes()).unwrap();
        let found = description.problems.iter().cloned().chain(consistency::check(&description));
        let wrong = found.filter(|problem| problem.severity() != Severity::Hint);
        wrong.map(|problem| format!("[{}] {}: {}", problem.section, problem.field, problem.found)).collect::<Vec<_>>()
    };
    let known = all(text);
    all(&text.replacen(from, to, 1)).into_iter().filter(|problem| !known.contains(problem)).collect()
}

const NONE: [&str; 0] = [];

#[test]
fn an_hour_may_have_one_digit() {
    for time in ["4:49PM", "04:49PM", "9:00am"] {
        assert_eq!(problems(PLAIN, "CreationTime=09:00AM", &format!("CreationTime={time}")), NONE, "{time}");
    }
    for time in ["4:9PM", ":49PM", "16:49", "004:49PM", "4:49"] {
        let found = problems(PLAIN, "CreationTime=09:00AM", &format!("CreationTime={time}"));
        assert_eq!(found, [format!("[FileInfo] CreationTime: {time}")]);
    }
}

#[test]
fn the_keys_of_a_list_may_stand_in_any_order() {
    assert_eq!(problems(PLAIN, "1=0x1000\n2=0x1001", "2=0x1001\n1=0x1000"), NONE);
    let description = DeviceDescription::read(PLAIN.replace("1=0x1000\n2=0x1001", "2=0x1001\n1=0x1000").as_bytes());
    let listed: Vec<Index> = description.unwrap().lists.mandatory.iter().map(|(index, _)| *index).collect();
    assert_eq!(listed, [Index(0x1000), Index(0x1001)]);
    assert_eq!(problems(PLAIN, "1=0x1000\n2=0x1001", "3=0x1001\n1=0x1000"), ["[MandatoryObjects] 3: 3"]);
}

/// `[1A00Value]` maps one of eight entries; the other seven are unused.
#[test]
fn a_mapping_in_the_short_form_maps_what_its_values_name() {
    let object = |mapped: &str| {
        format!(
            "[OptionalObjects]\nSupportedObjects=2\n2=0x1A00\n1=0x1800\n\n[1A00]\nParameterName=TPDO 1 mapping\n\
             ObjectType=9\nDataType=0x0007\nAccessType=rw\nPDOMapping=0\nCompactSubObj=8\n\n\
             [1A00Value]\nNrOfEntries=1\n1={mapped}\n\n"
        )
    };
    let optional = "[OptionalObjects]\nSupportedObjects=1\n1=0x1800\n\n";
    let mappable = PLAIN.replacen(
        "DataType=0x0005\nAccessType=ro\nPDOMapping=0",
        "DataType=0x0005\nAccessType=ro\nPDOMapping=1",
        1,
    );
    assert_eq!(problems(&mappable, optional, &object("0x10010008")), NONE);
    let description =
        DeviceDescription::read(mappable.replacen(optional, &object("0x10010008"), 1).as_bytes()).unwrap();
    assert!(description.dictionary.entry(Multiplexer::new(0x1A00, 8)).is_ok());
    // The object that the entry names must exist.
    let found = problems(&mappable, optional, &object("0x70000010"));
    assert_eq!(found, ["[1A00sub1] DefaultValue: 7000h:00 with 16 bits"]);
}

#[test]
fn a_parameter_without_access_can_be_read() {
    let with = r#"<co:parameter uniqueID="UID_OBJ_1001" access="read">"#;
    assert_eq!(problems(PARAMETERS, with, r#"<co:parameter uniqueID="UID_OBJ_1001">"#), NONE);
    let found = problems(PARAMETERS, with, r#"<co:parameter uniqueID="UID_OBJ_1001" access="sometimes">"#);
    assert_eq!(found.len(), 1, "{found:?}");
}
