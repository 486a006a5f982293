//! Damage of PDOs and COB-IDs.

use super::{Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::{Eds, number};

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/pdo/pair", Lines(pair)),
    ("eds/pdo/transmission-type", Lines(transmission_type)),
    ("eds/pdo/reserved-sub-index", Lines(reserved_sub)),
    ("eds/pdo/entry-missing", Lines(entry_missing)),
    ("eds/pdo/target", Lines(target)),
    ("eds/pdo/not-mappable", Lines(not_mappable)),
    ("eds/pdo/direction", Lines(direction)),
    ("eds/pdo/either-direction", Lines(either)),
    ("eds/pdo/length", Lines(length)),
    ("eds/pdo/boolean", Lines(boolean)),
    ("eds/pdo/dummy", Lines(dummy)),
    ("eds/pdo/granularity", Lines(granularity)),
    ("eds/pdo/too-long", Lines(too_long)),
    ("eds/cob-id/restricted", Lines(restricted)),
    ("eds/cob-id/twice", Lines(cob_id_twice)),
    ("eds/cob-id/shared", Lines(cob_id_shared)),
    ("eds/cob-id/predefined", Lines(predefined)),
    ("eds/cob-id/first-sdo-server", Lines(first_server)),
];

/// The communication parameters of both directions.
fn communication(eds: &Eds) -> Vec<u16> {
    let indexes = eds.objects().into_iter().map(|(index, _)| index);
    indexes.filter(|index| matches!(index, 0x1400..=0x15FF | 0x1800..=0x19FF)).collect()
}

fn default(eds: &Eds, index: u16, sub: u8) -> Option<usize> {
    eds.field(eds.sub(index, sub)?, "DefaultValue")
}

fn set(eds: &mut Eds, line: usize, value: impl std::fmt::Display) -> Option<Place> {
    eds.set(line, value);
    Some(Place::Line(line))
}

fn pair(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let index = dice.pick(&communication(eds))?;
    let (gone, left) = if dice.heads() { (index, index + 0x200) } else { (index + 0x200, index) };
    eds.remove_all(&format!("{gone:04X}"));
    Some(Place::Line(eds.sub(left, 0)?))
}

fn transmission_type(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let index = dice.pick(&communication(eds))?;
    let reserved = dice.between(241, if index < 0x1800 { 253 } else { 251 });
    let line = default(eds, index, 2)?;
    set(eds, line, reserved)
}

fn reserved_sub(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let tpdos: Vec<u16> = communication(eds).into_iter().filter(|&index| index >= 0x1800).collect();
    let index = dice.pick(&tpdos)?;
    let name = format!("[{index:04X}sub4]");
    Some(Place::Line(eds.add(&format!(
        "{name}\nParameterName=Reserved\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nPDOMapping=0\n"
    ))))
}

fn entry_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (line, ..) = dice.pick(&eds.mapped())?;
    set(eds, line, "")
}

/// The mapped objects, without dummy entries.
fn objects(eds: &Eds) -> Vec<(usize, bool, u32)> {
    eds.mapped().into_iter().filter(|&(.., mapped)| mapped >> 16 > 0x1F).collect()
}

fn target(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (line, _, mapped) = dice.pick(&objects(eds))?;
    // An object that does not exist, or a sub-index that the object lacks.
    let other = if dice.heads() { 0x9FFE_0000 | mapped & 0xFFFF } else { mapped | 0xE000 };
    set(eds, line, format!("0x{other:08X}"))
}

fn not_mappable(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (line, _, mapped) = dice.pick(&objects(eds))?;
    eds.put(eds.target(mapped)?, "PDOMapping", 0);
    Some(Place::Line(line))
}

fn direction(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (line, is_tpdo, mapped) = dice.pick(&objects(eds))?;
    let access = if is_tpdo { dice.of(&["wo", "rww", "wo"]) } else { dice.of(&["ro", "const", "rwr"]) };
    eds.put(eds.target(mapped)?, "AccessType", access);
    Some(Place::Line(line))
}

fn length(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (line, _, mapped) = dice.pick(&objects(eds))?;
    let others: Vec<u32> =
        [0, 1, 4, 8, 16, 24, 32, 64, 65, 255].into_iter().filter(|&bits| bits != mapped & 0xFF).collect();
    set(eds, line, format!("0x{:08X}", mapped & 0xFFFF_FF00 | dice.of(&others)))
}

fn boolean(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let bytes: Vec<_> = objects(eds).into_iter().filter(|&(.., mapped)| mapped & 0xFF == 8).collect();
    let (line, _, mapped) = dice.pick(&bytes)?;
    eds.put(eds.target(mapped)?, "DataType", "0x0001");
    Some(Place::Line(line))
}

fn dummy(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let dummies: Vec<_> = eds.mapped().into_iter().filter(|&(.., mapped)| mapped >> 16 <= 0x1F).collect();
    match dice.below(3) {
        0 => {
            let (line, ..) = dice.pick(&dummies)?;
            let usage = eds.header("DummyUsage")?;
            eds.put(usage, "Dummy0005", 0);
            Some(Place::Line(line))
        }
        1 => {
            let (line, ..) = dice.pick(&dummies)?;
            set(eds, line, "0x00050010")
        }
        _ => {
            let tpdos: Vec<_> = objects(eds).into_iter().filter(|&(_, is_tpdo, _)| is_tpdo).collect();
            let (line, ..) = dice.pick(&tpdos)?;
            set(eds, line, "0x00050008")
        }
    }
}

fn granularity(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (line, _, mapped) = dice.pick(&eds.mapped())?;
    let (line_text, bits) = (eds.lines[line].clone(), u64::from(mapped & 0xFF));
    let wrong: Vec<u64> = (1..=64).filter(|granularity| bits % granularity != 0).collect();
    let device = eds.header("DeviceInfo")?;
    let lines = eds.lines.len();
    eds.put(device, "Granularity", dice.pick(&wrong)?);
    let moved = eds.lines.len() - lines;
    assert_eq!(eds.lines[line + moved], line_text);
    Some(Place::Line(line + moved))
}

/// Maps an object of more than 8 bits in all eight entries, which exceeds 64 bits.
fn too_long(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let long: Vec<_> = objects(eds).into_iter().filter(|&(.., mapped)| mapped & 0xFF > 8).collect();
    let (_, is_tpdo, mapped) = dice.pick(&long)?;
    let parameters: Vec<u16> = communication(eds).into_iter().filter(|index| (*index >= 0x1800) == is_tpdo).collect();
    let index = dice.pick(&parameters)? + 0x200;
    for sub in 1..=8 {
        let line = default(eds, index, sub)?;
        eds.set(line, format!("0x{mapped:08X}"));
    }
    let line = default(eds, index, 0)?;
    set(eds, line, 8)
}

/// The lines of the COB-IDs, in the order in which the rules check them.
fn cob_ids(eds: &Eds) -> Vec<usize> {
    let single = ["1005", "1012", "1014"].iter().filter_map(|name| eds.field(eds.header(name)?, "DefaultValue"));
    single.chain(communication(eds).into_iter().filter_map(|index| default(eds, index, 1))).collect()
}

fn restricted(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = dice.pick(&cob_ids(eds))?;
    let ranges = [(0x000, 0x07F), (0x101, 0x180), (0x581, 0x5FF), (0x601, 0x67F), (0x6E0, 0x6FF), (0x701, 0x7FF)];
    let (first, last) = dice.of(&ranges);
    let cob_id = dice.between(first, last);
    // A DCF has a node-ID of its own, so its COB-IDs have no formula.
    let is_of_a_type = dice.heads() && eds.header("DeviceComissioning").is_none();
    let value =
        if cob_id > 0 && is_of_a_type { format!("$NODEID+0x{:X}", cob_id - 1) } else { format!("0x{cob_id:X}") };
    set(eds, line, value)
}

/// The COB-IDs of a range of communication parameters.
fn cob_ids_of(eds: &Eds, range: std::ops::RangeInclusive<u16>) -> Vec<usize> {
    let indexes = communication(eds).into_iter().filter(|index| range.contains(index));
    indexes.filter_map(|index| default(eds, index, 1)).collect()
}

/// Gives one of the COB-IDs `second` the value of one of the COB-IDs `first`, if the latter is in use.
fn same_cob_id(eds: &mut Eds, dice: &mut Dice, first: &[usize], second: &[usize]) -> Option<Place> {
    let (from, to) = (dice.pick(first)?, dice.pick(second)?);
    let value = eds.value(from).to_owned();
    // Bit 31 means that there is no such communication object.
    let is_used = number(&value.replace("$NODEID+", "")).is_some_and(|value| value >> 31 == 0);
    if is_used && from != to { set(eds, to, value) } else { None }
}

/// EMCY and a TPDO, or two TPDOs, get the same COB-ID.
fn cob_id_twice(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let tpdos = cob_ids_of(eds, 0x1800..=0x19FF);
    let emcy = eds.header("1014").and_then(|header| eds.field(header, "DefaultValue"));
    let first: Vec<usize> = emcy.into_iter().chain(tpdos.first().copied()).collect();
    same_cob_id(eds, dice, &first, tpdos.get(1..)?)
}

/// Two RPDOs, or an RPDO and a TPDO, get the same COB-ID.
fn cob_id_shared(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let rpdos = cob_ids_of(eds, 0x1400..=0x15FF);
    let tpdos = cob_ids_of(eds, 0x1800..=0x19FF);
    let second = if dice.heads() { rpdos.get(1..)?.to_vec() } else { tpdos };
    same_cob_id(eds, dice, rpdos.get(..1)?, &second)
}

fn predefined(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let all = cob_ids(eds);
    // COB-IDs of EMCY and of the first four PDOs of each direction.
    let line = dice.pick(&all[2..])?;
    let other = dice.of(&["$NODEID+0x190", "$NODEID+0x680", "0x6F0", "$NODEID+0x90"]);
    set(eds, line, other)
}

/// Gives an object that may be mapped an access type that does not tell the direction of the PDO.
fn either(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let mut mappable = eds.entries();
    mappable.retain(|entry| eds.number_of(entry.header, "PDOMapping") == Some(1));
    let header = dice.pick(&mappable)?.header;
    Some(Place::Line(eds.put(header, "AccessType", "rw")))
}

fn first_server(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = default(eds, 0x1200, dice.between(1, 2) as u8)?;
    let (other, id) = (dice.between(1, 0x57F), dice.between(0x680, 0x7FF));
    let forms = [format!("$NODEID+0x{other:X}"), format!("0x{id:X}"), "0x80000600".to_owned(), "0x20000600".to_owned()];
    set(eds, line, dice.of(&forms))
}
