//! Reads the elements `CANopenObject` and `CANopenSubObject`.

use std::collections::HashMap;

use super::parameters::Parameter;
use crate::dictionary::data_type::DataType;
use crate::dictionary::eds::setting;
use crate::dictionary::limits;
use crate::dictionary::object::{Access, Entry, Object, ObjectCode, ObjectDictionary, ObjectFlags, Setting};
use crate::dictionary::problem::Problems;
use crate::dictionary::rules::xdd as rules;
use crate::dictionary::source::{Section, Source};
use crate::identity::{Index, SubIndex};

type Parameters<'a> = HashMap<&'a str, Parameter<'a>>;

/// All objects. If two have the same index, the first counts.
pub(super) fn read(source: &Source<'_>, parameters: &Parameters<'_>, problems: &mut Problems) -> ObjectDictionary {
    let mut dictionary = ObjectDictionary::default();
    for element in source.named("CANopenObject") {
        let Some(index) = hexadecimal(element, "index", 0xFFFF, problems) else { continue };
        if dictionary.object(Index(index as u16)).is_some() {
            report_second(element, "index", problems);
            continue;
        }
        let subs = element.inside().filter(|element| element.name() == "CANopenSubObject");
        dictionary.insert(object(index as u16, element, subs, parameters, problems));
    }
    dictionary
}

fn object<'a>(
    index: u16,
    element: Section<'_>,
    subs: impl Iterator<Item = Section<'a>>,
    parameters: &Parameters<'_>,
    problems: &mut Problems,
) -> Object {
    let code = object_code(element, problems);
    let mut object = Object::new(index, name(element, parameters), code);
    (object.line, object.section) = (element.line(), Some(element.id));
    let mut count = 0;
    for sub in subs {
        let Some(number) = hexadecimal(sub, "subIndex", 0xFF, problems) else { continue };
        count += 1;
        if object.entry(SubIndex(number as u8)).is_some() {
            report_second(sub, "subIndex", problems);
            continue;
        }
        object_code(sub, problems);
        object.insert(entry(number as u8, sub, parameters, problems));
    }
    if count == 0 && code.is_single() {
        object.insert(entry(0, element, parameters, problems));
    }
    let announced = element.attribute("subNumber").and_then(|number| number.parse().ok()).unwrap_or(0);
    if announced != count {
        let place = element.place_of_attribute("subNumber");
        let expected = "subNumber to be the number of sub-indexes";
        problems.report(place, &rules::SUB_NUMBER, expected, &format!("{count} sub-indexes"));
    }
    object
}

const NAMES: limits::Names =
    limits::Names { low: "lowLimit", high: "highLimit", default: "defaultValue", configured: "actualValue" };

fn report_second(element: Section<'_>, attribute: &str, problems: &mut Problems) {
    let found = element.attribute(attribute).unwrap_or_default();
    let expected = "an address once; the first counts";
    problems.report(element.place_of_attribute(attribute), &rules::TWICE, expected, found);
}

fn object_code(element: Section<'_>, problems: &mut Problems) -> ObjectCode {
    let code = element.attribute("objectType").and_then(|code| code.parse().ok()).map(ObjectCode);
    code.filter(|code| code.name().is_some()).unwrap_or_else(|| {
        let found = element.attribute("objectType").unwrap_or("none");
        problems.report(element.place_of_attribute("objectType"), &rules::OBJECT_TYPE, "0, 2, 5, 6, 7, 8 or 9", found);
        ObjectCode::VAR
    })
}

fn entry(sub: u8, element: Section<'_>, parameters: &Parameters<'_>, problems: &mut Problems) -> Entry {
    let reference = element.attribute("uniqueIDRef");
    let parameter = reference.and_then(|id| parameters.get(id));
    if let (Some(id), None) = (reference, parameter) {
        let expected = "the uniqueID of a parameter";
        problems.report(element.place_of_attribute("uniqueIDRef"), &rules::REFERENCE, expected, id);
    }
    let empty = Parameter::default();
    let parameter = parameter.unwrap_or(&empty);
    let data_type = match element.attribute("dataType") {
        Some(_) => hexadecimal(element, "dataType", 0xFFFF, problems).map(|index| DataType(index as u16)),
        None => parameter.data_type,
    };
    let data_type = data_type.unwrap_or_else(|| {
        let place = element.place_of_attribute("dataType");
        problems.report(place, &rules::DATA_TYPE_MISSING, "a data type", "none");
        DataType(0)
    });
    let mut entry = Entry::new(sub, name(element, parameters), data_type, access(element, parameter, problems));
    let mut value = |attribute: &str, other: Option<&str>| -> Option<Setting> {
        let text = element.attribute(attribute).or(other)?;
        setting(text, data_type, element.place_of_attribute(attribute), problems)
    };
    entry.default = value("defaultValue", parameter.default);
    entry.low_limit = value("lowLimit", parameter.low);
    entry.high_limit = value("highLimit", parameter.high);
    entry.configured = value("actualValue", parameter.actual);
    (entry.line, entry.section) = (element.line(), Some(element.id));
    entry.pdo_mappable = element.attribute("PDOmapping").is_some_and(|mapping| mapping != "no");
    entry.denotation = element.attribute("denotation").or(parameter.denotation).map(str::to_owned);
    if element.attribute("objFlags").is_some() {
        entry.flags = ObjectFlags(hexadecimal(element, "objFlags", u32::MAX, problems).unwrap_or(0));
    }
    if limits::is_all_ones(element.attribute(NAMES.high).or(parameter.high)) {
        limits::unwrap_high(&mut entry, element.place_of_attribute(NAMES.high), problems);
    }
    limits::check(&entry, &NAMES, |attribute| element.place_of_attribute(attribute), problems);
    entry
}

fn name(element: Section<'_>, parameters: &Parameters<'_>) -> String {
    let label = || parameters.get(element.attribute("uniqueIDRef")?)?.label;
    element.attribute("name").or_else(label).unwrap_or_default().to_owned()
}

/// The access type. A `rw` entry whose `PDOmapping` names one direction becomes rwr or rww.
fn access(element: Section<'_>, parameter: &Parameter<'_>, problems: &mut Problems) -> Access {
    let found = element.attribute("accessType");
    let access = match found {
        Some(name) => Access::from_name(name),
        // An entry without access by SDO is accessible by PDO.
        None if parameter.is_out_of_reach => match element.attribute("PDOmapping") {
            Some("RPDO") => Some(Access::Wo),
            _ => Some(Access::Ro),
        },
        None => parameter.access,
    };
    match (access, element.attribute("PDOmapping")) {
        (Some(Access::Rw), Some("TPDO")) => Access::Rwr,
        (Some(Access::Rw), Some("RPDO")) => Access::Rww,
        (Some(access), _) => access,
        (None, _) => {
            let expected = "const, ro, wo, rw, rwr or rww, here or in the parameter";
            let is_given = found.is_some() || element.attribute("uniqueIDRef").is_some();
            // A missing access type gets the schema's default, which is not reported as wrong.
            let rule = if is_given { &rules::ACCESS } else { &rules::ACCESS_DEFAULT };
            problems.report(element.place_of_attribute("accessType"), rule, expected, found.unwrap_or("none"));
            Access::Ro
        }
    }
}

/// Parses a number of type hexBinary: hexadecimal digits; a `0x` before them is reported.
fn hexadecimal(element: Section<'_>, attribute: &str, most: u32, problems: &mut Problems) -> Option<u32> {
    let text = element.attribute(attribute).unwrap_or_default();
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    if digits.is_some() {
        let expected = "hexadecimal digits without prefix";
        problems.report(element.place_of_attribute(attribute), &rules::PREFIX, expected, text);
    }
    let digits = digits.unwrap_or(text);
    let only_digits = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let number = if only_digits { u32::from_str_radix(digits, 16).ok() } else { None };
    let number = number.filter(|&number| number <= most);
    if number.is_none() {
        let expected = "hexadecimal digits in the range of the attribute";
        problems.report(element.place_of_attribute(attribute), &rules::NUMBER, expected, text);
    }
    number
}
