//! Damage of the file as text.

use super::{Bytes, Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::Eds;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/text/encoding", Bytes(encoding)),
    // The place of a byte order mark is always the first byte.
    (
        "eds/text/byte-order-mark",
        Bytes(|eds, _| Some(([b"\xEF\xBB\xBF", eds.text().as_bytes()].concat(), Place::Line(0)))),
    ),
    // UTF-16 concerns the whole file; only the byte order is random.
    ("eds/text/utf-16", Bytes(utf_16)),
    ("eds/text/line-ends", Lines(line_ends)),
    ("eds/text/control-character", Lines(control)),
    ("eds/text/line-too-long", Lines(too_long)),
    ("eds/text/unread", Lines(unread)),
    ("eds/text/comment", Lines(comment)),
    ("eds/text/section-line", Lines(section_line)),
    ("eds/text/conflict", Lines(conflict)),
    ("eds/text/half-read", Lines(half_read)),
    ("eds/text/too-much", Lines(too_much)),
];

fn any_line(eds: &Eds, dice: &mut Dice) -> usize {
    dice.below(eds.lines.len())
}

/// The index of a line that is not empty.
fn filled(eds: &Eds, dice: &mut Dice) -> usize {
    let lines: Vec<usize> = (0..eds.lines.len()).filter(|&line| eds.lines[line].len() > 2).collect();
    dice.of(&lines)
}

fn encoding(eds: &mut Eds, dice: &mut Dice) -> Option<(Vec<u8>, Place)> {
    let line = filled(eds, dice);
    let at = dice.below(eds.lines[line].len());
    // The character in Latin-1 or in UTF-8.
    let character: &[u8] = if dice.heads() { b"\xE4" } else { "\u{E4}".as_bytes() };
    eds.lines[line].insert(at, '\u{1}');
    let bytes = eds.text().into_bytes();
    let mut parts = bytes.splitn(2, |&byte| byte == 1);
    let bytes = [parts.next()?, character, parts.next()?].concat();
    Some((bytes, Place::Line(line)))
}

fn utf_16(eds: &mut Eds, dice: &mut Dice) -> Option<(Vec<u8>, Place)> {
    let of = if dice.heads() { u16::to_le_bytes } else { u16::to_be_bytes };
    let units = std::iter::once(0xFEFF).chain(eds.text().encode_utf16().collect::<Vec<_>>());
    Some((units.flat_map(of).collect(), Place::Line(0)))
}

fn line_ends(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = dice.below(eds.lines.len() - 1);
    if dice.heads() {
        eds.lines[line].push('\r');
    } else {
        let next = eds.lines.remove(line + 1);
        eds.lines[line] += &format!("\r{next}");
    }
    // The rule reports the problem at the beginning.
    Some(Place::Line(0))
}

fn control(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = any_line(eds, dice);
    let at = dice.below(eds.lines[line].len() + 1);
    let character = dice.of(&['\u{1}', '\u{7}', '\u{8}', '\u{B}', '\u{C}', '\u{1B}', '\u{1F}', '\u{7F}']);
    eds.lines[line].insert(at, character);
    Some(Place::Line(line))
}

fn too_long(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = any_line(eds, dice);
    let more = dice.between(256, 400) as usize;
    let filling = if dice.heads() { "x" } else { " " };
    let missing = more - eds.lines[line].len();
    eds.lines[line] += &filling.repeat(missing);
    Some(Place::Line(line))
}

fn insert(eds: &mut Eds, dice: &mut Dice, text: String) -> Option<Place> {
    let line = any_line(eds, dice);
    eds.lines.insert(line, text);
    Some(Place::Line(line))
}

fn unread(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let text = format!("{} {}", dice.word(), dice.word());
    insert(eds, dice, text)
}

fn comment(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let text = format!("{}{}", dice.of(&["#", "# ", "//", "// "]), dice.word());
    insert(eds, dice, text)
}

fn section_line(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = dice.pick(&eds.headers())?;
    if dice.heads() {
        eds.lines[line].pop();
    } else {
        eds.lines[line] += &format!(" {}", dice.word());
    }
    Some(Place::Line(line))
}

fn conflict(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let begin = any_line(eds, dice);
    let end = (begin + 1 + dice.below(5)).min(eds.lines.len());
    let other = eds.lines[begin..end].to_vec();
    let after = [vec!["=======".to_owned()], other, vec![format!(">>>>>>> {}", dice.word())]].concat();
    eds.lines.splice(end..end, after);
    eds.lines.insert(begin, "<<<<<<< HEAD".to_owned());
    Some(Place::Line(begin))
}

fn half_read(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    for _ in 0..eds.lines.len() {
        unread(eds, dice);
    }
    // The rule reports the problem at the beginning.
    Some(Place::Line(0))
}

/// More problems than are listed. A file with more lines than are read would take too long in repeated tests.
fn too_much(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = any_line(eds, dice);
    eds.lines.splice(line..line, (0..10_001).map(|_| "#".to_owned()));
    Some(Place::Line(line + 10_000))
}
