//! Finds objects of the device that are not described.

use super::{Comparison, MismatchKind, Side, Weight};
use crate::dictionary::difference::Subject;
use crate::identity::Index;
use std::collections::BTreeMap;

pub(super) fn compare(comparison: &mut Comparison<'_>) {
    let dictionary = &comparison.description.dictionary;
    let mut objects: BTreeMap<Index, Side> = BTreeMap::new();
    let mut entries = Vec::new();
    for (at, answer) in comparison.survey.answers().filter(|(_, answer)| answer.exists() == Some(true)) {
        let found = || Side::Answer(answer.clone());
        if dictionary.object(at.index).is_none() {
            objects.entry(at.index).or_insert_with(found);
        } else if dictionary.entry(at).is_err() {
            entries.push((at, found()));
        }
    }
    for (index, found) in objects {
        let subject = Subject::Object(index);
        comparison.report(MismatchKind::UndescribedObject, Weight::Differs, subject, Side::Nothing, found);
    }
    for (at, found) in entries {
        let subject = Subject::Entry(at);
        comparison.report(MismatchKind::UndescribedEntry, Weight::Differs, subject, Side::Nothing, found);
    }
}
