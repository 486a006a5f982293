//! Differences in existence, object code and name of objects and sub-indexes.

use super::kind::kinds;
use super::{Comparison, Fact, Subject, entries};
use crate::dictionary::object::Object;
use crate::identity::{Index, Multiplexer, SubIndex};
use std::collections::BTreeSet;

kinds! {
    /// the object is gone
    ///
    /// A DCF that sets it can't be downloaded completely, and a master that reads or writes it gets abort 0602 0000h.
    OBJECT_REMOVED: Breaking "object/removed";

    /// the object is new
    ///
    /// Programs that do not know it do not access it.
    OBJECT_ADDED: Harmless "object/added";

    /// the object code has changed
    ///
    /// Tools address the values of an ARRAY or RECORD by sub-index from 1 on and that of a VAR at sub-index 0: the
    /// same access now reaches another value, or ends in abort 0609 0011h.
    OBJECT_CODE: Breaking "object/code";

    /// an ARRAY became a RECORD, or the other way round
    ///
    /// The values keep their addresses; a tool that generates source code from the description generates other types.
    OBJECT_STRUCTURE: Notable "object/structure";

    /// the name of the object has changed
    ///
    /// Programs that address objects by name, as scripts with python-canopen do, no longer find it.
    OBJECT_NAME: Notable "object/name";

    /// the sub-index is gone
    ///
    /// A DCF that sets it can't be downloaded completely, and a master that reads or writes it gets abort 0609 0011h.
    SUB_REMOVED: Breaking "sub-index/removed";

    /// the sub-index is new
    ///
    /// Programs that do not know it do not access it.
    SUB_ADDED: Harmless "sub-index/added";
}

/// Compares the objects of both descriptions.
pub(super) fn compare(comparison: &mut Comparison<'_>) {
    let (old, new) = (&comparison.old.dictionary, &comparison.new.dictionary);
    let both = old.objects().iter().chain(new.objects());
    let indexes: BTreeSet<Index> = both.map(|object| object.index).collect();
    for index in indexes {
        let subject = Subject::Object(index);
        match (old.object(index), new.object(index)) {
            (Some(before), Some(after)) => object(comparison, before, after),
            (Some(before), None) => {
                comparison.report(&OBJECT_REMOVED, subject, Some(Fact::ObjectCode(before.code)), None);
            }
            (None, Some(after)) => comparison.report(&OBJECT_ADDED, subject, None, Some(Fact::ObjectCode(after.code))),
            (None, None) => {}
        }
    }
}

fn object(comparison: &mut Comparison<'_>, old: &Object, new: &Object) {
    let subject = Subject::Object(old.index);
    let kind = if old.code.is_single() == new.code.is_single() && !old.code.is_single() {
        &OBJECT_STRUCTURE
    } else {
        &OBJECT_CODE
    };
    comparison.changed(kind, subject, Some(Fact::ObjectCode(old.code)), Some(Fact::ObjectCode(new.code)));
    let text = |name: &str| Some(Fact::Text(name.to_owned()));
    comparison.changed(&OBJECT_NAME, subject, text(&old.name), text(&new.name));
    let subs: BTreeSet<SubIndex> = old.entries().iter().chain(new.entries()).map(|entry| entry.sub).collect();
    for sub in subs {
        let at = Multiplexer { index: old.index, sub };
        let subject = Subject::Entry(at);
        match (old.entry(sub), new.entry(sub)) {
            // Sub-index 0 of a single value is the value, and sub-index 0 of a structure is a count: the two are no
            // counterparts.
            (Some(_), Some(_)) if old.code.is_single() != new.code.is_single() => {}
            (Some(before), Some(after)) => {
                entries::compare(comparison, at, before, after, old.code.is_single());
            }
            (Some(before), None) => {
                comparison.report(&SUB_REMOVED, subject, Some(Fact::DataType(before.data_type)), None);
            }
            (None, Some(after)) => comparison.report(&SUB_ADDED, subject, None, Some(Fact::DataType(after.data_type))),
            (None, None) => {}
        }
    }
}
