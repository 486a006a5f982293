//! Makes one object with its entries.

use super::{Facts, Guess, access, types, values};
use crate::dictionary::data_type::DataType;
use crate::dictionary::names::{ObjectName, object_name};
use crate::dictionary::object::{Entry, Object, ObjectCode};
use crate::identity::{Index, Multiplexer, SubIndex};
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn describe(facts: &Facts<'_>, index: Index, guesses: &mut BTreeMap<Multiplexer, Vec<Guess>>) -> Object {
    let existing = facts.survey.of(index).filter(|(_, answer)| answer.exists() == Some(true)).map(|(sub, _)| sub);
    let subs: Vec<SubIndex> = existing.collect();
    let (standard, has_subs) = (facts.standard(Multiplexer { index, sub: SubIndex(0) }), facts.has_subs(index));
    let mut entries = Vec::new();
    for sub in subs {
        let at = Multiplexer { index, sub };
        let (entry, guessed) = entry(facts, at, has_subs);
        if !guessed.is_empty() {
            guesses.insert(at, guessed);
        }
        entries.push(entry);
    }
    let code = code(standard, has_subs, &entries);
    let mut object = Object::new(index.0, name_of_object(facts, index), code);
    for mut entry in entries {
        if !has_subs {
            // A VAR's entry has the name of its object.
            entry.name.clone_from(&object.name);
        }
        object.insert(entry);
    }
    object
}

fn entry(facts: &Facts<'_>, at: Multiplexer, has_subs: bool) -> (Entry, Vec<Guess>) {
    let counts = has_subs && at.sub.0 == 0;
    let (data_type, type_guess) = types::of(facts, at, counts);
    let (access, access_guess) = access::of(facts, at, counts);
    let mut entry = Entry::new(at.sub.0, name_of_entry(facts, at), data_type, access);
    entry.pdo_mappable = facts.in_rpdos.contains(&at) || facts.in_tpdos.contains(&at);
    entry.default = values::default(facts, at, data_type, counts);
    (entry, type_guess.into_iter().chain(access_guess).collect())
}

/// The standard's object code, if the device's object has this form; otherwise the code that fits the entries. An array
/// has elements of one type, without gaps.
fn code(standard: Option<ObjectName>, has_subs: bool, entries: &[Entry]) -> ObjectCode {
    let elements = || entries.iter().filter(|entry| entry.sub.0 > 0);
    let types: BTreeSet<DataType> = elements().map(|entry| entry.data_type).collect();
    let is_array = types.len() <= 1 && elements().zip(1..=u8::MAX).all(|(entry, sub)| entry.sub.0 == sub);
    match standard.map(|name| name.object.code) {
        Some(ObjectCode::ARRAY) | None if has_subs => {
            if is_array {
                ObjectCode::ARRAY
            } else {
                ObjectCode::RECORD
            }
        }
        Some(code) if has_subs => code,
        _ if entries.iter().any(|entry| entry.data_type == DataType::DOMAIN) => ObjectCode::DOMAIN,
        _ => ObjectCode::VAR,
    }
}

/// The standard's name, even if the device's object has another form.
fn name_of_object(facts: &Facts<'_>, index: Index) -> String {
    match object_name(Multiplexer { index, sub: SubIndex(0) }, facts.profile) {
        None => format!("Object {index}"),
        Some(name) => numbered(name.object.name, name.number()),
    }
}

fn name_of_entry(facts: &Facts<'_>, at: Multiplexer) -> String {
    match facts
        .standard(at)
        .and_then(|name| Some((name.entry.filter(|entry| !entry.name.is_empty())?, name.entry_number())))
    {
        Some((entry, number)) => numbered(entry.name, number.map(u16::from)),
        None if at.sub.0 == 0 => "Highest sub-index supported".to_owned(),
        None => format!("Sub-index {}", at.sub.0),
    }
}

fn numbered(name: &str, number: Option<u16>) -> String {
    number.map_or_else(|| name.to_owned(), |number| format!("{name} {number}"))
}
