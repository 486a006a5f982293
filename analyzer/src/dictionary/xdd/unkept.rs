//! Reports the elements and attributes of an XDD or XDC that a description in memory does not keep.

use std::collections::BTreeMap;

use crate::dictionary::description::DeviceDescription;
use crate::dictionary::loss::{Loss, Losses};
use crate::dictionary::place::SectionId;
use crate::dictionary::source::Source;

/// The elements and attributes that the reader keeps; objects also have [`OF_OBJECTS`].
const READ: &[(&str, &[&str])] = &[
    (
        "ProfileBody",
        &[
            "type",
            "formatName",
            "formatVersion",
            "fileName",
            "fileCreator",
            "fileCreationDate",
            "fileCreationTime",
            "fileModificationDate",
            "fileModificationTime",
            "fileModifiedBy",
            "fileVersion",
            "supportedLanguages",
        ],
    ),
    ("vendorName", &["readOnly"]),
    ("vendorID", &["readOnly"]),
    ("productName", &["readOnly"]),
    ("productID", &["readOnly"]),
    ("orderNumber", &["readOnly"]),
    ("parameter", &["uniqueID", "access"]),
    ("label", &["lang"]),
    ("denotation", &[]),
    ("dataTypeIDRef", &["uniqueIDRef"]),
    ("defaultValue", &["value"]),
    ("actualValue", &["value"]),
    ("minValue", &["value"]),
    ("maxValue", &["value"]),
    ("CANopenObjectList", &["mandatoryObjects", "optionalObjects", "manufacturerObjects"]),
    ("CANopenObject", &["index", "subNumber"]),
    ("CANopenSubObject", &["subIndex"]),
    ("dummy", &["entry"]),
    ("supportedBaudRate", &["value"]),
    (
        "CANopenGeneralFeatures",
        &[
            "groupMessaging",
            "dynamicChannels",
            "granularity",
            "nrOfRxPDO",
            "nrOfTxPDO",
            "bootUpSlave",
            "layerSettingServiceSlave",
        ],
    ),
    ("CANopenMasterFeatures", &["bootUpMaster"]),
    (
        "deviceCommissioning",
        &["NodeID", "nodeName", "actualBaudRate", "networkNumber", "networkName", "CANopenManager"],
    ),
];

/// The attributes that objects and sub-objects share.
const OF_OBJECTS: &[&str] = &[
    "name",
    "objectType",
    "dataType",
    "lowLimit",
    "highLimit",
    "accessType",
    "defaultValue",
    "PDOmapping",
    "objFlags",
    "actualValue",
    "denotation",
    "uniqueIDRef",
];

/// Elements that only contain others, and the data types of parameters.
const AROUND: &[&str] = &[
    "ISO15745ProfileContainer",
    "ISO15745Profile",
    "DeviceIdentity",
    "ApplicationProcess",
    "parameterList",
    "allowedValues",
    "range",
    "ApplicationLayers",
    "identity",
    "dummyUsage",
    "TransportLayers",
    "PhysicalLayer",
    "baudRate",
    "NetworkManagement",
    "BOOL",
    "SINT",
    "INT",
    "DINT",
    "LINT",
    "USINT",
    "BYTE",
    "CHAR",
    "UINT",
    "WORD",
    "UDINT",
    "DWORD",
    "ULINT",
    "LWORD",
    "REAL",
    "LREAL",
    "STRING",
    "WSTRING",
    "BITSTRING",
];

/// The element with data about the format, which is the same in each file.
const OF_THE_FORMAT: &str = "ProfileHeader";

/// All parts of the file that the parsed description does not keep; each kind of part once.
pub(in crate::dictionary) fn unkept(description: &DeviceDescription, source: &Source<'_>) -> Vec<Loss> {
    let mut seen: BTreeMap<String, (u32, String, usize)> = BTreeMap::new();
    let mut note = |place: String, line: u32, text: &str| {
        seen.entry(place).or_insert_with(|| (line, text.to_owned(), 0)).2 += 1;
    };
    let mut next = SectionId(0);
    for element in source.elements() {
        if element.id < next {
            continue;
        }
        let name = element.name();
        if let Some((_, read)) = READ.iter().find(|(known, _)| *known == name) {
            let is_object = matches!(name, "CANopenObject" | "CANopenSubObject");
            for attribute in element.fields() {
                let is_in = |names: &[&str]| names.iter().any(|name| name.eq_ignore_ascii_case(attribute.name()));
                let is_read = is_in(read) || is_object && is_in(OF_OBJECTS);
                if !is_read && !attribute.value().trim().is_empty() {
                    note(format!("{name} {}", attribute.name()), element.line(), attribute.value());
                }
            }
            continue;
        }
        if AROUND.contains(&name) {
            continue;
        }
        // An unknown element is reported with its content.
        if name != OF_THE_FORMAT && element.has_content() {
            note(name.to_owned(), element.line(), element.text());
        }
        next = element.next();
    }
    let mut losses = Losses::default();
    losses.unread(&description.problems);
    for (place, (line, text, times)) in seen {
        losses.unkept(line, place, &text, times);
    }
    losses.0.sort_by_key(|loss| loss.line);
    losses.0
}
