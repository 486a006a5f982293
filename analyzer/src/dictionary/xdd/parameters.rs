//! The application process: `parameter` elements, to which objects refer by `uniqueIDRef`.

use std::collections::HashMap;

use crate::dictionary::data_type::DataType;
use crate::dictionary::object::Access;
use crate::dictionary::source::{Section, Source};

/// A parameter. Values are texts until the data type of the object is known.
#[derive(Debug, Default)]
pub(super) struct Parameter<'a> {
    pub label: Option<&'a str>,
    pub data_type: Option<DataType>,
    pub access: Option<Access>,
    /// Whether the file says that an SDO can't access the parameter.
    pub is_out_of_reach: bool,
    pub default: Option<&'a str>,
    pub actual: Option<&'a str>,
    pub low: Option<&'a str>,
    pub high: Option<&'a str>,
    pub denotation: Option<&'a str>,
}

/// All parameters, by `uniqueID`.
pub(super) fn read<'s>(source: &'s Source<'_>) -> HashMap<&'s str, Parameter<'s>> {
    let mut parameters = HashMap::new();
    for element in source.named("parameter") {
        if let Some(id) = element.attribute("uniqueID") {
            parameters.entry(id).or_insert_with(|| parameter(element));
        }
    }
    parameters
}

fn parameter(element: Section<'_>) -> Parameter<'_> {
    let named = |name: &str| element.inside().find(|inside| inside.name() == name);
    let value = |name: &str| named(name).and_then(|element| element.attribute("value"));
    let text = |name: &str| named(name).map(Section::text).filter(|text| !text.is_empty());
    Parameter {
        label: text("label"),
        data_type: element.inside().find_map(|element| simple_type(element.name())),
        // The schema's default for a missing attribute.
        access: element.attribute("access").map_or(Some(Access::Ro), access),
        is_out_of_reach: element.attribute("access") == Some("noAccess"),
        default: value("defaultValue"),
        actual: value("actualValue"),
        low: value("minValue"),
        high: value("maxValue"),
        denotation: text("denotation"),
    }
}

/// The element names of IEC 61131-3 types.
fn simple_type(name: &str) -> Option<DataType> {
    Some(match name {
        "BOOL" => DataType::BOOLEAN,
        "SINT" => DataType::INTEGER8,
        "INT" => DataType::INTEGER16,
        "DINT" => DataType::INTEGER32,
        "LINT" => DataType::INTEGER64,
        "USINT" | "BYTE" | "CHAR" => DataType::UNSIGNED8,
        "UINT" | "WORD" => DataType::UNSIGNED16,
        "UDINT" | "DWORD" => DataType::UNSIGNED32,
        "ULINT" | "LWORD" => DataType::UNSIGNED64,
        "REAL" => DataType::REAL32,
        "LREAL" => DataType::REAL64,
        "STRING" => DataType::VISIBLE_STRING,
        "WSTRING" => DataType::UNICODE_STRING,
        "BITSTRING" => DataType::OCTET_STRING,
        _ => return None,
    })
}

fn access(name: &str) -> Option<Access> {
    Some(match name {
        "const" => Access::Const,
        "read" => Access::Ro,
        "write" => Access::Wo,
        "readWrite" => Access::Rw,
        "readWriteInput" => Access::Rwr,
        "readWriteOutput" => Access::Rww,
        _ => return None,
    })
}
