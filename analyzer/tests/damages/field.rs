//! Damage of fields.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::Eds;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/field/twice", Lines(twice)),
    ("eds/field/repeated", Lines(repeated)),
    ("eds/field/unknown", Lines(unknown)),
    ("eds/field/blanks", Lines(blanks)),
    ("eds/field/configured", Lines(configured)),
    ("eds/field/name-missing", Lines(name_missing)),
    ("eds/field/name-quoted", Lines(name_quoted)),
    ("eds/field/name-too-long", Lines(name_long)),
    ("eds/field/name-twice", Lines(name_twice)),
    ("eds/field/object-type-missing", Lines(object_type_missing)),
    ("eds/field/data-type-missing", Lines(data_type_missing)),
    ("eds/field/access-missing", Lines(access_missing)),
    ("eds/field/flag", Lines(flag)),
    ("eds/field/range", Lines(range)),
];

/// The lines of all fields that have one of these names, in all sections.
pub fn fields(eds: &Eds, names: &[&str]) -> Vec<usize> {
    let is_wanted = |line: &usize| names.iter().any(|name| eds.key(*line).eq_ignore_ascii_case(name));
    eds.headers().into_iter().flat_map(|header| eds.fields(header)).filter(is_wanted).collect()
}

/// The header of the section that a line is in.
fn header_of(eds: &Eds, line: usize) -> usize {
    eds.headers().into_iter().rfind(|&header| header < line).unwrap()
}

fn any(eds: &Eds, dice: &mut Dice) -> Option<usize> {
    let all: Vec<usize> = eds.headers().into_iter().flat_map(|header| eds.fields(header)).collect();
    dice.pick(&all)
}

/// Inserts a line somewhere after the line `line` of its section.
fn behind(eds: &mut Eds, dice: &mut Dice, line: usize, text: String) -> Place {
    let last = eds.last(header_of(eds, line));
    let at = dice.between(line as u64 + 1, last as u64) as usize;
    eds.lines.insert(at, text);
    Place::Line(at)
}

fn twice(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = any(eds, dice)?;
    let text = format!("{}={}1", eds.key(line), eds.value(line));
    Some(behind(eds, dice, line, text))
}

fn repeated(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = any(eds, dice)?;
    let key = if dice.heads() { eds.key(line).to_uppercase() } else { eds.key(line).to_owned() };
    let text = format!("{key} = {}", eds.value(line));
    Some(behind(eds, dice, line, text))
}

fn unknown(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    // Other rules check the field names of the other sections.
    let has_names = |header: &usize| {
        let name = eds.name(*header).to_ascii_lowercase();
        !["dummyusage", "objects", "name", "value", "links", "extends"].iter().any(|end| name.ends_with(end))
    };
    let headers: Vec<usize> = eds.headers().into_iter().filter(has_names).collect();
    let header = dice.pick(&headers)?;
    let at = dice.between(header as u64 + 1, eds.last(header) as u64) as usize;
    eds.lines.insert(at, format!("{}=1", dice.word()));
    Some(Place::Line(at))
}

/// Divides the name of a field into words.
fn blanks(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let names =
        [("SupportedObjects", "Supported Objects"), ("ParameterName", "Parameter Name"), ("DataType", "Data Type")];
    let (name, divided) = dice.of(&names);
    let line = dice.pick(&fields(eds, &[name]))?;
    eds.lines[line] = format!("{divided}={}", eds.value(line));
    Some(Place::Line(line))
}

/// Gives an entry of an EDS a configured value.
fn configured(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    if eds.header("DeviceComissioning").is_some() {
        return None;
    }
    let is_number = |&line: &usize| {
        let header = header_of(eds, line);
        eds.number_of(header, "DataType").is_some_and(|data_type| (1..=7).contains(&data_type))
            && eds.number_of(header, "CompactSubObj").is_none()
    };
    let lines: Vec<usize> = fields(eds, &["AccessType"]).into_iter().filter(is_number).collect();
    let line = dice.pick(&lines)?;
    let at = line + 1;
    eds.lines.insert(at, "ParameterValue=1".to_owned());
    Some(Place::Line(at))
}

/// The line of some object's or entry's name.
fn name(eds: &Eds, dice: &mut Dice) -> Option<usize> {
    dice.pick(&fields(eds, &["ParameterName"]))
}

/// Removes a field. The finding is at the header of the section.
fn remove(eds: &mut Eds, line: usize) -> Place {
    let header = header_of(eds, line);
    eds.lines.remove(line);
    Place::Line(header)
}

fn name_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    // Many descriptions omit the name of sub-index 0.
    let is_count = |line: &usize| eds.name(header_of(eds, *line)).to_ascii_lowercase().ends_with("sub0");
    let lines: Vec<usize> = fields(eds, &["ParameterName"]).into_iter().filter(|line| !is_count(line)).collect();
    let line = dice.pick(&lines)?;
    if dice.heads() {
        return Some(remove(eds, line));
    }
    eds.set(line, "");
    Some(Place::Line(line))
}

fn name_quoted(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = name(eds, dice)?;
    let quoted = format!("\"{}\"", eds.value(line));
    eds.set(line, quoted);
    Some(Place::Line(line))
}

fn name_long(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = name(eds, dice)?;
    eds.set(line, "n".repeat(dice.between(242, 300) as usize));
    Some(Place::Line(line))
}

fn object_type_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let is_object = |line: &usize| !eds.name(header_of(eds, *line)).starts_with('M');
    let lines: Vec<usize> = fields(eds, &["ObjectType"]).into_iter().filter(is_object).collect();
    let line = dice.pick(&lines)?;
    Some(remove(eds, line))
}

/// A field of an entry. DOMAIN entries are left out, as they need no such field.
fn of_entry(eds: &Eds, dice: &mut Dice, field: &str) -> Option<usize> {
    let entries = eds.entries().into_iter().filter(|entry| entry.data_type != 0xF);
    let lines: Vec<usize> = entries.filter_map(|entry| eds.field(entry.header, field)).collect();
    dice.pick(&lines)
}

fn data_type_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = of_entry(eds, dice, "DataType")?;
    Some(remove(eds, line))
}

fn access_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = of_entry(eds, dice, "AccessType")?;
    Some(remove(eds, line))
}

fn flag(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let flags = ["PDOMapping", "LSS_Supported", "BaudRate_125", "SimpleBootUpSlave", "GroupMessaging", "Dummy0005"];
    let flag = dice.of(&flags);
    let line = dice.pick(&fields(eds, &[flag]))?;
    let more = dice.between(2, 9).to_string();
    let value = dice.of(&["yes", "no", "true", "FALSE", &more, "0x10"]).to_owned();
    eds.set(line, value);
    Some(Place::Line(line))
}

fn range(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (name, most) = dice.of(&[
        ("Granularity", 64),
        ("ObjectType", 0xFF),
        ("DataType", 0xFFFF),
        ("SubNumber", 0xFF),
        ("CompactSubObj", 0xFE),
        ("NrOfRXPDO", 512),
        ("NrOfTXPDO", 512),
        ("VendorNumber", u64::from(u32::MAX)),
        ("ProductNumber", u64::from(u32::MAX)),
        ("CompactPDO", 0xFF),
    ]);
    let line = dice.pick(&fields(eds, &[name]))?;
    let value = dice.between(most + 1, most + 1000);
    eds.set(line, value);
    Some(Place::Line(line))
}

/// Gives an object the name of an object with a lower index, or an entry the name of an entry before it.
fn name_twice(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let mut headers: Vec<(u16, usize)> = eds.objects();
    if dice.heads() {
        let subs = |(index, _): (u16, usize)| Some((index, eds.sub(index, 1)?, eds.sub(index, 2)?));
        let with_subs: Vec<_> = headers.into_iter().filter_map(subs).collect();
        let (_, first, second) = dice.pick(&with_subs)?;
        return same_name(eds, first, second);
    }
    headers.sort_unstable();
    let later = dice.between(1, headers.len() as u64 - 1) as usize;
    let earlier = dice.below(later);
    same_name(eds, headers[earlier].1, headers[later].1)
}

fn same_name(eds: &mut Eds, from: usize, to: usize) -> Option<Place> {
    let name = eds.text_of(from, "ParameterName")?.to_owned();
    Some(Place::Line(eds.put(to, "ParameterName", name)))
}
