//! Compares the object dictionaries with the tables of the manuals, object by object. Each model has a CSV file whose
//! first line names the columns. The tests read all objects by SDO.

use crate::bench::Bench;
use canvass_analyzer::dictionary::DataType;
use canvass_device::models::Model;
use std::collections::BTreeSet;

/// A row of a manual's table.
struct DictionaryRow<'a> {
    index: u16,
    sub: u8,
    data_type: &'a str,
    access: &'a str,
    default: &'a str,
}

impl<'a> DictionaryRow<'a> {
    fn new(line: &'a str) -> Self {
        let columns: Vec<&str> = line.split(';').map(str::trim).collect();
        let [index, sub, _, data_type, access, default, ..] = columns.as_slice() else { panic!("{line}") };
        let (index, sub) = (u16::from_str_radix(index, 16).unwrap(), u8::from_str_radix(sub, 16).unwrap());
        Self { index, sub, data_type, access, default }
    }

    fn data_type(&self) -> DataType {
        let types = [
            DataType::UNSIGNED8,
            DataType::UNSIGNED16,
            DataType::UNSIGNED32,
            DataType::INTEGER32,
            DataType::VISIBLE_STRING,
        ];
        types
            .into_iter()
            .find(|known| known.to_string() == self.data_type)
            .unwrap_or_else(|| panic!("{}", self.data_type))
    }

    /// The bytes of the default for node-ID 1.
    fn value(&self) -> Option<Vec<u8>> {
        if self.default.is_empty() {
            return None;
        }
        let Some(length) = self.data_type().bytes() else { return Some(self.default.as_bytes().to_vec()) };
        let term = |text: &str| match (text, text.strip_prefix("0x")) {
            ("$NODEID", _) => 1,
            (_, Some(digits)) => u64::from_str_radix(digits, 16).unwrap(),
            (digits, None) => digits.parse().unwrap(),
        };
        let number: u64 = self.default.split('+').map(term).sum();
        Some(number.to_le_bytes()[..length].to_vec())
    }
}

fn table(model: &str) -> String {
    std::fs::read_to_string(format!("{}/tests/manuals/{model}.csv", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Whether this is sub-index 0 of an object whose other sub-indexes the manual lists: the manual does not print such
/// entries, but the device must have them.
fn is_implied(index: u16, sub: u8, listed: &BTreeSet<(u16, u8)>) -> bool {
    sub == 0 && listed.iter().any(|(other, _)| *other == index)
}

fn check(id: &str, entries: usize) {
    let text = table(id);
    let rows = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).skip(1).map(DictionaryRow::new);
    let model = Model::by_id(id).unwrap();
    let mut bench = Bench::new(id);
    let (mut listed, mut wrong) = (BTreeSet::new(), Vec::new());
    for row in rows {
        let at = format!("{:04X}h:{:02X}", row.index, row.sub);
        assert!(listed.insert((row.index, row.sub)), "{at} twice");
        let entry = model.description().dictionary.entry(canvass_analyzer::Multiplexer::new(row.index, row.sub));
        let Ok(entry) = entry else {
            wrong.push(format!("{at} is not described"));
            continue;
        };
        if entry.data_type != row.data_type() || entry.access.name() != row.access {
            wrong.push(format!("{at} is described as {} {}", entry.data_type, entry.access));
        }
        match bench.read_bytes(row.index, row.sub) {
            // The error history is empty.
            Err(0x0800_0024) if row.index == 0x1003 => {}
            Err(code) => wrong.push(format!("{at} can't be read: {code:08X}")),
            Ok(value) => {
                if row.value().is_some_and(|expected| expected != value) {
                    wrong.push(format!("{at} is {value:02X?}, not {:02X?}", row.value()));
                }
                if row.data_type().bytes().is_some_and(|length| length != value.len()) {
                    wrong.push(format!("{at} has {} bytes", value.len()));
                }
            }
        }
        // A read-only object refuses a write of its own value; a writable object accepts it.
        let writable = row.access == "rw";
        let value = bench.read_bytes(row.index, row.sub).unwrap_or_default();
        let plain =
            value.len() <= 4 && !matches!(row.index, 0x1003 | 0x1010 | 0x1011 | 0x1A00..0x1B00 | 0x6001..=0x6003);
        if plain && row.data_type().bytes().is_some() {
            let mut bytes = value.clone();
            bytes.resize(4, 0);
            let number = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            let written = bench.write(row.index, row.sub, number, value.len() as u8);
            if written.is_ok() != writable {
                wrong.push(format!("{at} is {}, and a write gives {written:X?}", row.access));
            }
        }
    }
    for (at, _) in model.description().dictionary.entries() {
        let address = (at.index.0, at.sub.0);
        if !listed.contains(&address) && !is_implied(address.0, address.1, &listed) {
            wrong.push(format!("{at} is not in the manual"));
        }
    }
    assert!(wrong.is_empty(), "{id}:\n{}", wrong.join("\n"));
    assert_eq!(listed.len(), entries, "{id}: rows");
}

#[test]
fn lika_ax58() {
    check("lika-ax58", 49);
}

#[test]
fn tr_c65() {
    check("tr-c65", 48);
}

#[test]
fn tr_lmp30() {
    check("tr-lmp30", 53);
}
