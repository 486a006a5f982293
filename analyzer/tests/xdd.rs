//! Device descriptions in XML (CiA 311), in the two forms that tools write: with all attributes at the object, or with
//! references to parameters of the application process.

// `cfg(test)` changes nothing here, but tells clippy that a test may unwrap.
#![cfg(test)]

use canvass_analyzer::dictionary::eds::DescriptionError;
use canvass_analyzer::dictionary::source::Source;
use canvass_analyzer::dictionary::{
    Access, DataType, DeviceDescription, EdsProblem, Setting, Severity, Value, check, xdd,
};
use canvass_analyzer::{Index, Multiplexer, NodeId};
use proptest::prelude::*;

#[path = "eds/harmless.rs"]
mod harmless;

/// A description as motor tools write it: attributes at the object, `actualValue`, commissioning with node-ID.
const ATTRIBUTES: &str = include_str!("xdd/attributes.xdc");
/// A description as object dictionary editors write it: `uniqueIDRef` and parameters.
const PARAMETERS: &str = include_str!("xdd/parameters.xdd");

fn read(text: &str) -> Result<DeviceDescription, DescriptionError> {
    DeviceDescription::read(text.as_bytes())
}

fn shown(problems: &[EdsProblem]) -> Vec<String> {
    problems.iter().map(ToString::to_string).collect()
}

#[test]
fn attributes_at_the_objects() {
    let description = read(ATTRIBUTES).unwrap();
    assert_eq!(shown(&description.problems), [] as [&str; 0]);
    assert_eq!(description.device.vendor_name, "Vendor & Söhne");
    assert_eq!((description.device.vendor_number, description.device.product_number), (Some(0x147), Some(48)));
    assert_eq!(description.device.bit_rates, [125, 250, 1000]);
    assert_eq!((description.device.rpdos, description.device.tpdos, description.device.granularity), (1, 2, 8));
    assert!(description.device.lss_supported && description.device.simple_boot_up_slave);
    assert_eq!((description.file.name.as_str(), description.file.version.as_str()), ("attributes.xdc", "1"));
    assert_eq!((description.dummy_usage.get(&5), description.dummy_usage.get(&6)), (Some(&true), Some(&false)));

    let commissioning = description.commissioning.unwrap();
    assert_eq!((commissioning.node_id, commissioning.bit_rate), (NodeId::new(5), Some(250)));

    let entry = |index, sub| description.dictionary.entry(Multiplexer::new(index, sub)).unwrap();
    assert_eq!(entry(0x1000, 0).default, Some(Setting::Fixed(Value::Unsigned(0x0002_0196))));
    assert_eq!(entry(0x1008, 0).start_value(NodeId::MIN), Some(Value::VisibleString(b"Drive <1>".to_vec())));
    assert_eq!(entry(0x1800, 1).default, Some(Setting::NodeIdPlus(0x180)));
    assert_eq!(entry(0x1800, 2).configured, Some(Setting::Fixed(Value::Unsigned(1))));
    assert_eq!(
        (entry(0x1800, 2).low_limit.clone(), entry(0x1800, 2).flags.0),
        (Some(Setting::Fixed(Value::Unsigned(0))), 3)
    );
    assert_eq!((entry(0x6040, 0).access, entry(0x6041, 0).access), (Access::Rww, Access::Ro));
    assert!(entry(0x6041, 0).pdo_mappable && !entry(0x1000, 0).pdo_mappable);
    assert_eq!(entry(0x6041, 0).denotation.as_deref(), Some("status of the lift"));
}

/// Published files differ from the schema: EdsDcfNet writes `nodeID` instead of `NodeID`, and bit rates have units.
#[test]
fn attributes_are_the_same_in_any_case() {
    let commissioning = r#"<deviceCommissioning nodeID="5" nodeName="MinimalDevice" actualBaudRate="500 Kbps""#;
    let read_with = |from: &str, to: &str| {
        assert!(ATTRIBUTES.contains(from), "{from}");
        read(&ATTRIBUTES.replacen(from, to, 1)).unwrap()
    };
    let known = ATTRIBUTES.lines().find(|line| line.contains("<deviceCommissioning")).unwrap().trim();
    for name in ["nodeID", "NodeID", "NodeId"] {
        let written = format!("{} />", commissioning.replace("nodeID", name));
        let found = read_with(known, &written).commissioning.unwrap();
        assert_eq!(
            (found.node_id, found.bit_rate, found.node_name.as_str()),
            (NodeId::new(5), Some(500), "MinimalDevice")
        );
    }
    for (rate, expected) in [("1 Mbps", 1000), ("1000 Kbps", 1000), ("20kbps", 20), ("50", 50)] {
        let found = read_with(known, &format!(r#"<deviceCommissioning NodeID="5" actualBaudRate="{rate}"/>"#));
        assert_eq!(found.commissioning.unwrap().bit_rate, Some(expected), "{rate}");
    }
    let dummies = read_with("Dummy0005=1", "dummy0005 = 1").dummy_usage;
    assert_eq!(dummies.get(&5), Some(&true));
    let unkept = read_with(known, &format!("{commissioning} />"));
    let text = ATTRIBUTES.replacen(known, &format!("{commissioning} />"), 1);
    assert!(!unkept.unkept(&Source::of_text(text)).iter().any(|loss| loss.to_string().contains("nodeID")));
}

/// Attributes in the form of the schema of CiA 311.
#[test]
fn the_schema_has_what_is_written() {
    let (text, _) = xdd::write(&read(ATTRIBUTES).unwrap());
    assert!(text.contains(r#"<deviceCommissioning NodeID="5""#), "{text}");
    let bodies: Vec<&str> = text.lines().filter(|line| line.contains("<ProfileBody ")).collect();
    assert_eq!(bodies.len(), 2);
    assert!(
        bodies.iter().all(|body| body.contains(r#"formatName="CANopen" formatVersion="1.0" fileName="#)),
        "{bodies:?}"
    );
}

#[test]
fn references_to_parameters() {
    let description = read(PARAMETERS).unwrap();
    assert_eq!(shown(&description.problems), [] as [&str; 0]);
    assert!(!description.is_configuration());
    let entry = |index, sub| description.dictionary.entry(Multiplexer::new(index, sub)).unwrap();
    assert_eq!((entry(0x1001, 0).data_type, entry(0x1001, 0).access), (DataType::UNSIGNED8, Access::Ro));
    assert_eq!(entry(0x1018, 1).default, Some(Setting::Fixed(Value::Unsigned(0x13))));
    let setting = entry(0x2000, 0);
    assert_eq!(
        (setting.data_type, setting.access, setting.name.as_str()),
        (DataType::INTEGER16, Access::Rw, "Setting")
    );
    assert_eq!(setting.low_limit, Some(Setting::Fixed(Value::Integer(-5))));
    assert_eq!(setting.high_limit, Some(Setting::Fixed(Value::Integer(5))));
    assert_eq!(description.lists.manufacturer.len(), 1);
    assert_eq!(
        description.lists.mandatory.iter().map(|(index, _)| *index).collect::<Vec<_>>(),
        [0x1000, 0x1001, 0x1018].map(Index)
    );
}

#[test]
fn problems_name_line_element_and_attribute() {
    let text = ATTRIBUTES
        .replacen("index=\"1001\"", "index=\"0x1001\"", 1)
        .replacen("dataType=\"0009\"", "dataType=\"nine\"", 1)
        .replacen("defaultValue=\"255\"", "defaultValue=\"0x1FF\"", 1)
        .replacen("subNumber=\"3\"", "subNumber=\"4\"", 1)
        .replacen("index=\"6041\"", "index=\"6040\"", 1);
    let description = read(&text).unwrap();
    let line = |part: &str| 1 + text.lines().position(|line| line.contains(part)).unwrap();
    let start = |part| format!("line {}, ", line(part));
    let expected = [
        (start("0x1001"), "[CANopenObject] index"),
        (start("\"nine\""), "[CANopenObject] dataType"),
        (start("\"nine\""), "[CANopenObject] dataType"),
        (start("subNumber=\"4\""), "[CANopenObject] subNumber"),
        (start("0x1FF"), "[CANopenSubObject] defaultValue"),
        (format!("line {}, ", line("index=\"6040\"") + 1), "[CANopenObject] index"),
    ];
    let found = shown(&description.problems);
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    for (found, (line, place)) in found.iter().zip(expected) {
        assert!(found.starts_with(&format!("{line}{place}")), "{found} is not at {line}{place}");
    }
}

/// For each rule that an object in XML breaks, the text that the finding marks.
fn marked(object: &str) -> Vec<(&'static str, String)> {
    let text = format!("<CANopenObjectList><a note='1 > 0'/>{object}</CANopenObjectList>");
    let checked = check::check(text.as_bytes(), None).unwrap();
    let findings = checked.findings.iter().filter(|finding| finding.problem.rule.id.starts_with("xdd/"));
    findings.map(|finding| (finding.problem.rule.id, text[finding.span.clone()].to_owned())).collect()
}

#[test]
fn an_attribute_is_marked_exactly() {
    let one = |rule, text: &str| vec![(rule, text.to_owned())];
    let object = "<CANopenObject name='Speed' index='2000' objectType='7' dataType='0006' accessType='rw'/>";
    assert_eq!(marked(object), []);
    let damaged = object.replace("'0006'", "'0xZ'");
    assert_eq!(marked(&damaged)[..1], one("xdd/number/prefix", "0xZ"));
    // The attribute follows a `>` in an earlier value, and stands in another line.
    let damaged = object.replace("Speed", "n > 1000").replace("'7'", "'3'").replace("index", "\n\tindex");
    assert_eq!(marked(&damaged), one("xdd/object/object-type", "3"));
    // The value of another attribute looks like this attribute, and must not be marked.
    let damaged = object.replace("Speed", " accessType=\"rw\"").replace("'rw'", "\"maybe\"");
    assert_eq!(marked(&damaged), one("xdd/object/access", "maybe"));
    // The second of two attributes is marked, and not an attribute of an element before it.
    let damaged = object.replace("/>", " name='Other'/>");
    assert_eq!(marked(&damaged), one("xdd/element/attribute-twice", "Other"));
    assert_eq!(marked(&object.repeat(2)), one("xdd/object/twice", "2000"));
    // A missing attribute marks the start tag of the object itself.
    let damaged = object.replace(" accessType='rw'", "");
    assert_eq!(marked(&damaged), one("xdd/object/access-missing", &damaged));
}

#[test]
fn a_file_that_breaks_off_is_read_up_to_there() {
    let (text, _) = ATTRIBUTES.split_at(ATTRIBUTES.find("index=\"6040\"").unwrap());
    let description = read(text).unwrap();
    assert!(description.dictionary.object(Index(0x1800)).is_some());
    assert_eq!(description.problems.last().map(|problem| problem.severity()), Some(Severity::Error));
}

#[test]
fn what_is_no_canopen_description_is_refused() {
    let powerlink = r#"<?xml version="1.0"?><ISO15745ProfileContainer><ISO15745Profile>
        <ProfileBody xsi:type="ProfileBody_CommunicationNetwork_Powerlink"/></ISO15745Profile></ISO15745ProfileContainer>"#;
    let found = "ProfileBody_CommunicationNetwork_Powerlink".to_owned();
    assert_eq!(DeviceDescription::read(powerlink.as_bytes()).unwrap_err(), DescriptionError::NotCanopen { found });
    assert!(DeviceDescription::read(b"<html>").is_err());
}

#[test]
fn what_breaks_off_before_the_first_object_says_where() {
    let text = "<ISO15745ProfileContainer>\n<ProfileHeader>\n</Header>\n</ISO15745ProfileContainer>";
    let error = DeviceDescription::read(text.as_bytes()).unwrap_err();
    assert!(matches!(&error, DescriptionError::Malformed { line: 3, found } if found.contains("Header")), "{error}");
}

#[test]
fn neither_entities_nor_depth_nor_width_do_harm() {
    let bomb = r#"<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>
        <CANopenObjectList><CANopenObject index="1000" name="&b;" objectType="7" dataType="0007" accessType="ro"/>
        </CANopenObjectList>"#;
    let description = read(bomb).unwrap();
    assert_eq!(description.dictionary.object(Index(0x1000)).unwrap().name, "");
    let deep = format!("<CANopenObjectList>{}", "<CANopenObject index=\"1000\">".repeat(100_000));
    assert!(!read(&deep).unwrap().problems.is_empty());
    let wide = format!("<CANopenObjectList {}/>", "a=\"\" ".repeat(100_000));
    assert!(!read(&wide).unwrap().problems.is_empty());
}

fn reads(bytes: &[u8]) -> Result<(), TestCaseError> {
    xdd::read(bytes).map_or(Ok(()), |description| harmless::check(&description))
}

proptest! {
    #[test]
    fn random_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        reads(&bytes)?;
    }

    #[test]
    fn damaged_files_do_no_harm(
        file in prop::sample::select(vec![ATTRIBUTES, PARAMETERS]),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3), 1..20),
    ) {
        let mut bytes = file.as_bytes().to_vec();
        for (place, byte, how) in damage {
            let place = place.index(bytes.len());
            match how {
                0 => bytes[place] = byte,
                1 => bytes.insert(place, byte),
                _ => drop(bytes.drain(place..(place + usize::from(byte)).min(bytes.len() - 1))),
            }
        }
        reads(&bytes)?;
    }
}
