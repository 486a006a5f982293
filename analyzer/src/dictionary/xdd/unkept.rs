//! What stands in an XDD or XDC that a description does not hold.

use std::collections::BTreeMap;

use super::elements::{self, Element};
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::eds::decode_text;
use crate::dictionary::loss::{Loss, Losses};
use crate::dictionary::problem::Problems;

/// The elements that are read, each with the attributes that are; objects also have [`OF_OBJECTS`].
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

/// The attributes that objects and sub-objects have alike.
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

/// Elements that only hold others, and the data types of parameters.
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

/// The same in each file.
const OF_THE_FORMAT: &str = "ProfileHeader";

/// Everything that is in the file and not in the description that was read from it, each kind of thing once.
pub(in crate::dictionary) fn unkept(description: &DeviceDescription, bytes: &[u8]) -> Vec<Loss> {
    let text = decode_text(bytes, &mut Problems::default());
    let elements = elements::read(&text, &mut Problems::default());
    let mut seen: BTreeMap<String, (u32, String, usize)> = BTreeMap::new();
    let mut note = |place: String, line: u32, text: &str| {
        seen.entry(place).or_insert_with(|| (line, text.to_owned(), 0)).2 += 1;
    };
    let mut rest = elements.all();
    while let Some((element, after)) = rest.split_first() {
        rest = after;
        if let Some((_, read)) = READ.iter().find(|(name, _)| *name == element.name) {
            let is_object = matches!(element.name.as_str(), "CANopenObject" | "CANopenSubObject");
            for (attribute, value) in element.attributes() {
                let is_in = |names: &[&str]| names.iter().any(|name| name.eq_ignore_ascii_case(attribute));
                let is_read = is_in(read) || is_object && is_in(OF_OBJECTS);
                if !is_read && !value.trim().is_empty() {
                    note(format!("{} {attribute}", element.name), element.line, value);
                }
            }
            continue;
        }
        if AROUND.contains(&element.name.as_str()) {
            continue;
        }
        // An element that is not known, with everything in it.
        if element.name != OF_THE_FORMAT && element.has_content(after) {
            note(element.name.clone(), element.line, element.text.trim());
        }
        rest = element.after(after);
    }
    let mut losses = Losses::default();
    losses.unread(&description.problems);
    for (place, (line, text, times)) in seen {
        losses.unkept(line, place, &text, times);
    }
    losses.0.sort_by_key(|loss| loss.line);
    losses.0
}

impl Element {
    /// Whether it says anything: an attribute, a text, or an element in it.
    fn has_content(&self, after: &[Self]) -> bool {
        !self.text.trim().is_empty() || self.attributes().next().is_some() || self.after(after).len() < after.len()
    }
}
