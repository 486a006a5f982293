//! Differences of one entry: type, access, use in PDOs.

use super::kind::kinds;
use super::{Comparison, Fact, Subject, values};
use crate::dictionary::object::{Access, Entry};
use crate::identity::Multiplexer;

kinds! {
    /// the data type has changed
    ///
    /// Values and mappings of the old length are refused (abort 0607 0010h). With the same length, the same bytes now
    /// mean another value.
    DATA_TYPE: Breaking "entry/data-type";

    /// the entry can't be written any more
    ///
    /// A DCF that sets it can't be downloaded completely: the device answers with abort 0601 0002h.
    NOT_WRITABLE: Breaking "entry/not-writable";

    /// the entry can't be read any more
    ///
    /// A master that reads it gets abort 0601 0001h, and a tool can't verify what it has written.
    NOT_READABLE: Breaking "entry/not-readable";

    /// the entry can now be read or written
    ///
    /// Programs that do not know it do not access it.
    MORE_ACCESS: Harmless "entry/more-access";

    /// the value is no longer constant
    ///
    /// A tool that reads constant values once, or takes them from the description, keeps an outdated value.
    NOT_CONSTANT: Notable "entry/not-constant";

    /// the value is constant now
    ///
    /// Programs that read it again get the same value.
    CONSTANT: Harmless "entry/constant";

    /// a TPDO can't carry the entry any more
    ///
    /// A mapping that names it is refused (abort 0604 0041h), and the PDO stays as it was.
    NO_TPDO: Breaking "entry/no-tpdo";

    /// an RPDO can't carry the entry any more
    ///
    /// A mapping that names it is refused (abort 0604 0041h), and the PDO stays as it was.
    NO_RPDO: Breaking "entry/no-rpdo";

    /// a PDO can now carry the entry
    ///
    /// Mappings that were possible still are.
    MORE_PDO: Harmless "entry/more-pdo";

    /// the name of the sub-index has changed
    ///
    /// Programs that address entries by name, as scripts with python-canopen do, no longer find it.
    NAME: Notable "entry/name";

    /// tools include or skip the entry differently
    ///
    /// ObjFlags tells tools which entries to skip when they download or read everything: a value that was part of
    /// each download no longer is, or vice versa.
    FLAGS: Notable "entry/flags";

    /// the denotation of the entry has changed
    ///
    /// Denotation is a text for people.
    DENOTATION: Harmless "entry/denotation";
}

/// Compares the entries at that address. A VAR's entry has the name of its object.
pub(super) fn compare(comparison: &mut Comparison<'_>, at: Multiplexer, old: &Entry, new: &Entry, is_single: bool) {
    let subject = Subject::Entry(at);
    let data_type = |entry: &Entry| Some(Fact::DataType(entry.data_type));
    comparison.changed(&DATA_TYPE, subject, data_type(old), data_type(new));
    access(comparison, subject, old.access, new.access);
    mapping(comparison, subject, old, new);
    let text = |text: &str| Some(Fact::Text(text.to_owned()));
    if !is_single {
        comparison.changed(&NAME, subject, text(&old.name), text(&new.name));
    }
    let flags = |entry: &Entry| Some(Fact::Number(entry.flags.0));
    comparison.changed(&FLAGS, subject, flags(old), flags(new));
    let denotation = |entry: &Entry| entry.denotation.as_deref().and_then(text);
    comparison.changed(&DENOTATION, subject, denotation(old), denotation(new));
    values::compare(comparison, at, old, new, is_single);
}

fn access(comparison: &mut Comparison<'_>, subject: Subject, old: Access, new: Access) {
    let (before, after) = (Some(Fact::Access(old)), Some(Fact::Access(new)));
    let mut report = |kind| comparison.report(kind, subject, before.clone(), after.clone());
    if old.is_writable() && !new.is_writable() {
        report(&NOT_WRITABLE);
    }
    if old.is_readable() && !new.is_readable() {
        report(&NOT_READABLE);
    }
    if !old.is_writable() && new.is_writable() || !old.is_readable() && new.is_readable() {
        report(&MORE_ACCESS);
    }
    match (old, new) {
        (Access::Const, Access::Ro) => report(&NOT_CONSTANT),
        (Access::Ro, Access::Const) => report(&CONSTANT),
        _ => {}
    }
}

fn mapping(comparison: &mut Comparison<'_>, subject: Subject, old: &Entry, new: &Entry) {
    let tpdo = |entry: &Entry| entry.pdo_mappable && entry.access.allows_tpdo();
    let rpdo = |entry: &Entry| entry.pdo_mappable && entry.access.allows_rpdo();
    let mut compare = |lost, before, after| {
        let kind = match (before, after) {
            (true, false) => lost,
            (false, true) => &MORE_PDO,
            _ => return,
        };
        comparison.report(kind, subject, Some(Fact::Flag(before)), Some(Fact::Flag(after)));
    };
    compare(&NO_TPDO, tpdo(old), tpdo(new));
    compare(&NO_RPDO, rpdo(old), rpdo(new));
}
