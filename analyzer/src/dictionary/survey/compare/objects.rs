//! Compares existence and access of objects and sub-indexes.

use super::{Answer, Comparison, MismatchKind, Side, Weight, values};
use crate::dictionary::difference::{Fact, Subject};
use crate::dictionary::object::{Entry, Object};
use crate::identity::Multiplexer;
use crate::object;
use crate::wire::sdo::AbortCode;

pub(super) fn compare(comparison: &mut Comparison<'_>) {
    for object in comparison.description.dictionary.objects() {
        if is_absent(comparison, object) {
            let found = Side::Answer(Answer::Aborted(AbortCode::NO_OBJECT));
            let subject = Subject::Object(object.index);
            comparison.report(MismatchKind::MissingObject, Weight::Differs, subject, Side::Exists, found);
            continue;
        }
        for entry in object.entries() {
            let at = Multiplexer { index: object.index, sub: entry.sub };
            if let Some(answer) = comparison.survey.get(at) {
                answered(comparison, object, entry, answer);
            }
        }
    }
}

/// Whether the device answers for every read entry that the object does not exist.
fn is_absent(comparison: &Comparison<'_>, object: &Object) -> bool {
    let at = |entry: &Entry| Multiplexer { index: object.index, sub: entry.sub };
    let mut answers = object.entries().iter().filter_map(|entry| comparison.survey.get(at(entry))).peekable();
    answers.peek().is_some() && answers.all(|answer| *answer == Answer::Aborted(AbortCode::NO_OBJECT))
}

fn answered(comparison: &mut Comparison<'_>, object: &Object, entry: &Entry, answer: &Answer) {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    let kind = match answer {
        Answer::Value(bytes) => return value(comparison, object, entry, bytes),
        Answer::Long(_) if entry.data_type.bytes().is_some() => MismatchKind::Length,
        Answer::Long(_) => return,
        Answer::Aborted(AbortCode::NO_OBJECT | AbortCode::NO_SUB_INDEX) if !is_empty_history(at) => {
            MismatchKind::MissingEntry
        }
        Answer::Aborted(AbortCode::WRITE_ONLY) if entry.access.is_readable() => MismatchKind::Access,
        // The abort code for reading a write-only entry is a matter of conformance, not of the description.
        Answer::Aborted(_) if !entry.access.is_readable() || answer.is_momentary() || is_empty_history(at) => return,
        Answer::Aborted(_) => MismatchKind::Refused,
        Answer::Silent => MismatchKind::NoAnswer,
        Answer::Violated(_) => MismatchKind::Violation,
    };
    let described = match kind {
        MismatchKind::Length => Side::Fact(Fact::DataType(entry.data_type)),
        MismatchKind::MissingEntry => Side::Exists,
        _ => Side::Fact(Fact::Access(entry.access)),
    };
    comparison.report(kind, Weight::Differs, Subject::Entry(at), described, Side::Answer(answer.clone()));
}

/// Whether the entry is an error in 1003h; an error that has not occurred has no sub-index or no value.
fn is_empty_history(at: Multiplexer) -> bool {
    at.index.0 == object::PREDEFINED_ERROR_FIELD && at.sub.0 > 0
}

fn value(comparison: &mut Comparison<'_>, object: &Object, entry: &Entry, bytes: &[u8]) {
    let at = Multiplexer { index: object.index, sub: entry.sub };
    if !entry.access.is_readable() {
        let (described, found) = (Side::Fact(Fact::Access(entry.access)), Side::Answer(Answer::Value(bytes.to_vec())));
        comparison.report(MismatchKind::Access, Weight::Differs, Subject::Entry(at), described, found);
    }
    values::compare(comparison, object, entry, bytes);
}
