//! `MandatoryObjects`, `OptionalObjects`, `ManufacturerObjects`: the lists of objects, compared with the
//! descriptions.

use crate::object;
use std::collections::HashSet;

use super::fields::Fields;
use super::number;
use crate::dictionary::description::ObjectLists;
use crate::dictionary::object::ObjectDictionary;
use crate::dictionary::place::Place;
use crate::dictionary::problem::Problems;
use crate::dictionary::rules;
use crate::dictionary::source::{Field, FieldName, Section, SectionName, Source, canonical};
use crate::identity::Index;

const LISTS: [&str; 3] = ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"];

/// Reads the lists of the source, and compares them with the described objects.
pub(super) fn read(source: &Source<'_>, dictionary: &ObjectDictionary, problems: &mut Problems) -> ObjectLists {
    let [mandatory, optional, manufacturer] = LISTS.map(|name| match source.section(name) {
        Some(section) => numbered(section, FieldName::SupportedObjects, problems)
            .into_iter()
            .map(|(number, line)| (Index(number), line))
            .collect(),
        None => Vec::new(),
    });
    let lists = ObjectLists { mandatory, optional, manufacturer };
    check(&lists, source, dictionary, problems);
    lists
}

/// The numbers in the fields `1=…`, `2=…`, each with its line, sorted by the number of the field. `count` is the field
/// that states how many of these fields there are.
pub(super) fn numbered(section: Section<'_>, count: FieldName, problems: &mut Problems) -> Vec<(u16, u32)> {
    let mut numbers = Vec::new();
    for field in section.fields() {
        if field.name().eq_ignore_ascii_case(count.text()) {
            continue;
        }
        let Ok(key) = field.name().parse::<u32>() else {
            let expected = "a number as the name of the field";
            problems.report(field.place_of_name(), &rules::list::KEY, expected, field.name());
            continue;
        };
        let number = number::parse(field.value()).filter(|number| !number.plus_node_id);
        let number = number.and_then(|number| u16::try_from(number.value).ok());
        if number.is_none() {
            problems.report(field.place(), &rules::number::UNREADABLE, "a number of 16 bits", field.value());
        }
        numbers.push((key, number, field));
    }
    let is_descending = |pair: &&[(u32, _, _)]| matches!(pair, [(one, ..), (next, ..)] if one > next);
    if let Some([_, (key, _, field)]) = numbers.windows(2).find(is_descending) {
        let name = key.to_string();
        let place = Place { field: &name, ..field.place_of_name() };
        problems.report(place, &rules::list::ORDER, "entries in the order of their numbers", &name);
    }
    numbers.sort_by_key(|&(key, ..)| key);
    let mut next = 1;
    for (key, _, field) in &numbers {
        if *key != next {
            let (name, expected) = (key.to_string(), "numbers without a gap, from 1");
            let place = Place { field: &name, ..field.place_of_name() };
            problems.report(place, &rules::list::GAP, expected, &name);
        }
        next = key.saturating_add(1);
    }
    let numbers = numbers.into_iter().filter_map(|(_, number, field)| Some((number?, field.line())));
    let numbers: Vec<(u16, u32)> = numbers.collect();
    let mut fields = Fields { section, problems };
    let announced = fields.number(count, u32::MAX).unwrap_or(0);
    if announced as usize != numbers.len() {
        let found = format!("{} entries", numbers.len());
        fields.report(count, &rules::list::COUNT, "the number of entries", &found);
    }
    numbers
}

/// The list to which an object belongs by its index.
pub(in crate::dictionary) const fn list_of(index: u16) -> &'static str {
    match index {
        object::DEVICE_TYPE | object::ERROR_REGISTER | object::IDENTITY => LISTS[0],
        0x2000..=0x5FFF => LISTS[2],
        _ => LISTS[1],
    }
}

/// Checks that every object in `[xxxxObjectLinks]` is described, and that `ObjectLinks` is their number.
pub(super) fn check_links(source: &Source<'_>, dictionary: &ObjectDictionary, problems: &mut Problems) {
    for section in source.sections() {
        let is_links =
            matches!(section.about(), SectionName::Beside(_)) && canonical(section.name()).ends_with("objectlinks");
        if !is_links {
            continue;
        }
        let links: Vec<_> = section.fields().filter(|field| field.name().parse::<u32>().is_ok()).collect();
        let mut fields = Fields { section, problems };
        if fields.number(FieldName::ObjectLinks, u32::MAX).is_some_and(|announced| announced as usize != links.len()) {
            let found = format!("{} entries", links.len());
            fields.report(FieldName::ObjectLinks, &rules::list::BESIDE, "the number of entries", &found);
        }
        for field in links {
            let linked = number::parse(field.value()).and_then(|number| u16::try_from(number.value).ok());
            if linked.is_none_or(|index| dictionary.object(Index(index)).is_none()) {
                let place = field.place();
                problems.report(place, &rules::list::LINK, "an object that is described", field.value());
            }
        }
    }
}

fn check(lists: &ObjectLists, source: &Source<'_>, dictionary: &ObjectDictionary, problems: &mut Problems) {
    let mut listed = HashSet::new();
    for (position, list) in [&lists.mandatory, &lists.optional, &lists.manufacturer].into_iter().enumerate() {
        let section = LISTS.get(position).copied().unwrap_or_default();
        for (number, &(index, line)) in (1..).zip(list) {
            let mut report = |rule, expected| {
                let field = u32::to_string(&number);
                let place = source.field_in(line).map_or(Place::line(line), Field::place);
                let place = Place { section, field: &field, ..place };
                problems.report(place, rule, expected, &index.to_string());
            };
            if !listed.insert(index) {
                report(&rules::list::TWICE, "an object in one list, once");
            }
            if dictionary.object(index).is_none() {
                report(&rules::list::UNDESCRIBED, "a section of each listed object");
            }
            // 1018h is mandatory only since CiA 301 version 4.0.
            let may_be_optional = index.0 == object::IDENTITY && position == 1;
            if section != list_of(index.0) && !may_be_optional {
                report(&rules::list::WRONG, "mandatory, optional and manufacturer objects in their own lists");
            }
        }
    }
    for object in dictionary.objects() {
        if !listed.contains(&object.index) && object.line != 0 {
            let section = format!("{:04X}", object.index.0);
            let place = Place { section: &section, ..Place::line(object.line) };
            let expected = "each object in a list";
            problems.report(place, &rules::list::UNLISTED, expected, &object.index.to_string());
        }
    }
}
