//! Damage of single objects and entries.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::{Eds, Entry};
use crate::field::fields;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/entry/object-type", Lines(object_type)),
    ("eds/entry/sub-object-type", Lines(sub_object_type)),
    ("eds/entry/subs-of-var", Lines(subs_of_var)),
    ("eds/entry/data-type", Lines(data_type)),
    ("eds/entry/access", Lines(access)),
    ("eds/entry/access-form", Lines(access_form)),
    ("eds/entry/limits", Lines(limits)),
    ("eds/entry/limit-range", Lines(limit_range)),
    ("eds/entry/beyond-limits", Lines(beyond_limits)),
    ("eds/entry/flags", Lines(flags)),
    ("eds/entry/visible-string", Lines(visible_string)),
    ("eds/entry/sub-0-type", Lines(sub_0_type)),
    ("eds/entry/array-type", Lines(array_type)),
    ("eds/entry/array-gap", Lines(array_gap)),
];

/// Gives the field in one of these lines this value.
fn set_one(eds: &mut Eds, dice: &mut Dice, lines: &[usize], value: &str) -> Option<Place> {
    let line = dice.pick(lines)?;
    eds.set(line, value);
    Some(Place::Line(line))
}

fn object_type(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let code = dice.of(&[1, 3, 4, 10, 11, 255]);
    let lines = fields(eds, &["ObjectType"]);
    set_one(eds, dice, &lines, &format!("0x{code:X}"))
}

/// The ARRAY and RECORD objects whose sub-indexes have sections: index, number of the header, and ObjectType.
fn containers(eds: &Eds) -> Vec<(u16, usize, u64)> {
    let with_code = |(index, header)| Some((index, header, eds.number_of(header, "ObjectType")?));
    let objects = eds.objects().into_iter().filter_map(with_code);
    objects.filter(|&(index, _, code)| matches!(code, 8 | 9) && !eds.subs(index).is_empty()).collect()
}

fn sub_object_type(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (index, ..) = dice.pick(&containers(eds))?;
    let (_, header) = dice.pick(&eds.subs(index))?;
    Some(Place::Line(eds.put(header, "ObjectType", dice.of(&["0x8", "0x9", "0x2"]))))
}

fn subs_of_var(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (_, header, _) = dice.pick(&containers(eds))?;
    Some(Place::Line(eds.put(header, "ObjectType", "0x7")))
}

/// The entries of objects, not of modules.
fn of_entries(eds: &Eds, field: &str) -> Vec<usize> {
    eds.entries().into_iter().filter_map(|entry| eds.field(entry.header, field)).collect()
}

fn data_type(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let index = dice.of(&[0x17, 0x1C, 0x1F, 0x26, 0x3F, 0x260, 0xFFFF]);
    let lines = of_entries(eds, "DataType");
    set_one(eds, dice, &lines, &format!("0x{index:04X}"))
}

fn access(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let other = dice.word();
    let word = dice.of(&["maybe".to_owned(), "rx".to_owned(), "1".to_owned(), other]);
    let lines = of_entries(eds, "AccessType");
    set_one(eds, dice, &lines, &word)
}

fn access_form(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let word = dice.of(&["r", "read", "ReadOnly", "w", "write", "wr", "r/w", "readwrite", "constant", "C"]);
    let lines = of_entries(eds, "AccessType");
    set_one(eds, dice, &lines, word)
}

/// The entries with both limits.
fn limited(eds: &Eds) -> Vec<Entry> {
    let has = |entry: &Entry, field| eds.text_of(entry.header, field).is_some();
    eds.entries().into_iter().filter(|entry| has(entry, "LowLimit") && has(entry, "HighLimit")).collect()
}

fn limits(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let Entry { header, .. } = dice.pick(&limited(eds))?;
    let (low, high) = (eds.field(header, "LowLimit")?, eds.field(header, "HighLimit")?);
    let (bottom, top) = (eds.value(low).to_owned(), eds.value(high).to_owned());
    eds.set(low, &top);
    eds.set(high, &bottom);
    Some(Place::Line(low)).filter(|_| bottom != top)
}

fn limit_range(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let Entry { header, data_type, .. } = dice.pick(&limited(eds))?;
    let too_large = match data_type {
        2 | 5 => "0x100",
        3 | 6 => "65536",
        4 | 7 => "0x100000000",
        _ => "18446744073709551616",
    };
    Some(Place::Line(eds.put(header, "HighLimit", too_large)))
}

fn beyond_limits(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let entries: Vec<Entry> = limited(eds).into_iter().filter(|entry| entry.index < 0x6000).collect();
    let Entry { header, .. } = dice.pick(&entries)?;
    let high = eds.number_of(header, "HighLimit")?;
    // Even the smallest data types hold values above 90.
    let high = if high > 100 { eds.put(header, "HighLimit", 90).min(90) as u64 } else { high };
    let field = dice.of(&["DefaultValue", "ParameterValue"]);
    Some(Place::Line(eds.put(header, field, dice.between(high + 1, 127.max(high + 1)))))
}

fn flags(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let Entry { header, .. } = dice.pick(&eds.entries())?;
    Some(Place::Line(eds.put(header, "ObjFlags", dice.between(4, 100_000))))
}

fn visible_string(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let entries: Vec<Entry> = eds.entries().into_iter().filter(|entry| entry.data_type == 9).collect();
    let Entry { header, .. } = dice.pick(&entries)?;
    let character = dice.of(&['\u{1}', '\u{7F}', '\u{E4}', '\u{20AC}']);
    Some(Place::Line(eds.put(header, "DefaultValue", format!("{}{character}x", dice.word()))))
}

/// Only manufacturer-specific objects: another rule checks the objects that a standard defines.
fn sub_0_type(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let is_ours = |entry: &Entry| entry.sub == Some(0) && matches!(entry.index, 0x2000..=0x5FFF);
    let entries: Vec<Entry> = eds.entries().into_iter().filter(is_ours).collect();
    let Entry { header, .. } = dice.pick(&entries)?;
    Some(Place::Line(eds.put(header, "DataType", dice.of(&["0x0006", "0x0007", "0x0002", "0x0009"]))))
}

/// The elements of ARRAYs: index, sub-index and highest sub-index.
fn elements(eds: &Eds) -> Vec<(u16, u8, u8)> {
    let arrays = containers(eds).into_iter().filter(|&(.., code)| code == 8);
    let of = |(index, _, _): (u16, usize, u64)| {
        let subs = eds.subs(index);
        let highest = subs.iter().map(|&(sub, _)| sub).max().unwrap_or(0);
        subs.into_iter().filter(|&(sub, _)| sub > 0).map(move |(sub, _)| (index, sub, highest))
    };
    arrays.flat_map(of).collect()
}

fn array_type(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    // The rule compares all elements with the first one.
    let (index, sub, _) = dice.pick(&elements(eds).into_iter().filter(|&(_, sub, _)| sub > 1).collect::<Vec<_>>())?;
    let header = eds.sub(index, sub)?;
    let now = eds.number_of(header, "DataType")?;
    let others: Vec<u64> = [2, 3, 4, 5, 6, 7].into_iter().filter(|&other| other != now).collect();
    Some(Place::Line(eds.put(header, "DataType", format!("0x{:04X}", dice.of(&others)))))
}

fn array_gap(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let inner: Vec<_> = elements(eds).into_iter().filter(|&(_, sub, highest)| sub < highest).collect();
    let (index, sub, _) = dice.pick(&inner)?;
    let header = eds.sub(index, sub)?;
    eds.remove_section(header);
    Some(Place::Line(eds.sub(index, sub + 1)?))
}
