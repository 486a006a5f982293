//! EMCY error codes that device profiles define in addition to the codes of CiA 301.

use super::{Profile, known_profile, profiles};
use crate::wire::emcy::EmcyCode;

/// The error codes of a device profile of which nothing else is known here.
pub struct ErrorCodes {
    /// The number of the profile, as in the low word of 1000h.
    pub profile: u16,
    /// The codes, ascending, each with its meaning.
    pub codes: &'static [(u16, &'static str)],
}

inventory::collect!(ErrorCodes);

/// The meaning of an error code in a device profile; `None` if only CiA 301 gives it one.
pub fn error_name(code: EmcyCode, profile: u16) -> Option<&'static str> {
    let of_profile = known_profile(profile).and_then(|profile| profile.emergency(code));
    of_profile.or_else(|| {
        let tables = inventory::iter::<ErrorCodes>.into_iter().filter(|table| table.profile == profile);
        tables.into_iter().find_map(|table| find(table.codes, code))
    })
}

/// The profiles that give an error code a meaning, with the meaning, by number.
pub fn error_names(code: EmcyCode) -> Vec<(u16, &'static str)> {
    let tables = inventory::iter::<ErrorCodes>.into_iter().map(|table| table.profile);
    let mut numbers: Vec<u16> = profiles().map(Profile::number).chain(tables).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers.into_iter().filter_map(|number| Some((number, error_name(code, number)?))).collect()
}

/// The meaning of a code in a table.
pub fn find(codes: &'static [(u16, &'static str)], code: EmcyCode) -> Option<&'static str> {
    codes.binary_search_by_key(&code.0, |row| row.0).ok().map(|at| codes[at].1)
}

/// An error code with its meaning in a device profile, otherwise in CiA 301: `7121h motor blocked`.
#[derive(Clone, Copy)]
pub struct ErrorName {
    /// The code.
    pub code: EmcyCode,
    /// The device profile, if known.
    pub profile: Option<u16>,
}

impl std::fmt::Display for ErrorName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.profile.and_then(|profile| error_name(self.code, profile)) {
            Some(name) => write!(f, "{:04X}h {name}", self.code.0),
            None => self.code.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_sorted() {
        for table in inventory::iter::<ErrorCodes> {
            assert!(table.codes.is_sorted_by(|a, b| a.0 < b.0), "{}", table.profile);
        }
    }

    #[test]
    fn a_code_has_the_meaning_of_its_profile() {
        let text = |code, profile| ErrorName { code: EmcyCode(code), profile }.to_string();
        assert_eq!(text(0x7121, Some(402)), "7121h motor blocked");
        assert_eq!(text(0x2320, Some(401)), "2320h short circuit at outputs");
        assert_eq!(text(0x5010, Some(410)), "5010h sensor error, X axis");
        for profile in [None, Some(401), Some(9)] {
            assert_eq!(text(0x7121, profile), "7121h additional modules");
        }
        assert_eq!(text(0x8130, Some(402)), "8130h life guard error or heartbeat error");
    }
}
