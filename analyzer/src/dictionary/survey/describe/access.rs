//! The access type of an entry, as far as it can be inferred without writing.

use super::{Facts, Guess};
use crate::dictionary::object::Access;
use crate::dictionary::survey::Answer;
use crate::identity::Multiplexer;
use crate::object;
use crate::wire::sdo::AbortCode;

/// The access type, and whether it is guessed. `counts`: the entry is the count of an object's entries.
pub(super) fn of(facts: &Facts<'_>, at: Multiplexer, counts: bool) -> (Access, Option<Guess>) {
    let standard = facts.standard(at).and_then(|name| name.entry).and_then(|entry| entry.access);
    let refuses_reading = facts.survey.get(at) == Some(&Answer::Aborted(AbortCode::WRITE_ONLY));
    let (in_rpdo, in_tpdo) = (facts.in_rpdos.contains(&at), facts.in_tpdos.contains(&at));
    match standard {
        _ if refuses_reading => (Access::Wo, None),
        // The COB-IDs of the first SDO server are fixed to the predefined connection set.
        Some(_) if at.index.0 == object::SDO_SERVER_PARAMETER => (Access::Ro, None),
        Some(Access::Wo) => (Access::Rw, None),
        Some(Access::Ro) if in_rpdo => (Access::Rww, None),
        Some(access) => (access, None),
        None if in_rpdo && in_tpdo => (Access::Rw, None),
        None if in_rpdo => (Access::Rww, None),
        None if counts => (Access::Ro, None),
        None => (Access::Ro, Some(Guess::Access)),
    }
}
