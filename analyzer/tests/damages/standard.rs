//! Damage of objects that the standards define.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::{Eds, Entry};

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/standard/object-code", Lines(object_code)),
    ("eds/standard/name", Lines(name)),
    ("eds/standard/data-type", Lines(data_type)),
    ("eds/standard/access", Lines(access)),
    ("eds/standard/read-only", Lines(access_less)),
    ("eds/standard/pdo-mapping", Lines(mapping)),
    ("eds/standard/range", Lines(range)),
    ("eds/standard/mandatory", Lines(|eds, dice| missing(eds, dice.of(&["1000", "1001"])))),
    ("eds/standard/identity-missing", Lines(|eds, _| missing(eds, "1018"))),
    ("eds/standard/companion", Lines(companion)),
    ("eds/encoder/revolutions", Lines(revolutions)),
    ("eds/encoder/measuring-range", Lines(measuring_range)),
    ("eds/encoder/units-per-revolution", Lines(units)),
    ("eds/encoder/preset", Lines(preset)),
];

/// The entries of CiA 301 whose access type is one of `access`.
fn entries(eds: &Eds, access: &[&str]) -> Vec<Entry> {
    let is_standard = |entry: &Entry| {
        matches!(entry.index, 0x1000..=0x1FFF) && (entry.sub.is_none() || !matches!(entry.sub, Some(0)))
    };
    let has = |entry: &Entry| eds.text_of(entry.header, "AccessType").is_some_and(|text| access.contains(&text));
    eds.entries().into_iter().filter(is_standard).filter(has).collect()
}

fn put(eds: &mut Eds, entries: &[Entry], dice: &mut Dice, field: &str, value: &str) -> Option<Place> {
    let Entry { header, .. } = dice.pick(entries)?;
    Some(Place::Line(eds.put(header, field, value)))
}

/// Describes a VAR object as an ARRAY, or a RECORD as a VAR.
fn object_code(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    if dice.heads() {
        let index = dice.of(&[0x1010, 0x1011, 0x1018]);
        eds.remove_all(&format!("{index:04X}sub"));
        let header = eds.header(&format!("{index:04X}"))?;
        eds.put(header, "DataType", "0x0007");
        eds.put(header, "AccessType", "ro");
        return Some(Place::Line(eds.put(header, "ObjectType", "0x7")));
    }
    let of_encoders: &[&str] = if is_rotary(eds).is_some() { &["6000", "6001"] } else { &[] };
    let header = eds.header(dice.of(&[&["1005", "1006", "1014", "1015", "1017"], of_encoders].concat()))?;
    eds.put(header, "CompactSubObj", dice.between(1, 9));
    Some(Place::Line(eds.put(header, "ObjectType", "0x8")))
}

/// Gives an object or entry the name of another one.
fn name(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    const OBJECTS: [(&str, &str); 6] = [
        ("1000", "Device type"),
        ("1001", "Error register"),
        ("1005", "COB-ID SYNC message"),
        ("100C", "Guard time"),
        ("1014", "COB-ID EMCY"),
        ("1017", "producer heartbeat-time"),
    ];
    const ENTRIES: [(&str, &str); 3] =
        [("1018sub1", "Vendor-ID"), ("1018sub2", "Product Code"), ("1018sub3", "Revision number")];
    let names = if dice.heads() { &OBJECTS[..] } else { &ENTRIES[..] };
    let (own, of) = (dice.below(names.len()), dice.below(names.len()));
    let of = if own == of { (of + 1) % names.len() } else { of };
    let header = eds.header(names[own].0)?;
    Some(Place::Line(eds.put(header, "ParameterName", names[of].1)))
}

fn data_type(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let entry = dice.pick(&entries(eds, &["ro", "rw", "const", "wo"]))?;
    let others: Vec<u16> = [5, 6, 7, 0x1B].into_iter().filter(|&other| other != entry.data_type).collect();
    let other = format!("0x{:04X}", dice.of(&others));
    put(eds, &[entry], dice, "DataType", &other)
}

fn access(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (from, to) = dice.of(&[("ro", "rw"), ("ro", "wo"), ("rw", "wo")]);
    let entries = entries(eds, &[from]);
    put(eds, &entries, dice, "AccessType", to)
}

fn access_less(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (mut entries, less) = (entries(eds, &["rw"]), dice.of(&["ro", "const"]));
    // The standard allows most others to be fixed.
    entries.retain(|entry| matches!(entry.index, 0x1006 | 0x1007 | 0x1010..=0x1012 | 0x1015..=0x1017 | 0x1020));
    put(eds, &entries, dice, "AccessType", less)
}

fn mapping(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let mut entries: Vec<Entry> = eds.entries();
    entries.retain(|entry| {
        matches!(entry.index, 0x1000..=0x1EFF)
            && !matches!(entry.index, 0x1001 | 0x1002 | 0x1013 | 0x1026 | 0x1200..=0x12FF)
    });
    put(eds, &entries, dice, "PDOMapping", "1")
}

fn range(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (index, sub, low, high) = dice.of(&[
        (0x1019, None, 241, 255),
        (0x1029, Some(1), 3, 255),
        (0x1201, Some(3), 128, 255),
        (0x1800, Some(6), 241, 255),
        (0x1016, Some(1), 0x0100_0000, 0xFFFF_FFFF),
        (0x1A00, Some(0), 65, 253),
    ]);
    let name = sub.map_or(format!("{index:04X}"), |sub| format!("{index:04X}sub{sub}"));
    let data_type = if high > 255 { 7 } else { 5 };
    if sub.is_some() && eds.header(&name[..4]).is_none() {
        eds.add(&format!("[{}]\nParameterName=Values\nObjectType=0x9\nSubNumber=1\n", &name[..4]));
    }
    let header = eds.header(&name).unwrap_or_else(|| {
        eds.add(&format!(
            "[{name}]\nParameterName=Value\nObjectType=0x7\nDataType=0x{data_type:04X}\nAccessType=rw\nPDOMapping=0\n"
        ))
    });
    Some(Place::Line(eds.put(header, "DefaultValue", dice.between(low, high))))
}

fn missing(eds: &mut Eds, prefix: &str) -> Option<Place> {
    eds.remove_all(prefix);
    Some(Place::File)
}

fn companion(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (index, needed) = dice.of(&[
        ("1007", "1005"),
        ("1006", "1005"),
        ("1019", "1005"),
        ("100C", "100D"),
        ("100D", "100C"),
        ("1011", "1010"),
        ("1015", "1014"),
    ]);
    eds.remove_all(needed);
    // The name of an object with sub-indexes is that of sub-index 0.
    let header = eds.header(&format!("{index}sub0")).or_else(|| eds.header(index))?;
    Some(Place::Line(header))
}

fn number(eds: &Eds, name: &str) -> Option<u64> {
    eds.number_of(eds.header(name)?, "DefaultValue")
}

fn set(eds: &mut Eds, name: &str, value: u64) -> Option<Place> {
    let header = eds.header(name)?;
    Some(Place::Line(eds.put(header, "DefaultValue", value)))
}

/// The type of a rotary encoder; `None` for other devices.
fn is_rotary(eds: &Eds) -> Option<u64> {
    let kind = number(eds, "1000").filter(|kind| kind & 0xFFFF == 406)? >> 16;
    Some(kind).filter(|kind| matches!(kind, 1 | 2))
}

fn revolutions(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let wrong = if is_rotary(eds)? == 1 { dice.between(2, 4096) } else { dice.between(0, 1) };
    set(eds, "6502", wrong)
}

/// Sets the default of an object to more than `most`, or its high limit if the objects that bound it are constant.
fn beyond(eds: &mut Eds, dice: &mut Dice, name: &str, most: u64, bounds: &[&str]) -> Option<Place> {
    let access = |bound: &&str| eds.text_of(eds.header(bound)?, "AccessType");
    let is_const = bounds.iter().all(|bound| access(bound) == Some("const"));
    let field = if is_const { dice.of(&["DefaultValue", "HighLimit"]) } else { "DefaultValue" };
    // The highest values of the data types do not count as limits.
    let value = dice.between(most + 1, 0x7FFF_FFFE);
    let header = eds.header(name)?;
    Some(Place::Line(eds.put(header, field, value)))
}

fn measuring_range(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    is_rotary(eds)?;
    let positions = number(eds, "6501")? * number(eds, "6502")?;
    if positions >= 0x7FFF_0000 {
        return None;
    }
    beyond(eds, dice, "6002", positions, &["6501", "6502"])
}

fn units(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    is_rotary(eds)?;
    let steps = number(eds, "6501")?;
    beyond(eds, dice, "6001", steps, &["6501"])
}

fn preset(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    is_rotary(eds)?;
    let range = number(eds, "6002").filter(|range| (1..0x7FFF_0000).contains(range))?;
    beyond(eds, dice, "6003", range - 1, &["6002"])
}
