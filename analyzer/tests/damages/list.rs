//! Damage of lists and counts.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::{Eds, LISTS, Listed};
use crate::field::fields;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/list/count", Lines(count)),
    ("eds/list/gap", Lines(gap)),
    ("eds/list/order", Lines(order)),
    ("eds/list/key", Lines(key)),
    ("eds/list/twice", Lines(twice)),
    ("eds/list/undescribed", Lines(undescribed)),
    ("eds/list/unlisted", Lines(unlisted)),
    ("eds/list/wrong", Lines(wrong)),
    ("eds/list/sub-number", Lines(sub_number)),
    ("eds/list/highest-sub-index", Lines(highest)),
    ("eds/list/entries", Lines(entries)),
    ("eds/list/entry-key", Lines(entry_key)),
    ("eds/list/link", Lines(link)),
];

/// A list with at least `least` entries.
fn list(eds: &Eds, dice: &mut Dice, least: usize) -> Option<usize> {
    let lists = LISTS.iter().filter_map(|name| eds.header(name));
    dice.pick(&lists.filter(|&list| eds.listed(list).len() >= least).collect::<Vec<_>>())
}

/// Adds an entry to a list and increments its count; returns the line of the entry.
fn add(eds: &mut Eds, list: usize, index: u16) -> usize {
    let next = eds.listed(list).len() + 1;
    eds.put(list, "SupportedObjects", next);
    eds.put(list, &next.to_string(), format!("0x{index:04X}"))
}

/// Removes an entry from a list; the following entries move up.
fn take(eds: &mut Eds, list: usize, number: u32) {
    let (listed, mut values) = (eds.listed(list), Vec::new());
    values.extend(listed.iter().filter(|(other, ..)| *other != number).map(|(.., index)| *index));
    for (&(_, line, _), index) in listed.iter().zip(&values) {
        eds.set(line, format!("0x{index:04X}"));
    }
    eds.put(list, "SupportedObjects", values.len());
    eds.lines.remove(listed[listed.len() - 1].1);
}

fn count(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 1)?;
    let (line, entries) = (eds.field(list, "SupportedObjects")?, eds.listed(list).len() as u64);
    let other = if dice.heads() { dice.between(0, entries - 1) } else { entries + dice.between(1, 99) };
    eds.set(line, other);
    Some(Place::Line(line))
}

fn gap(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 1)?;
    let listed = eds.listed(list);
    let (number, first, _) = dice.pick(&listed)?;
    let more = dice.between(1, 9) as u32;
    for (other, line, _) in listed.into_iter().filter(|(other, ..)| *other >= number) {
        eds.lines[line] = format!("{}={}", other + more, eds.value(line));
    }
    Some(Place::Line(first))
}

fn order(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 2)?;
    let listed = eds.listed(list);
    let at = dice.below(listed.len() - 1);
    eds.lines.swap(listed[at].1, listed[at + 1].1);
    Some(Place::Line(listed[at + 1].1))
}

fn key(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 1)?;
    let (_, line, _) = dice.pick(&eds.listed(list))?;
    let word = dice.word();
    let key = dice.of(&["third".to_owned(), word, "-1".to_owned()]);
    eds.lines[line] = format!("{key}={}", eds.value(line));
    Some(Place::Line(line))
}

fn twice(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 1)?;
    let (.., index) = dice.pick(&eds.listed(list))?;
    Some(Place::Line(add(eds, list, index)))
}

fn undescribed(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 1)?;
    let (_, line, index) = dice.pick(&eds.listed(list))?;
    let (list_name, key) = (eds.name(list).to_owned(), eds.key(line).to_owned());
    eds.remove_all(&format!("{index:04X}"));
    let list = eds.header(&list_name)?;
    Some(Place::Line(eds.field(list, &key)?))
}

fn unlisted(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 1)?;
    let (number, _, index) = dice.pick(&eds.listed(list))?;
    take(eds, list, number);
    Some(Place::Line(eds.header(&format!("{index:04X}"))?))
}

fn wrong(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let list = list(eds, dice, 1)?;
    let from = eds.name(list).to_owned();
    // Earlier versions of CiA 301 had 1018h as optional.
    let listed: Listed = eds.listed(list).into_iter().filter(|&(.., index)| index != 0x1018).collect();
    let (number, _, index) = dice.pick(&listed)?;
    let others: Vec<&str> = LISTS.into_iter().filter(|name| *name != from).collect();
    let other = dice.pick(&others)?;
    take(eds, list, number);
    let other = eds.header(other)?;
    Some(Place::Line(add(eds, other, index)))
}

fn sub_number(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = dice.pick(&fields(eds, &["SubNumber"]))?;
    let other = crate::eds::number(eds.value(line))? + dice.between(1, 100);
    eds.set(line, other);
    Some(Place::Line(line))
}

fn highest(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let entries = eds.entries().into_iter().filter(|entry| entry.sub == Some(0) && entry.index != 0x1003);
    let fixed = entries.filter(|entry| matches!(eds.text_of(entry.header, "AccessType"), Some("ro" | "const")));
    let lines: Vec<usize> = fixed.filter_map(|entry| eds.field(entry.header, "DefaultValue")).collect();
    let line = dice.pick(&lines)?;
    let other = crate::eds::number(eds.value(line))? + dice.between(1, 100);
    eds.set(line, other);
    Some(Place::Line(line))
}

/// The header of a section of one of these kinds, which belong to an object.
fn beside(eds: &Eds, dice: &mut Dice, kinds: &[&str]) -> Option<usize> {
    let is_kind = |header: &usize| {
        let name = eds.name(*header);
        name.len() > 4 && kinds.contains(&name.split_at(4).1)
    };
    dice.pick(&eds.headers().into_iter().filter(is_kind).collect::<Vec<_>>())
}

fn entries(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let section = beside(eds, dice, &["Name", "Value", "ObjectLinks"])?;
    let field = if eds.field(section, "NrOfEntries").is_some() { "NrOfEntries" } else { "ObjectLinks" };
    let other = eds.number_of(section, field)? + dice.between(1, 100);
    Some(Place::Line(eds.put(section, field, other)))
}

fn entry_key(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let section = beside(eds, dice, &["Name", "Value"])?;
    let line = dice.pick(&[eds.field(section, "1")?, eds.field(section, "3")?])?;
    let (number, word) = (dice.between(10, 999).to_string(), dice.word());
    let key = dice.of(&["0".to_owned(), "255".to_owned(), number, word]);
    eds.lines[line] = format!("{key}={}", eds.value(line));
    Some(Place::Line(line))
}

fn link(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let section = beside(eds, dice, &["ObjectLinks"])?;
    let line = eds.field(section, "1")?;
    eds.set(line, dice.of(&["0x5FFE", "0x9000", "0x0FFF", "none"]));
    Some(Place::Line(line))
}
