//! The clauses that describe objects.

use super::StandardObject;
use crate::clause::{Clause, Confidence};

use Confidence::{Cited, Derived};

/// CiA 301 version 4.2: the first index of an object, its section within 7.5.2, and the certainty of the section.
const CIA_301: &[(u16, &str, Confidence)] = &[
    (0x1000, "7.5.2.1", Cited),
    (0x1001, "7.5.2.2", Cited),
    (0x1002, "7.5.2.3", Derived),
    (0x1003, "7.5.2.4", Cited),
    (0x1005, "7.5.2.5", Cited),
    (0x1006, "7.5.2.6", Cited),
    (0x1007, "7.5.2.7", Cited),
    (0x1008, "7.5.2.8", Derived),
    (0x1009, "7.5.2.9", Derived),
    (0x100A, "7.5.2.10", Derived),
    (0x100C, "7.5.2.11", Cited),
    (0x100D, "7.5.2.12", Derived),
    (0x1010, "7.5.2.13", Cited),
    (0x1011, "7.5.2.14", Cited),
    (0x1012, "7.5.2.15", Cited),
    (0x1013, "7.5.2.16", Cited),
    (0x1014, "7.5.2.17", Cited),
    (0x1015, "7.5.2.18", Cited),
    (0x1016, "7.5.2.19", Cited),
    (0x1017, "7.5.2.20", Cited),
    (0x1018, "7.5.2.21", Cited),
    (0x1019, "7.5.2.22", Cited),
    (0x1020, "7.5.2.23", Cited),
    (0x1021, "7.5.2.24", Derived),
    (0x1022, "7.5.2.25", Derived),
    (0x1023, "7.5.2.26", Derived),
    (0x1024, "7.5.2.27", Derived),
    (0x1025, "7.5.2.28", Derived),
    (0x1026, "7.5.2.29", Derived),
    (0x1027, "7.5.2.30", Derived),
    (0x1028, "7.5.2.31", Derived),
    (0x1029, "7.5.2.32", Cited),
    (0x1200, "7.5.2.33", Cited),
    (0x1280, "7.5.2.34", Derived),
    (0x1400, "7.5.2.35", Cited),
    (0x1600, "7.5.2.36", Cited),
    (0x1800, "7.5.2.37", Cited),
    (0x1A00, "7.5.2.38", Cited),
];

impl StandardObject {
    /// The clause that describes the object. The section is unknown for standards other than CiA 301, and for objects
    /// that version 4.2 dropped.
    pub fn clause(&self) -> Clause {
        let known = CIA_301.binary_search_by_key(&self.first, |&(first, ..)| first).ok();
        let known = known.and_then(|position| CIA_301.get(position));
        let (section, confidence) =
            known.map_or((None, Confidence::Unknown), |&(_, section, sure)| (Some(section), sure));
        Clause { standard: self.standard, section, confidence }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{cia301, standard_object};
    use super::*;
    use crate::identity::Index;

    #[test]
    fn objects_have_their_clauses_in_the_order_of_the_standard() {
        assert!(CIA_301.is_sorted_by_key(|&(first, ..)| first));
        for (number, (first, section, _)) in (1..).zip(CIA_301) {
            assert_eq!(*section, format!("7.5.2.{number}"));
            assert!(cia301::OBJECTS.iter().any(|object| object.first == *first), "{first:04X}h");
        }
    }

    #[test]
    fn what_is_counted_or_not_known_says_so() {
        let clause = |index| standard_object(Index(index), Some(406)).unwrap().clause().to_string();
        assert_eq!(clause(0x1801), "CiA 301 7.5.2.37");
        assert_eq!(clause(0x1280), "CiA 301 7.5.2.34 (derived)");
        assert_eq!(clause(0x1F80), "CiA 302, section unknown");
        assert_eq!(clause(0x6004), "CiA 406, section unknown");
        assert_eq!(clause(0x1004), "CiA 301, section unknown");
    }
}
