//! Compares the object dictionaries with the tables of the manuals, which `tests/manuals/*.csv` holds: every row is
//! read by SDO from the simulated device, and the device has no other objects.

use crate::rig::{Rig, parse};
use canvass_analyzer::dictionary::DataType;
use canvass_device::Faults;
use canvass_device::Motion;
use canvass_device::models::Model;
use std::collections::BTreeSet;

struct SheetRow<'a> {
    index: u16,
    sub: u8,
    data_type: &'a str,
    access: &'a str,
    default: &'a str,
}

fn rows(table: &str) -> Vec<SheetRow<'_>> {
    let lines = table.lines().filter(|line| !line.starts_with('#') && !line.starts_with("index;"));
    let rows = lines.map(|line| {
        let [index, sub, _, data_type, access, default] = line.split(';').collect::<Vec<_>>()[..] else {
            panic!("six columns: {line}");
        };
        let (index, sub) = (u16::from_str_radix(index, 16).unwrap(), u8::from_str_radix(sub, 16).unwrap());
        SheetRow { index, sub, data_type, access, default }
    });
    rows.collect()
}

fn data_type(name: &str) -> DataType {
    match name {
        "UNSIGNED8" => DataType::UNSIGNED8,
        "UNSIGNED16" => DataType::UNSIGNED16,
        "UNSIGNED32" => DataType::UNSIGNED32,
        "UNSIGNED64" => DataType::UNSIGNED64,
        "INTEGER16" => DataType::INTEGER16,
        "INTEGER32" => DataType::INTEGER32,
        "VISIBLE_STRING" => DataType::VISIBLE_STRING,
        name => panic!("{name}"),
    }
}

fn number(text: &str, node: u8) -> u64 {
    let text = text.strip_prefix("$NODEID+").map_or((text, 0), |rest| (rest, u64::from(node)));
    let (text, node) = text;
    let number = text.strip_prefix("0x").map_or_else(|| text.parse(), |hex| u64::from_str_radix(hex, 16));
    number.unwrap() + node
}

/// Reads an object by SDO, in segments if the value is long.
fn upload(rig: &mut Rig, node: u8, index: u16, sub: u8) -> Result<Vec<u8>, String> {
    let mut ask = |bytes: String| {
        let heard = rig.ask(&format!("{:03X}#{bytes}", 0x600 + u16::from(node)));
        let prefix = format!("{:03X}#", 0x580 + u16::from(node));
        let response = heard.iter().find(|frame| frame.starts_with(&prefix)).ok_or("silence")?;
        Ok::<Vec<u8>, String>(parse(response).data().to_vec())
    };
    let [low, high] = index.to_le_bytes();
    let first = ask(format!("40{low:02X}{high:02X}{sub:02X}00000000"))?;
    match first[0] {
        0x80 => Err(format!("{:02X?}", &first[4..])),
        0x41 => {
            let (mut value, mut toggle) = (Vec::new(), 0);
            loop {
                let segment = ask(format!("{:02X}00000000000000", 0x60 | toggle))?;
                value.extend(&segment[1..8 - usize::from(segment[0] >> 1 & 7)]);
                toggle ^= 0x10;
                if segment[0] & 1 == 1 {
                    return Ok(value);
                }
            }
        }
        command => Ok(first[4..8 - usize::from(command >> 2 & 3)].to_vec()),
    }
}

/// The access type of an object, by the answer to a download of its present value.
fn access(rig: &mut Rig, node: u8, row: &SheetRow<'_>, value: &[u8]) -> &'static str {
    let [low, high] = row.index.to_le_bytes();
    let mut data = value.to_vec();
    let command = 0x23 | (4 - data.len() as u8) << 2;
    data.resize(4, 0);
    let frame = format!("{:03X}#{command:02X}{low:02X}{high:02X}{:02X}", 0x600 + u16::from(node), row.sub);
    let frame = data.iter().fold(frame, |frame, byte| format!("{frame}{byte:02X}"));
    let read_only = format!("80{low:02X}{high:02X}{:02X}02000106", row.sub);
    let refused = rig.ask(&frame).iter().any(|answer| answer.ends_with(&read_only));
    if refused { "read-only" } else { "writable" }
}

fn compare(model: &'static Model, table: &str) {
    let node = model.default_node().map_or(63, |node| node.raw());
    let mut rig = Rig::powered(model, Some(node), Faults::NONE, &Motion::still(0x4CBA));
    rig.run(300);
    let mut wrong = Vec::new();
    let rows = rows(table);
    for row in &rows {
        let (at, expected) = (format!("{:04X}h:{:02X}", row.index, row.sub), data_type(row.data_type));
        let value = match upload(&mut rig, node, row.index, row.sub) {
            Ok(value) => value,
            // The entry of the error history is still empty.
            Err(abort) if row.index == 0x1003 && abort == "[24, 00, 00, 08]" => continue,
            Err(abort) => {
                wrong.push(format!("{at}: {abort}"));
                continue;
            }
        };
        let entry =
            model.description().dictionary.entry(canvass_analyzer::Multiplexer::new(row.index, row.sub)).unwrap();
        if entry.data_type != expected || expected.bytes().is_some_and(|bytes| bytes != value.len()) {
            wrong.push(format!("{at}: {} expected, {} bytes found", row.data_type, value.len()));
        }
        let as_printed = match expected {
            _ if row.default.is_empty() => true,
            DataType::VISIBLE_STRING => value == row.default.as_bytes(),
            // M58 has FFh until its node-ID is configured, which this test has done.
            _ if row.index == 0x2101 && row.default == "0xFF" => value == [node],
            _ => {
                let found = value.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte));
                found == number(row.default, node)
            }
        };
        if !as_printed {
            wrong.push(format!("{at}: {} expected, {value:02X?} found", row.default));
        }
        if value.len() <= 4 {
            let expected = if row.access == "rw" { "writable" } else { "read-only" };
            let found = access(&mut rig, node, row, &value);
            if found != expected {
                wrong.push(format!("{at}: {} expected, {found} found", row.access));
            }
        }
    }
    assert!(wrong.is_empty(), "{}: {}:\n{}", model.id(), wrong.len(), wrong.join("\n"));
    let described: BTreeSet<(u16, u8)> =
        model.description().dictionary.entries().map(|(at, _)| (at.index.0, at.sub.0)).collect();
    let printed: BTreeSet<(u16, u8)> = rows.iter().map(|row| (row.index, row.sub)).collect();
    assert_eq!(described, printed, "{}", model.id());
}

/// The columns of a table in the form that these tests read; those of other forms are read in `tests/manuals`.
const COLUMNS: &str = "index;sub;name;type;access;default";

#[test]
fn models_have_the_objects_of_the_tables_in_their_manuals() {
    let mut compared = 0;
    for model in Model::all() {
        let path = format!("{}/tests/manuals/{}.csv", env!("CARGO_MANIFEST_DIR"), model.id());
        let Ok(table) = std::fs::read_to_string(path) else { continue };
        if table.lines().any(|line| line == COLUMNS) {
            compare(model, &table);
            compared += 1;
        }
    }
    assert!(compared >= 6, "{compared} tables");
}
