//! Damage of numbers and formulas.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::{Eds, Entry, number};
use crate::field::fields;
use crate::right::INTEGERS;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/number/unreadable", Lines(unreadable)),
    ("eds/number/form", Lines(form)),
    ("eds/number/node-id-behind", Lines(node_id_behind)),
    ("eds/number/octal", Lines(octal)),
    ("eds/number/comment", Lines(comment)),
    ("eds/number/range", Lines(range)),
    ("eds/number/wrapped", Lines(wrapped)),
];

/// Fields that hold a number, whatever the data type of the entry.
const NUMBERS: [&str; 8] = [
    "VendorNumber",
    "ProductNumber",
    "RevisionNumber",
    "Granularity",
    "SupportedObjects",
    "SubNumber",
    "DataType",
    "NrOfTXPDO",
];

/// The entries of an integer type, with its number of bits and whether it is signed.
fn integers(eds: &Eds) -> Vec<(Entry, u32, bool)> {
    let kind = |entry: &Entry| INTEGERS.into_iter().find(|&(index, ..)| index == entry.data_type);
    eds.entries().into_iter().filter_map(|entry| kind(&entry).map(|(_, bits, signed)| (entry, bits, signed))).collect()
}

/// The line of a number in any kind of field.
fn any(eds: &Eds, dice: &mut Dice) -> Option<usize> {
    let mut lines = fields(eds, &NUMBERS);
    for (entry, ..) in integers(eds) {
        let values = ["DefaultValue", "LowLimit", "HighLimit"];
        lines.extend(values.iter().filter_map(|field| eds.field(entry.header, field)));
    }
    lines.retain(|&line| number(eds.value(line)).is_some());
    dice.pick(&lines)
}

fn unreadable(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let mut line = any(eds, dice)?;
    if dice.heads() {
        let lists: Vec<usize> = crate::eds::LISTS.iter().filter_map(|name| eds.header(name)).collect();
        let listed: Vec<usize> = lists.into_iter().flat_map(|list| eds.listed(list)).map(|(_, line, _)| line).collect();
        line = dice.pick(&listed)?;
    }
    let odd = ["0x", "0xG1", "1.5", "--1", "1 2", "5-", "12Z", "$NODEID*2"];
    let value = if dice.heads() { dice.word() } else { dice.of(&odd).to_owned() };
    eds.set(line, value);
    Some(Place::Line(line))
}

fn form(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = any(eds, dice)?;
    let value = number(eds.value(line))?;
    let forms = [format!("{value:X}h"), format!("\"{value}\""), format!("{value}.0"), format!("{value:04X}H")];
    // Floating point numbers are exact up to 53 bits.
    eds.set(line, dice.of(&forms));
    Some(Place::Line(line))
}

/// The line and the offset of an entry that holds a formula.
fn formula(eds: &Eds, dice: &mut Dice) -> Option<(usize, String)> {
    let formulas = fields(eds, &["DefaultValue"]);
    let of = |line: usize| Some((line, eds.value(line).strip_prefix("$NODEID+")?.to_owned()));
    dice.pick(&formulas.into_iter().filter_map(of).collect::<Vec<_>>())
}

fn node_id_behind(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (line, offset) = formula(eds, dice)?;
    let blank = dice.of(&["", " "]);
    eds.set(line, format!("{offset}{blank}+{blank}$NODEID"));
    Some(Place::Line(line))
}

fn octal(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let lines: Vec<usize> =
        integers(eds).iter().filter_map(|(entry, ..)| eds.field(entry.header, "DefaultValue")).collect();
    let line = dice.pick(&lines)?;
    let value = dice.between(8, 127);
    eds.set(line, format!("0{value:o}"));
    Some(Place::Line(line))
}

fn comment(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = any(eds, dice)?;
    let with = format!("{} {} {}", eds.value(line), dice.of(&[";", "#"]), dice.word());
    eds.set(line, with);
    Some(Place::Line(line))
}

fn range(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (entry, bits, _) = dice.pick(&integers(eds))?;
    let all = 1i128 << bits;
    let beyond = i128::from(dice.between(0, 1_000_000));
    let value = match dice.below(4) {
        0 => (all + beyond).to_string(),
        1 => format!("0x{:X}", all + beyond),
        2 => (-all / 2 - 1 - beyond).to_string(),
        _ if bits <= 32 => format!("$NODEID+0x{:X}", all - 1 - i128::from(dice.between(0, 126))),
        _ => all.to_string(),
    };
    // Another rule checks limits.
    let field = dice.of(&["DefaultValue", "ParameterValue"]);
    Some(Place::Line(eds.put(entry.header, field, value)))
}

fn wrapped(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (entry, bits, is_signed) = dice.pick(&integers(eds))?;
    let half = 1i128 << (bits - 1);
    let beyond = i128::from(dice.between(0, 100));
    let value = if is_signed { half + beyond } else { -1 - beyond };
    let field = dice.of(&["DefaultValue", "LowLimit", "HighLimit"]);
    Some(Place::Line(eds.put(entry.header, field, value)))
}
