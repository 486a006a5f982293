//! Damage of modular devices.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::Eds;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/module/count", Lines(count)),
    ("eds/module/section-missing", Lines(section_missing)),
    ("eds/module/number", Lines(number)),
    ("eds/module/extension-count", Lines(extension)),
];

fn count(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let header = eds.header("SupportedModules")?;
    let more = dice.between(3, 99);
    Some(Place::Line(eds.put(header, "NrOfEntries", dice.of(&[0, 1, more]))))
}

fn section_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    // Other sections of the first module remain, and show that the module exists.
    let header = eds.header(dice.of(&["SupportedModules", "M1ModuleInfo"]))?;
    eds.remove_section(header);
    Some(Place::File)
}

fn number(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let header = eds.header("M2ModuleInfo")?;
    eds.lines[header] = format!("[M{}ModuleInfo]", dice.between(3, 99));
    Some(Place::Line(header))
}

fn extension(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let header = eds.header("M1SubExt5F00")?;
    let line = eds.field(header, "Count")?;
    if dice.heads() {
        eds.lines.remove(line);
        return Some(Place::Line(header));
    }
    let word = dice.word();
    eds.set(line, word);
    Some(Place::Line(line))
}
