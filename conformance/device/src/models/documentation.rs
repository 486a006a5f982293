//! Compares `docs/models.md` with the keys that the program reads from a sheet, and with the existing sheets.

use super::FILES;
use super::annotations::{Bit, Choice, Mapped, Redundant, Signal, State, Unused};
use super::deviations::DeviationTables;
use super::emergency::{Emergency, Field};
use super::network::{Network, StartUp};
use super::quirks::Quirks;
use super::recognition::{Number, Recognition, Text};
use super::rules::{Check, Link};
use super::sheet::{BitRate, CheckedRow, LmtAddress, Sheet, Storage, Timing, Value};
use serde::de::{Deserialize, Deserializer, Error, Visitor, value};
use std::collections::BTreeSet;
use toml::Table;

const DOCUMENT: &str = include_str!("../../../../docs/models.md");

/// A deserializer that notes the field names of a struct, and gives the struct no values.
struct Curious<'a>(&'a mut Vec<&'static str>);

impl<'de> Deserializer<'de> for Curious<'_> {
    type Error = value::Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, value::Error> {
        Err(Error::custom("not a struct"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, value::Error> {
        self.0.extend(fields);
        Err(Error::custom("only the names are of interest"))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
        seq tuple tuple_struct map enum identifier ignored_any
    }
}

pub(crate) fn fields_of<T: Deserialize<'static>>() -> Vec<&'static str> {
    let mut fields = Vec::new();
    assert!(T::deserialize(Curious(&mut fields)).is_err() && !fields.is_empty());
    fields
}

/// Whether the document names the key in backquotes, alone or as the name of a table.
pub(crate) fn is_documented(key: &str) -> bool {
    ["`KEY`", "`[KEY]`", "`[[KEY]]`"].iter().any(|form| DOCUMENT.contains(&form.replace("KEY", key)))
}

#[test]
fn every_key_that_is_read_is_documented() {
    let fields = [
        fields_of::<Sheet>(),
        fields_of::<Network>(),
        fields_of::<StartUp>(),
        fields_of::<Recognition>(),
        fields_of::<Number>(),
        fields_of::<Text>(),
        fields_of::<BitRate>(),
        fields_of::<Timing>(),
        fields_of::<Storage>(),
        fields_of::<Value>(),
        fields_of::<Link>(),
        fields_of::<Check>(),
        fields_of::<Emergency>(),
        fields_of::<Field>(),
        fields_of::<LmtAddress>(),
        fields_of::<Quirks>(),
        fields_of::<Signal>(),
        fields_of::<Choice>(),
        fields_of::<Bit>(),
        fields_of::<Mapped>(),
        fields_of::<Redundant>(),
        fields_of::<CheckedRow>(),
        fields_of::<State>(),
        fields_of::<Unused>(),
        fields_of::<DeviationTables>(),
    ];
    let missing: Vec<&str> = fields.concat().into_iter().filter(|field| !is_documented(field)).collect();
    assert!(missing.is_empty(), "docs/models.md does not explain {missing:?}");
}

fn collect(table: &Table, keys: &mut BTreeSet<String>) {
    for (key, value) in table {
        keys.insert(key.clone());
        let inner = value.as_table().into_iter();
        let rows = value.as_array().into_iter().flatten().filter_map(toml::Value::as_table);
        inner.chain(rows).for_each(|table| collect(table, keys));
    }
}

#[test]
fn every_key_of_the_sheets_is_documented() {
    let mut keys = BTreeSet::new();
    for (_, sheet) in FILES {
        collect(&sheet.parse().unwrap(), &mut keys);
    }
    assert!(keys.len() > 80);
    let missing: Vec<&String> = keys.iter().filter(|key| !is_documented(key)).collect();
    assert!(missing.is_empty(), "docs/models.md does not explain {missing:?}");
}
