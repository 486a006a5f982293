//! Names: each is unique, and no standard object has the name of another one.

use super::Check;
use crate::dictionary::names::{StandardObject, in_area, standard_object};
use crate::dictionary::object::Object;
use crate::dictionary::rules::{field, standard};
use crate::identity::{Multiplexer, SubIndex};
use std::collections::HashSet;

pub(super) fn check(check: &mut Check<'_>) {
    let mut known = HashSet::with_capacity(check.description.dictionary.objects().len());
    let mut is_told = false;
    let profile = check.description.device_profile();
    for object in check.description.dictionary.objects() {
        is_told = is_told || once(check, object, &mut known);
        entries_once(check, object);
        if let Some(own) = standard_object(object.index, profile) {
            name_of_another(check, object, own, profile);
            entries_of_another(check, object, own);
        }
    }
}

/// Names are compared without case and separators.
fn canonical(name: &str) -> String {
    if name.is_ascii() {
        let letters = name.bytes().filter(u8::is_ascii_alphanumeric);
        return letters.map(|letter| char::from(letter.to_ascii_lowercase())).collect();
    }
    name.chars().filter(|character| character.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Reports an object with the name of an earlier one.
fn once(check: &mut Check<'_>, object: &Object, known: &mut HashSet<String>) -> bool {
    let name = canonical(&object.name);
    let is_repeated = !name.is_empty() && !known.insert(name);
    if is_repeated {
        let expected = "an object with a name of its own";
        check.report_object(object, "ParameterName", &field::NAME_TWICE, expected, &object.name);
    }
    is_repeated
}

/// Reports the first entry with the name of an earlier one.
fn entries_once(check: &mut Check<'_>, object: &Object) {
    if object.entries().len() < 2 {
        return;
    }
    let mut known = HashSet::new();
    let is_own = |entry: &&crate::dictionary::object::Entry| entry.line != object.line;
    for entry in object.entries().iter().filter(is_own) {
        let name = canonical(&entry.name);
        if !name.is_empty() && !known.insert(name) {
            let at = Multiplexer { index: object.index, sub: entry.sub };
            let expected = "a sub-index with a name of its own";
            check.report(at, "ParameterName", &field::NAME_TWICE, expected, &entry.name);
            return;
        }
    }
}

fn name_of_another(check: &mut Check<'_>, object: &Object, own: &StandardObject, profile: Option<u16>) {
    let name = canonical(&object.name);
    if name.is_empty() || name == canonical(own.name) {
        return;
    }
    let other = in_area(object.index, profile).iter().find(|other| canonical(other.name) == name);
    if let Some(other) = other {
        let found = format!("{}, the name of {:04X}h", object.name, other.first);
        check.report_object(object, "ParameterName", &standard::NAME, "a name that is not another object's", &found);
    }
}

fn entries_of_another(check: &mut Check<'_>, object: &Object, own: &StandardObject) {
    for entry in object.entries().iter().filter(|_| !own.code.is_single() && !object.code.is_single()) {
        let name = canonical(&entry.name);
        let is_own = |of: SubIndex| {
            own.entries.iter().any(|it| (it.first..=it.last).contains(&of.0) && canonical(it.name) == name)
        };
        if name.is_empty() || is_own(entry.sub) {
            continue;
        }
        let other = own.entries.iter().find(|it| it.first == it.last && canonical(it.name) == name);
        if let Some(other) = other {
            let found = format!("{}, the name of sub-index {:02X}h", entry.name, other.first);
            let at = Multiplexer { index: object.index, sub: entry.sub };
            check.report(at, "ParameterName", &standard::NAME, "a name that is not another sub-index's", &found);
        }
    }
}
