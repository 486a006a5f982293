//! Damage of descriptions in XML: random descriptions, converted to XML.

use crate::dice::Dice;

/// Damages the text; returns the damaged line, from 0.
pub type Damage = fn(&mut String, &mut Dice) -> Option<usize>;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("xdd/text/malformed", malformed),
    ("xdd/element/attribute-twice", attribute_twice),
    ("xdd/object/twice", twice),
    ("xdd/number/prefix", prefix),
    ("xdd/number/unreadable", number),
    ("xdd/object/reference", reference),
    ("xdd/object/sub-number", sub_number),
    ("xdd/object/object-type", object_type),
    ("xdd/object/data-type-missing", data_type_missing),
    ("xdd/object/access", access),
    ("xdd/object/access-missing", access_missing),
];

/// For each of these elements with the attribute `name`: where the element begins, and where the value of the attribute
/// is.
fn attributes(text: &str, elements: &[&str], name: &str) -> Vec<(usize, std::ops::Range<usize>)> {
    let mut found = Vec::new();
    for element in elements {
        for (at, _) in text.match_indices(&format!("<{element} ")) {
            let end = at + text[at..].find('>').unwrap();
            let attribute = format!(" {name}=\"");
            let Some(value) = text[at..end].find(&attribute).map(|value| at + value + attribute.len()) else {
                continue;
            };
            found.push((at, value..value + text[value..].find('"').unwrap()));
        }
    }
    found
}

const OBJECTS: [&str; 2] = ["CANopenObject", "CANopenSubObject"];

fn line(text: &str, at: usize) -> Option<usize> {
    Some(text[..at].matches('\n').count())
}

fn set(text: &mut String, dice: &mut Dice, elements: &[&str], name: &str, value: &str) -> Option<usize> {
    let (_, range) = dice.pick(&attributes(text, elements, name))?;
    let at = line(text, range.start);
    text.replace_range(range, value);
    at
}

fn remove(text: &mut String, dice: &mut Dice, name: &str) -> Option<usize> {
    let (element, range) = dice.pick(&attributes(text, &OBJECTS, name))?;
    text.replace_range(range.start - name.len() - 3..range.end + 1, "");
    line(text, element)
}

/// Gives an end tag a wrong name. A wrong end tag before the first object is an error of the whole file.
fn malformed(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let first = text.find("<CANopenObjectList")?;
    let ends: Vec<usize> = text.match_indices("</").map(|(at, _)| at).filter(|&at| at > first).collect();
    let at = dice.pick(&ends)?;
    text.replace_range(at..at + 2, "</x");
    line(text, at)
}

fn attribute_twice(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let (_, range) = dice.pick(&attributes(text, &OBJECTS, "name"))?;
    text.insert_str(range.end + 1, " name=\"Other\"");
    line(text, range.start)
}

fn twice(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let (from, to) = dice.pick(
        &attributes(text, &["CANopenSubObject"], "subIndex")
            .into_iter()
            .map(|(at, _)| (at, at + text[at..].find("/>").unwrap() + 2))
            .collect::<Vec<_>>(),
    )?;
    let copy = text[from..to].to_owned();
    text.insert_str(to, &format!("\n{copy}"));
    line(text, to).map(|line| line + 1)
}

fn prefix(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let name = dice.of(&["index", "subIndex", "dataType"]);
    let (_, range) = dice.pick(&attributes(text, &OBJECTS, name))?;
    text.insert_str(range.start, "0x");
    line(text, range.start)
}

fn number(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let (name, value) = (dice.of(&["index", "subIndex", "dataType"]), dice.of(&["WORD", "10000", "-1", "+1"]));
    set(text, dice, &OBJECTS, name, value)
}

fn reference(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let (at, range) = dice.pick(&attributes(text, &OBJECTS, "dataType"))?;
    text.insert_str(range.end + 1, &format!(" uniqueIDRef=\"UID_{}\"", dice.word()));
    line(text, at)
}

fn sub_number(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let value = dice.between(100, 254).to_string();
    set(text, dice, &OBJECTS, "subNumber", &value)
}

fn object_type(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let code = dice.of(&["1", "3", "4", "10", "VAR"]);
    set(text, dice, &OBJECTS, "objectType", code)
}

fn data_type_missing(text: &mut String, dice: &mut Dice) -> Option<usize> {
    remove(text, dice, "dataType")
}

fn access(text: &mut String, dice: &mut Dice) -> Option<usize> {
    let word = dice.word();
    set(text, dice, &OBJECTS, "accessType", &word)
}

fn access_missing(text: &mut String, dice: &mut Dice) -> Option<usize> {
    remove(text, dice, "accessType")
}
