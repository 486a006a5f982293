//! Compares the object dictionaries with the tables of the manuals as printed: `*-printed.csv` holds the cells, one
//! column for each model. The tests read every row from the simulated device by SDO. `*-errata.csv` lists all
//! differences with their reasons.

use crate::bench::Bench;
use canvass_analyzer::dictionary::Entry;
use canvass_device::models::Model;
use std::collections::{BTreeMap, BTreeSet};

/// A row of a printed table, with the cell of one model.
struct PrintedRow<'a> {
    index: u16,
    /// The sub-index; `None` if the row is about the whole object.
    sub: Option<u8>,
    data_type: &'a str,
    access: &'a str,
    cell: &'a str,
}

/// The first line that is no comment, and the following lines; each split into columns.
fn lines(text: &str) -> (Vec<&str>, Vec<Vec<&str>>) {
    let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(';').collect());
    (lines.next().unwrap(), lines.collect())
}

fn table<'a>(text: &'a str, model: &str) -> Vec<PrintedRow<'a>> {
    let (head, lines) = lines(text);
    let column = head.iter().position(|name| *name == model).unwrap();
    let row = |line: Vec<&'a str>| {
        assert_eq!(line.len(), head.len(), "{line:?}");
        let sub = (!line[1].is_empty()).then(|| u8::from_str_radix(line[1], 16).unwrap());
        let index = u16::from_str_radix(line[0], 16).unwrap();
        PrintedRow { index, sub, data_type: line[2], access: line[3], cell: line[column] }
    };
    lines.into_iter().map(row).collect()
}

/// The node-ID for models that are delivered without one.
const NODE: u8 = 63;

struct Comparison {
    model: &'static Model,
    bench: Bench,
    node: u8,
    /// The differences found, such as `5000h:00 type: INTEGER16, not UNSIGNED16`.
    differences: BTreeSet<String>,
}

impl Comparison {
    /// The sub-indexes of an object; without sub-index 0 if the object has others.
    fn subs(&self, index: u16) -> Vec<u8> {
        let all = self.model.description().dictionary.entries();
        let subs: Vec<u8> = all.filter(|(at, _)| at.index.0 == index).map(|(at, _)| at.sub.0).collect();
        if subs.len() > 1 { subs.into_iter().filter(|sub| *sub != 0).collect() } else { subs }
    }

    fn entry(&self, index: u16, sub: u8) -> &'static Entry {
        self.model.description().dictionary.entry(canvass_analyzer::Multiplexer::new(index, sub)).unwrap()
    }

    fn differs(&mut self, index: u16, sub: u8, what: &str, device: &str, printed: &str) {
        if device != printed {
            self.differences.insert(format!("{index:04X}h:{sub:02X};{what};{printed};{device}"));
        }
    }

    /// The value read by SDO, in the notation of the printed cell.
    fn value(&mut self, index: u16, sub: u8, cell: &str) -> String {
        let value = match self.bench.read_bytes_from(self.node, index, sub) {
            Ok(value) => value,
            Err(code) => return format!("abort {code:08X}"),
        };
        if self.entry(index, sub).data_type.bytes().is_none() {
            return String::from_utf8(value).unwrap();
        }
        let number = value.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte));
        // The same number in another notation is no difference.
        if printed_number(cell, self.node) == Some(number) { cell.to_owned() } else { format!("0x{number:X}") }
    }

    /// Compares a row about the whole object. With `has_rows` its sub-indexes have rows of their own.
    fn object(&mut self, row: &PrintedRow<'_>, has_rows: bool) {
        let subs = self.subs(row.index);
        match (row.cell, subs.is_empty()) {
            ("" | "no", true) => return,
            ("" | "no", false) => return self.differs(row.index, 0, "object", "there", row.cell),
            (cell, true) => return self.differs(row.index, 0, "object", "not there", cell),
            _ => {}
        }
        for &sub in &subs {
            let entry = self.entry(row.index, sub);
            if !row.data_type.is_empty() {
                let expected = of_record(row.data_type, row.index, sub).unwrap_or(row.data_type).to_owned();
                self.differs(row.index, sub, "type", &entry.data_type.to_string(), &expected);
            }
            if !row.access.is_empty() {
                self.differs(row.index, sub, "access", entry.access.name(), row.access);
            }
        }
        let is_mapping = row.data_type == "PDOMapping";
        for (&sub, cell) in subs.iter().zip(row.cell.split(' ').cycle()) {
            if cell != "x" && !is_mapping && !has_rows {
                let value = self.value(row.index, sub, cell);
                self.differs(row.index, sub, "default", &value, cell);
            }
        }
        if is_mapping && row.cell != "x" {
            let entries: Vec<&str> = row.cell.split(' ').filter(|cell| *cell != "0").collect();
            let count = self.value(row.index, 0, &entries.len().to_string());
            self.differs(row.index, 0, "default", &count, &entries.len().to_string());
            for (sub, cell) in (1..).zip(entries) {
                let value = self.value(row.index, sub, cell);
                self.differs(row.index, sub, "default", &value, cell);
            }
        }
    }

    /// Compares a row about one sub-index.
    fn sub(&mut self, row: &PrintedRow<'_>, sub: u8) {
        let all = self.model.description().dictionary.entries();
        let is_there = all.into_iter().any(|(at, _)| (at.index.0, at.sub.0) == (row.index, sub));
        match (row.cell, is_there) {
            ("no", true) => self.differs(row.index, sub, "object", "there", "no"),
            ("no" | "", _) | ("x", true) => {}
            (cell, false) => self.differs(row.index, sub, "object", "not there", cell),
            (cell, true) => {
                let value = self.value(row.index, sub, cell);
                self.differs(row.index, sub, "default", &value, cell);
            }
        }
    }
}

/// The data type of a member of a record of CiA 301; `None` for other objects. The manuals print `PDOComPar` for 1018h
/// (Identity) too.
fn of_record(data_type: &str, index: u16, sub: u8) -> Option<&'static str> {
    match (data_type, index, sub) {
        ("PDOMapping", ..) | ("PDOComPar", 0x1018, _) | ("PDOComPar", 0x1800.., 1) => Some("UNSIGNED32"),
        ("PDOComPar", 0x1800.., 2) => Some("UNSIGNED8"),
        ("PDOComPar", 0x1800.., _) => Some("UNSIGNED16"),
        _ => None,
    }
}

fn printed_number(cell: &str, node: u8) -> Option<u64> {
    let term = |text: &str| match text.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16).ok(),
        None if text == "$NODEID" => Some(u64::from(node)),
        None => text.parse().ok(),
    };
    cell.split('+').map(term).sum()
}

/// The known differences of a model, with their reasons.
fn errata(text: &str, model: &str) -> BTreeMap<String, String> {
    let mut known = BTreeMap::new();
    for line in lines(text).1 {
        let [models, at, what, printed, device, reason] = line[..] else { panic!("six columns: {line:?}") };
        assert!(!reason.is_empty(), "{line:?}");
        if models.split(' ').any(|name| name == model) {
            known.insert(format!("{at};{what};{printed};{device}"), reason.to_owned());
        }
    }
    known
}

fn compare(id: &str, printed: &str, known: &str) {
    let model = Model::by_id(id).unwrap();
    let node = model.default_node().map_or(NODE, |node| node.raw());
    let (bench, _) = Bench::started(id, node);
    let mut comparison = Comparison { model, bench, node, differences: BTreeSet::new() };
    let rows = table(printed, id);
    let mut absent = BTreeSet::new();
    for row in &rows {
        match row.sub {
            None => {
                let rows = rows.iter().filter(|other| other.index == row.index && other.sub.is_some());
                comparison.object(row, rows.filter(|row| !matches!(row.cell, "x" | "no")).count() > 0);
                if comparison.subs(row.index).is_empty() {
                    absent.insert(row.index);
                }
            }
            Some(sub) if !absent.contains(&row.index) => comparison.sub(row, sub),
            Some(_) => assert!(matches!(row.cell, "no" | ""), "{:04X}h has no such sub-index", row.index),
        }
    }
    let listed: BTreeSet<u16> = rows.iter().map(|row| row.index).collect();
    for (at, _) in model.description().dictionary.entries() {
        if !listed.contains(&at.index.0) {
            comparison.differs(at.index.0, at.sub.0, "object", "there", "not in the table");
        }
    }
    let known = errata(known, id);
    let new: Vec<&String> = comparison.differences.iter().filter(|found| !known.contains_key(*found)).collect();
    let gone: Vec<&String> = known.keys().filter(|known| !comparison.differences.contains(*known)).collect();
    assert!(new.is_empty() && gone.is_empty(), "{id}: differs\n{new:#?}\ndoes not differ\n{gone:#?}");
}

macro_rules! printed {
    ($($name:ident, $id:literal, $table:literal;)*) => {
        $(
            #[test]
            fn $name() {
                compare($id, include_str!(concat!($table, "-printed.csv")), include_str!(concat!($table, "-errata.csv")));
            }
        )*
    };
}

printed! {
    sendix_58x8, "kuebler-sendix-58x8", "sendix";
    sendix_f58, "kuebler-sendix-f58", "sendix";
    sendix_m58, "kuebler-sendix-m58", "sendix";
    sendix_f58m, "kuebler-sendix-f58m", "sendix";
    c100, "kuebler-c100", "draw-wire";
    d125, "kuebler-d125", "draw-wire";
}
