//! ROS message definitions, versions 1 and 2 (`ros1msg`, `ros2msg`).
//!
//! ```text
//! std_msgs/Header header        # a field: type, name, in ROS 2 perhaps a default value
//! uint8[<=64] data              # T[] a sequence, T[<=N] a bounded one, T[N] an array
//! int32 STANDARD=0              # a constant: no part of the message
//! ================================================================================
//! MSG: std_msgs/Header          # the definitions of the types used, each after such a line
//! ```

use std::collections::HashMap;

/// The type of a field, without its count.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum FieldKind {
    /// A number of `size` bytes, or a truth value.
    Number {
        size: usize,
        signed: bool,
    },
    Text,
    WideText,
    /// Another message, by its index in [`Definitions`].
    Message(usize),
}

/// The number of values in a field.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Count {
    One,
    Array(usize),
    /// A sequence, with its maximum length if it is bounded.
    Sequence(Option<usize>),
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) kind: FieldKind,
    pub(crate) count: Count,
}

/// One message type.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(crate) struct Message {
    /// The name in the form `std_msgs/Header`, without `msg/`.
    pub(crate) name: String,
    pub(crate) fields: Vec<Field>,
}

/// Message types: the type of the schema first, then the types that it uses.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Definitions(pub(crate) Vec<Message>);

/// Types that the schemas of some recorders use without defining them.
const WELL_KNOWN: &[(&str, &str)] = &[
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
];
/// The built-in types `time` and `duration` of ROS 1.
const TIME: &[(&str, &str)] = &[("time", "uint32 sec\nuint32 nsec"), ("duration", "int32 sec\nint32 nsec")];
const SEPARATOR: &str = "================";

/// The parsed lines of a definition; types are not resolved yet.
struct Unresolved<'a> {
    name: String,
    /// The type with its count, and the name, of each field.
    fields: Vec<(&'a str, &'a str)>,
}

/// Parses a schema's text; `name` is the name of the first message, such as `can_msgs/msg/Frame`.
///
/// # Errors
/// The line or type that can't be understood.
pub(crate) fn parse(name: &str, text: &str) -> Result<Definitions, String> {
    let mut parts = vec![Unresolved { name: plain_name(name), fields: Vec::new() }];
    let mut named = true;
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.starts_with(SEPARATOR) {
            parts.push(Unresolved { name: String::new(), fields: Vec::new() });
            named = false;
        } else if let (false, Some(name)) = (named, line.strip_prefix("MSG:")) {
            if let Some(part) = parts.last_mut() {
                part.name = plain_name(name.trim());
            }
            named = true;
        } else if let (Some(field), Some(part)) = (field(line)?, parts.last_mut()) {
            part.fields.push(field);
        }
    }
    for (name, text) in WELL_KNOWN.iter().chain(TIME) {
        if !parts.iter().any(|part| part.name == *name) {
            let fields = text.lines().filter_map(|line| line.split_once(' ')).collect();
            parts.push(Unresolved { name: (*name).to_owned(), fields });
        }
    }
    resolve(&parts)
}

/// The short name of a type: `pkg/msg/Type` becomes `pkg/Type`.
fn plain_name(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// The type and name of a field; `None` for a constant or an empty line.
fn field(line: &str) -> Result<Option<(&str, &str)>, String> {
    let mut words = line.splitn(2, char::is_whitespace);
    let (Some(kind), rest) = (words.next().filter(|word| !word.is_empty()), words.next()) else { return Ok(None) };
    let rest = rest.ok_or_else(|| format!("a field's name after its type: {line}"))?.trim();
    let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
    let (name, value) = rest.split_at(end);
    if name.is_empty() {
        return Err(format!("a field's name: {line}"));
    }
    // A constant has its value after `=`; a default value of ROS 2 follows a blank.
    Ok((!value.trim_start().starts_with('=')).then_some((kind, name)))
}

fn resolve(parts: &[Unresolved<'_>]) -> Result<Definitions, String> {
    let places: HashMap<&str, usize> =
        parts.iter().enumerate().rev().map(|(place, part)| (part.name.as_str(), place)).collect();
    let messages = parts.iter().map(|part| {
        let fields = part.fields.iter().map(|&(kind, name)| {
            let (kind, count) = counted(kind)?;
            Ok(Field { name: name.to_owned(), kind: kind_of(kind, &part.name, &places)?, count })
        });
        Ok(Message { name: part.name.clone(), fields: fields.collect::<Result<_, String>>()? })
    });
    Ok(Definitions(messages.collect::<Result<_, String>>()?))
}

/// Splits `uint8[<=64]` into its type and count.
fn counted(text: &str) -> Result<(&str, Count), String> {
    let Some((kind, count)) = text.strip_suffix(']').and_then(|text| text.split_once('[')) else {
        return Ok((text, Count::One));
    };
    let number = |digits: &str| digits.parse::<usize>().map_err(|_| format!("a number of elements: {text}"));
    Ok(match count.strip_prefix("<=") {
        _ if count.is_empty() => (kind, Count::Sequence(None)),
        Some(bound) => (kind, Count::Sequence(Some(number(bound)?))),
        None => (kind, Count::Array(number(count)?)),
    })
}

fn kind_of(text: &str, user: &str, places: &HashMap<&str, usize>) -> Result<FieldKind, String> {
    let number = |size, signed| Ok(FieldKind::Number { size, signed });
    // A bounded string `string<=10` is encoded as a string.
    match text.split("<=").next().unwrap_or(text) {
        "bool" | "byte" | "char" | "uint8" => return number(1, false),
        "int8" => return number(1, true),
        "uint16" => return number(2, false),
        "int16" => return number(2, true),
        "uint32" | "float32" => return number(4, false),
        "int32" => return number(4, true),
        "uint64" | "float64" => return number(8, false),
        "int64" => return number(8, true),
        "string" => return Ok(FieldKind::Text),
        "wstring" => return Ok(FieldKind::WideText),
        _ => {}
    }
    let name = plain_name(text);
    let neighbour = user.split_once('/').map(|(package, _)| format!("{package}/{name}"));
    let known = [Some(name.clone()), neighbour, (name == "Header").then(|| "std_msgs/Header".to_owned())];
    let place = known.iter().flatten().find_map(|name| places.get(name.as_str()));
    place.map(|&place| FieldKind::Message(place)).ok_or_else(|| format!("a known type: {text}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: &str = "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\nuint8 dlc\n\
        uint8[8] data\n================================================================================\n\
        MSG: std_msgs/Header\n# comment\nbuiltin_interfaces/Time stamp\n\nstring frame_id\n\
        ================================================================================\n\
        MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

    #[test]
    fn the_frame_of_can_msgs() {
        let Definitions(messages) = parse("can_msgs/msg/Frame", FRAME).unwrap();
        let fields: Vec<_> =
            messages[0].fields.iter().map(|field| (field.name.as_str(), field.kind, field.count)).collect();
        let flag = FieldKind::Number { size: 1, signed: false };
        assert_eq!(messages[0].name, "can_msgs/Frame");
        assert_eq!(
            fields,
            [
                ("header", FieldKind::Message(1), Count::One),
                ("id", FieldKind::Number { size: 4, signed: false }, Count::One),
                ("is_rtr", flag, Count::One),
                ("is_extended", flag, Count::One),
                ("is_error", flag, Count::One),
                ("dlc", flag, Count::One),
                ("data", flag, Count::Array(8)),
            ]
        );
        assert_eq!(messages[1].fields[0].kind, FieldKind::Message(2));
    }

    #[test]
    fn constants_defaults_bounds_and_neighbours() {
        let text = "uint8 MAX=8\nint32 OTHER = -3\nstring<=5 s \"a#b\"\nuint8 x 42\nPart[] parts\nwstring[<=3] w\nfloat64[2] f\n\
            ====================\nMSG: mine/Part\nbyte b\nHeader h\ntime t";
        let Definitions(messages) = parse("mine/Whole", text).unwrap();
        let fields: Vec<_> =
            messages[0].fields.iter().map(|field| (field.name.as_str(), field.kind, field.count)).collect();
        assert_eq!(
            fields,
            [
                ("s", FieldKind::Text, Count::One),
                ("x", FieldKind::Number { size: 1, signed: false }, Count::One),
                ("parts", FieldKind::Message(1), Count::Sequence(None)),
                ("w", FieldKind::WideText, Count::Sequence(Some(3))),
                ("f", FieldKind::Number { size: 8, signed: false }, Count::Array(2)),
            ]
        );
        let FieldKind::Message(header) = messages[1].fields[1].kind else { panic!() };
        assert_eq!(messages[header].name, "std_msgs/Header");
    }

    #[test]
    fn what_is_not_known_is_named() {
        assert_eq!(parse("a/B", "uint8"), Err("a field's name after its type: uint8".into()));
        assert_eq!(parse("a/B", "Nowhere x"), Err("a known type: Nowhere".into()));
        assert_eq!(parse("a/B", "uint8[x] x"), Err("a number of elements: uint8[x]".into()));
    }
}
