//! The records of a data group: the bytes of all its channel groups, cut into records.

use super::group::{Group, value};
use crate::damage::Flaw;
use std::collections::BTreeMap;

/// The records of a data group, each with the channel group that describes it.
#[derive(Default)]
pub(super) struct Records<'f, 'r> {
    pub records: Vec<(&'r Group<'f>, &'r [u8])>,
    /// The values of variable length, by the offsets of their groups.
    pub values: BTreeMap<u64, Vec<u8>>,
    /// Why the records end before the content.
    pub flaw: Option<Flaw>,
}

/// The records of the only group.
pub(super) fn sorted<'f, 'r>(groups: &'r [(u64, Group<'f>)], bytes: &'r [u8]) -> Records<'f, 'r> {
    let Some((_, group)) = groups.first().filter(|(_, group)| group.length > 0) else { return Records::default() };
    let whole = bytes.chunks_exact(group.length);
    let rest = whole.remainder().len();
    let flaw =
        (rest > 0).then(|| Flaw::malformed(format!("records of {} bytes", group.length), format!("{rest} more")));
    Records { records: whole.map(|record| (group, record)).collect(), flaw, ..Records::default() }
}

/// The records that begin with the number of their group, which has `width` bytes.
pub(super) fn numbered<'f, 'r>(groups: &'r [(u64, Group<'f>)], bytes: &'r [u8], width: usize) -> Records<'f, 'r> {
    let by_number: BTreeMap<u64, &(u64, Group<'f>)> = groups.iter().map(|group| (group.1.id, group)).collect();
    let mut split = Records::default();
    let mut rest = bytes;
    while !rest.is_empty() {
        let (number, after) = rest.split_at(width.min(rest.len()));
        let id = number.iter().rev().fold(0, |all, byte| all << 8 | u64::from(*byte));
        let Some((offset, group)) = by_number.get(&id) else {
            split.flaw = Some(Flaw::malformed("a record of a group that exists", format!("group {id}")));
            return split;
        };
        let length =
            if group.is_of_values { value(after).map(|(rest, _)| after.len() - rest.len()) } else { Ok(group.length) };
        let Some((record, next)) = length.ok().and_then(|length| after.split_at_checked(length)) else {
            split.flaw = Some(Flaw::malformed("a whole record at the end", format!("{} bytes", after.len())));
            return split;
        };
        if group.is_of_values {
            split.values.entry(*offset).or_default().extend_from_slice(record);
        } else {
            split.records.push((group, record));
        }
        rest = next;
    }
    split
}
