//! Consistency of a device description with itself and with the standards, beyond single fields.
//!
//! The checks work on the parsed description, independently of the file's format. Problems of reading are in
//! [`DeviceDescription::problems`].

mod cob_id;
mod companions;
mod identity;
mod naming;
mod pdo;
mod standard;

use super::description::DeviceDescription;
use super::object::{Object, Setting};
use super::place::{Place, SectionId, Spot};
use super::problem::{EdsProblem, Problems};
use super::rules::Rule;
use crate::identity::{Index, Multiplexer, SubIndex};

/// All contradictions, by line.
pub fn check(description: &DeviceDescription) -> Vec<EdsProblem> {
    let mut check = Check { description, problems: Problems::default() };
    identity::check(&mut check);
    pdo::check(&mut check);
    cob_id::check(&mut check);
    standard::check(&mut check);
    naming::check(&mut check);
    companions::check(&mut check);
    let profile = description.device_profile();
    let of_profile = inventory::iter::<OfProfile>.into_iter().filter(|of| profile == Some(of.profile));
    of_profile.for_each(|of| (of.check)(&mut check));
    check.problems.into_sorted()
}

/// A device profile's check of the descriptions of its devices; the profile registers it.
pub(crate) struct OfProfile {
    /// The number of the profile.
    pub profile: u16,
    /// Reports contradictions to the profile.
    pub check: fn(&mut Check<'_>),
}

inventory::collect!(OfProfile);

/// The description under check, and the problems found.
pub(crate) struct Check<'a> {
    pub description: &'a DeviceDescription,
    problems: Problems,
}

impl<'a> Check<'a> {
    /// Reports a problem of an entry, or of its object if the entry is missing.
    pub fn report(&mut self, at: Multiplexer, field: &str, rule: &'static Rule, expected: &'static str, found: &str) {
        let object = self.object(at.index);
        let entry = object.and_then(|object| object.entry(at.sub));
        let place =
            entry.map(|entry| (entry.line, entry.section)).or(object.map(|object| (object.line, object.section)));
        let (line, origin) = place.unwrap_or_default();
        let single = object.is_none_or(|object| object.code.is_single());
        let section = match single {
            true => format!("{:04X}", at.index.0),
            false => format!("{:04X}sub{:X}", at.index.0, at.sub.0),
        };
        self.problems.report(place_in(line, origin, &section, field), rule, expected, found);
    }

    /// Reports a problem of a whole object, at its own section.
    fn report_object(&mut self, of: &Object, field: &str, rule: &'static Rule, expected: &'static str, found: &str) {
        let section = format!("{:04X}", of.index.0);
        self.problems.report(place_in(of.line, of.section, &section, field), rule, expected, found);
    }

    fn object(&self, index: Index) -> Option<&'a Object> {
        self.description.dictionary.object(index)
    }

    /// The default at that address as a number; `None` if it depends on the node-ID.
    pub fn default(&self, index: u16, sub: u8) -> Option<u64> {
        let entry = self.description.dictionary.entry(Multiplexer::new(index, sub)).ok()?;
        u64::try_from(entry.default.as_ref().and_then(Setting::fixed)?.as_number()?).ok()
    }

    /// The value after the device's start: the configured value of a DCF, else the default; with the name of its
    /// field.
    fn effective(&self, at: Multiplexer) -> Option<(&'a Setting, &'static str)> {
        let entry = self.description.dictionary.entry(at).ok()?;
        let configured = entry.configured.as_ref().map(|setting| (setting, "ParameterValue"));
        configured.or(entry.default.as_ref().map(|setting| (setting, "DefaultValue")))
    }

    /// The effective value as a number; `None` if it depends on the node-ID.
    fn effective_number(&self, at: Multiplexer) -> Option<(u64, &'static str)> {
        let (setting, field) = self.effective(at)?;
        Some((u64::try_from(setting.fixed()?.as_number()?).ok()?, field))
    }

    /// The objects of a range of indexes.
    fn objects(&self, first: u16, last: u16) -> impl Iterator<Item = &'a Object> + use<'a> {
        let range = Index(first)..=Index(last);
        self.description.dictionary.objects().iter().filter(move |object| range.contains(&object.index))
    }
}

/// The place of a field of a section or element.
fn place_in<'p>(line: u32, origin: Option<SectionId>, section: &'p str, field: &'p str) -> Place<'p> {
    Place { line, section, field, spot: origin.map_or(Spot::Line, Spot::Section) }
}

/// The entries after the count in sub-index 0.
fn elements(object: &Object) -> impl Iterator<Item = &super::object::Entry> {
    object.entries().iter().filter(|entry| !matches!(entry.sub, SubIndex(0 | 0xFF)))
}
