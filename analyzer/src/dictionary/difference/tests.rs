//! Each kind of change is made in a description and found.

use super::{Class, Difference, compare, kinds};
use crate::dictionary::DeviceDescription;
use std::collections::BTreeSet;

const EDS: &str = include_str!("../../../tests/difference/old.eds");
/// The sections that make the EDS a DCF.
const DCF: &str = "[DeviceComissioning]\nNodeID=5\nNodeName=Left\nBaudrate=250\nNetNumber=1\nNetworkName=Line\n\
                   CANopenManager=0\nLSS_SerialNumber=7\n[ConnectedModules]\nNrOfEntries=1\n1=1\n";

fn read(text: &str) -> DeviceDescription {
    DeviceDescription::read(text.as_bytes()).unwrap()
}

/// The differences found if `from` is replaced by `to` in the file.
fn found(old: &str, from: &str, to: &str) -> Vec<Difference> {
    assert!(old.contains(from), "{from}");
    compare(&read(old), &read(&old.replacen(from, to, 1)))
}

/// A change (old text, new text), and the expected differences: each with its kind, subject, old and new value.
type Change = (&'static str, &'static str, &'static [&'static str]);

#[rustfmt::skip]
const CHANGES: &[Change] = &[
    ("[2000]\nParameterName=Setting\nObjectType=0x7\nDataType=0x0006\nLowLimit=0\nHighLimit=1000\nAccessType=rw\nDefaultValue=5\nPDOMapping=1\n", "",
        &["object/removed 2000h VAR -> -"]),
    ("[2001]", "[2FF0]\nParameterName=New\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\nPDOMapping=0\n[2001]",
        &["object/added 2FF0h - -> VAR"]),
    ("[2002]\nParameterName=Table\nObjectType=0x8", "[2002]\nParameterName=Table\nObjectType=0x9", &["object/structure 2002h ARRAY -> RECORD"]),
    ("[2001]\nParameterName=State\nObjectType=0x7", "[2001]\nParameterName=State\nObjectType=0x2", &["object/code 2001h VAR -> DOMAIN"]),
    ("[2001]\nParameterName=State", "[2001]\nParameterName=Status", &["object/name 2001h \"State\" -> \"Status\""]),
    ("[2002sub2]\nParameterName=Second\nObjectType=0x7\nDataType=0x0003\nAccessType=rw\nPDOMapping=0\n", "", &["sub-index/removed 2002h:02 INTEGER16 -> -"]),
    ("[2002sub2]", "[2002sub3]\nParameterName=Third\nObjectType=0x7\nDataType=0x0003\nAccessType=rw\nPDOMapping=0\n[2002sub2]",
        &["sub-index/added 2002h:03 - -> INTEGER16"]),
    ("[2002sub2]\nParameterName=Second\nObjectType=0x7\nDataType=0x0003", "[2002sub2]\nParameterName=Second\nObjectType=0x7\nDataType=0x0004",
        &["entry/data-type 2002h:02 INTEGER16 -> INTEGER32"]),
    ("DataType=0x0006\nLowLimit=0\nHighLimit=1000\nAccessType=rw", "DataType=0x0006\nLowLimit=0\nHighLimit=1000\nAccessType=ro",
        &["entry/not-writable 2000h:00 rw -> ro", "entry/no-rpdo 2000h:00 1 -> 0"]),
    ("HighLimit=1000\nAccessType=rw", "HighLimit=1000\nAccessType=wo",
        &["entry/not-readable 2000h:00 rw -> wo", "entry/no-tpdo 2000h:00 1 -> 0"]),
    ("DataType=0x0005\nAccessType=ro\nPDOMapping=1", "DataType=0x0005\nAccessType=rwr\nPDOMapping=1", &["entry/more-access 2001h:00 ro -> rwr"]),
    ("DataType=0x0005\nAccessType=ro\nPDOMapping=1", "DataType=0x0005\nAccessType=const\nPDOMapping=1", &["entry/constant 2001h:00 ro -> const"]),
    ("DataType=0x0007\nAccessType=const", "DataType=0x0007\nAccessType=ro", &["entry/not-constant 1000h:00 const -> ro"]),
    ("DataType=0x0005\nAccessType=ro\nPDOMapping=1", "DataType=0x0005\nAccessType=ro\nPDOMapping=0", &["entry/no-tpdo 2001h:00 1 -> 0"]),
    ("DataType=0x0007\nAccessType=const\nDefaultValue=0x196\nPDOMapping=0", "DataType=0x0007\nAccessType=const\nDefaultValue=0x196\nPDOMapping=1",
        &["entry/more-pdo 1000h:00 0 -> 1"]),
    ("[2002sub2]\nParameterName=Second", "[2002sub2]\nParameterName=Other", &["entry/name 2002h:02 \"Second\" -> \"Other\""]),
    ("ObjFlags=0", "ObjFlags=1", &["entry/flags 2001h:00 0 -> 1"]),
    ("Denotation=door", "Denotation=gate", &["entry/denotation 2001h:00 \"door\" -> \"gate\""]),
    ("HighLimit=1000", "HighLimit=100", &["limit/narrower 2000h:00 1000 -> 100"]),
    ("HighLimit=1000", "", &["limit/wider 2000h:00 1000 -> -"]),
    // The limit is that of the data type anyway.
    ("LowLimit=0\n", "", &[]),
    ("LowLimit=0\n", "LowLimit=1\n", &["limit/narrower 2000h:00 0 -> 1"]),
    ("HighLimit=1000", "HighLimit=$NODEID+5", &["limit/changed 2000h:00 1000 -> $NODEID+5h"]),
    ("DefaultValue=$NODEID+0x80", "DefaultValue=$NODEID+0xC0", &["default/cob-id 1014h:00 $NODEID+80h -> $NODEID+C0h"]),
    ("DefaultValue=0x196", "DefaultValue=0x20196", &["default/device-type 1000h:00 406 -> 131478 (20196h)"]),
    ("DefaultValue=0x11", "DefaultValue=0x12", &["default/identity 1018h:01 17 -> 18"]),
    ("DefaultValue=5", "DefaultValue=6", &["default/changed 2000h:00 5 -> 6"]),
    ("ParameterValue=1", "ParameterValue=2", &["configured/changed 2001h:00 1 -> 2"]),
    ("ParameterValue=0x85", "ParameterValue=0x86", &["configured/cob-id 1014h:00 00000085h -> 00000086h"]),
    ("DefaultValue=0x20010008", "DefaultValue=0x20000010", &["pdo/layout TPDO 1 2001h:00 (8 bits) -> 2000h:00 (16 bits)"]),
    ("DefaultValue=$NODEID+0x180", "DefaultValue=$NODEID+0x280", &["pdo/cob-id TPDO 1 $NODEID+180h -> $NODEID+280h"]),
    ("DefaultValue=$NODEID+0x180", "DefaultValue=$NODEID+0x80000180", &["pdo/switched-off TPDO 1 $NODEID+180h -> $NODEID+80000180h"]),
    ("DefaultValue=0x80000000", "DefaultValue=0x285", &["pdo/switched-on TPDO 2 80000000h -> 00000285h"]),
    ("DefaultValue=0x80000000", "DefaultValue=0x80000285", &["default/changed 1801h:01 80000000h -> 80000285h"]),
    ("DefaultValue=$NODEID+0x180", "DefaultValue=$NODEID+0x40000180", &["pdo/remote-frames TPDO 1 $NODEID+180h -> $NODEID+40000180h"]),
    ("[2002sub0]\nParameterName=Highest sub-index supported\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\nDefaultValue=2",
        "[2002sub0]\nParameterName=Highest sub-index supported\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\nDefaultValue=3", &["default/count 2002h:00 2 -> 3"]),
    // The new type has other limits, which are reported as a change of the type.
    ("DataType=0x0006\nLowLimit=0\nHighLimit=1000", "DataType=0x0008\nLowLimit=0\nHighLimit=1000", &["entry/data-type 2000h:00 UNSIGNED16 -> REAL32", "default/changed 2000h:00 5 -> 5"]),
    ("DefaultValue=255", "DefaultValue=1", &["pdo/transmission 1800h:02 255 -> 1"]),
    ("VendorNumber=17", "VendorNumber=18", &["device/identity VendorNumber 00000011h -> 00000012h"]),
    ("RevisionNumber=3", "RevisionNumber=4", &["device/revision RevisionNumber 00000003h -> 00000004h"]),
    ("RevisionNumber=3\n", "", &["device/untold RevisionNumber 00000003h -> -"]),
    ("ProductName=Product", "ProductName=Other", &["device/name ProductName \"Product\" -> \"Other\""]),
    ("BaudRate_125=1", "BaudRate_500=1", &["device/bit-rate-gone BaudRate 125 kbit/s -> -", "device/bit-rate-added BaudRate - -> 500 kbit/s"]),
    ("NrOfTXPDO=2", "NrOfTXPDO=1", &["device/fewer-pdos NrOfTXPDO 2 -> 1"]),
    ("NrOfRXPDO=0", "NrOfRXPDO=1", &["device/more-pdos NrOfRXPDO 0 -> 1"]),
    ("Granularity=8", "Granularity=0", &["device/coarser-mapping Granularity 8 -> 0"]),
    ("Granularity=8", "Granularity=1", &["device/finer-mapping Granularity 8 -> 1"]),
    ("LSS_Supported=1", "LSS_Supported=0", &["device/no-lss LSS_Supported 1 -> 0"]),
    ("SimpleBootUpSlave=1", "SimpleBootUpSlave=0", &["device/feature-gone SimpleBootUpSlave 1 -> 0"]),
    ("GroupMessaging=0", "GroupMessaging=1", &["device/feature-added GroupMessaging 0 -> 1"]),
    ("Dummy0005=1", "Dummy0006=1", &["device/dummy-gone DummyUsage UNSIGNED8 -> -", "device/dummy-added DummyUsage - -> UNSIGNED16"]),
    ("NodeID=5", "NodeID=6", &["commissioning/address NodeID 5 -> 6"]),
    ("NodeName=Left", "NodeName=Right", &["commissioning/network NodeName \"Left\" -> \"Right\""]),
    ("ProductName=Inputs", "ProductName=Outputs", &["module/product module 1 \"Inputs\" -> \"Outputs\""]),
    ("[M1SubExt6000]\nParameterName=Input", "[M1SubExt6000]\nParameterName=Inputs", &["module/content module 1 \"Inputs\" -> \"Inputs\""]),
    ("[M2ModuleInfo]\nProductName=Counters\nOrderCode=2\n", "", &["module/removed module 2 \"Counters\" -> -"]),
    ("[M2ModuleInfo]", "[M3ModuleInfo]\nProductName=Relays\n[M2ModuleInfo]", &["module/added module 3 - -> \"Relays\""]),
    ("1=1\n", "1=2\n", &["module/connected ConnectedModules \"1\" -> \"2\""]),
    ("FileRevision=0", "FileRevision=1", &["file/version FileRevision \"0\" -> \"1\""]),
];

fn words(difference: &Difference) -> String {
    let fact = |fact: &Option<super::Fact>| fact.as_ref().map_or_else(|| "-".to_owned(), ToString::to_string);
    let Difference { kind, subject, before, after, .. } = difference;
    format!("{} {subject} {} -> {}", kind.id, fact(before), fact(after))
}

#[test]
fn every_kind_of_change_is_found_and_nothing_else() {
    let old = format!("{EDS}{DCF}");
    let mut seen = BTreeSet::new();
    for (from, to, expected) in CHANGES {
        let mut found: Vec<String> = found(&old, from, to).iter().map(words).collect();
        let same = "file/same-version FileVersion \"1\" -> \"1\"";
        found.retain(|words| words != same);
        assert_eq!(&found, expected, "{from} -> {to}");
        seen.extend(found.iter().filter_map(|words| words.split(' ').next().map(str::to_owned)));
    }
    seen.insert("file/same-version".to_owned());
    let all: BTreeSet<String> = kinds().map(|kind| kind.id.to_owned()).collect();
    assert_eq!(seen, all);
}

#[test]
fn every_kind_says_what_changed_and_what_follows() {
    let mut ids = BTreeSet::new();
    for kind in kinds() {
        assert!(ids.insert(kind.id), "{} twice", kind.id);
        assert!(kind.title().len() > 10 && !kind.title().ends_with('.'), "{}", kind.id);
        assert!(kind.why().ends_with('.') && kind.why().len() > 20, "{}", kind.id);
    }
}

#[test]
fn what_is_the_same_has_no_difference() {
    let old = format!("{EDS}{DCF}");
    assert_eq!(compare(&read(&old), &read(&old)), []);
    // Line ends, case, forms of numbers and the order of sections have no meaning.
    let (head, modules) = EDS.split_once("[SupportedModules]").unwrap();
    let moved = format!("; moved\n[SupportedModules]{modules}\n{head}{DCF}");
    let moved = moved.replace("HighLimit=1000", "highlimit=0x3E8").replace("[2000]", "[0x2000]");
    assert_eq!(compare(&read(&old), &read(&moved)), []);
}

#[test]
fn the_same_version_is_told_where_something_matters() {
    let version = |found: Vec<Difference>| found.iter().any(|difference| difference.kind.id == "file/same-version");
    assert!(version(found(EDS, "DefaultValue=5", "DefaultValue=6")));
    assert!(!version(found(EDS, "ProductName=Product", "ProductName=Other")));
    let new = EDS.replace("DefaultValue=5", "DefaultValue=6").replace("FileRevision=0", "FileRevision=1");
    assert!(!version(compare(&read(EDS), &read(&new))));
}

#[test]
fn what_an_object_loses_is_told_once() {
    let found = found(EDS, "[2002]\nParameterName=Table\nObjectType=0x8\nSubNumber=3\n", "");
    let kinds: Vec<&str> = found.iter().map(|difference| difference.kind.id).collect();
    assert_eq!(kinds, ["object/structure", "object/name", "file/same-version"], "a table without its head is a record");
    assert_eq!(found.iter().map(|difference| difference.kind.class).max(), Some(Class::Notable));
}
