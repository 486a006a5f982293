//! Damage of sections.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::Eds;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/section/twice", Lines(twice)),
    ("eds/section/missing", Lines(missing)),
    ("eds/section/unknown", Lines(unknown)),
    ("eds/section/spelling", Lines(spelling)),
    ("eds/section/object-missing", Lines(head_missing)),
    ("eds/section/subs-missing", Lines(subs_missing)),
    ("eds/section/sub-0-missing", Lines(sub_0_missing)),
];

fn twice(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let header = dice.pick(&eds.headers())?;
    let copy = eds.lines[header..eds.end(header)].to_vec();
    let places: Vec<usize> = eds.headers().into_iter().filter(|&other| other > header).collect();
    let at = dice.pick(&places).unwrap_or(eds.lines.len());
    eds.lines.splice(at..at, copy);
    if dice.heads() {
        eds.lines[at] = eds.lines[at].to_uppercase();
    }
    Some(Place::Line(at))
}

fn missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let name = dice.of(&[
        "FileInfo",
        "DeviceInfo",
        "DummyUsage",
        "Comments",
        "MandatoryObjects",
        "OptionalObjects",
        "ManufacturerObjects",
    ]);
    let header = eds.header(name)?;
    eds.remove_section(header);
    Some(Place::File)
}

fn unknown(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let at = dice.pick(&eds.headers())?;
    eds.lines.insert(at, format!("[{}]", dice.word()));
    Some(Place::Line(at))
}

fn spelling(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let is_object = |header: &usize| eds.name(*header).starts_with(|digit: char| digit.is_ascii_digit());
    let headers: Vec<usize> = eds.headers().into_iter().filter(is_object).collect();
    let header = dice.pick(&headers)?;
    let name = eds.name(header).to_owned();
    eds.lines[header] = match name.split_once("sub").filter(|_| dice.heads()) {
        Some((index, sub)) => format!("[{index}sub0{sub}]"),
        None => format!("[0x{name}]"),
    };
    Some(Place::Line(header))
}

/// The objects with sub-indexes, and the headers of their sections.
fn containers(eds: &Eds) -> Vec<(u16, usize)> {
    eds.objects().into_iter().filter(|&(index, _)| !eds.subs(index).is_empty()).collect()
}

fn head_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (index, header) = dice.pick(&containers(eds))?;
    eds.remove_section(header);
    Some(Place::Line(eds.sub(index, 0)?))
}

fn subs_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (index, _) = dice.pick(&containers(eds))?;
    eds.remove_all(&format!("{index:04X}sub"));
    let header = eds.header(&format!("{index:04X}"))?;
    Some(Place::Line(eds.field(header, "SubNumber")?))
}

fn sub_0_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (index, _) = dice.pick(&containers(eds))?;
    let header = eds.sub(index, 0)?;
    eds.remove_section(header);
    Some(Place::Line(eds.header(&format!("{index:04X}"))?))
}
