//! The clauses of the standards that a violation breaks.

use super::violation::Violation;
use crate::property::Property;

/// The clauses by rule, of CiA 301 V4.2.0.
const CIA_301: &[(&str, &str)] = &[
    // SDO
    ("unsolicited response", "7.2.4.1"),
    ("response to an odd request", "7.2.4.3.1"),
    ("a toggle bit that does not alternate", "7.2.4.3.2, 7.2.4.3.5"),
    ("initiate upload", "7.2.4.3.6"),
    ("upload segment", "7.2.4.3.7"),
    ("expedited download", "7.2.4.3.3"),
    ("initiate download", "7.2.4.3.3"),
    ("download segment", "7.2.4.3.4"),
    ("initiate block download", "7.2.4.3.9"),
    ("download of a block", "7.2.4.3.10"),
    ("end of a block download", "7.2.4.3.11"),
    ("the end of a block download without its transfer", "7.2.4.3.11, 7.2.4.3.17"),
    ("initiate block upload", "7.2.4.3.13"),
    ("upload of a block", "7.2.4.3.14"),
    ("end of a block upload", "7.2.4.3.15"),
    ("a command of a block upload without its transfer", "7.2.4.3.14, 7.2.4.3.17"),
    ("a segment is confirmed that was never sent", "7.2.4.3.14, 7.2.4.3.17"),
    ("a block size outside 1 to 127", "7.2.4.3.13, 7.2.4.3.14"),
    ("the checksum is wrong", "7.2.4.3.11, 7.2.4.3.16"),
    ("canonical read", "7.2.4.3.6"),
    ("SDO in a state without SDO", "7.3.2.2.5"),
    // NMT and error control
    ("frame before the boot-up message", "7.3.2.2.1"),
    ("boot-up message", "7.2.8.3.3"),
    ("boot-up after reset", "7.2.8.3.3"),
    ("boot-up without reset", "7.2.8.2.3, 7.3.2.3"),
    ("length of error control", "7.2.8.3.2"),
    ("error control without need", "7.2.8.3.2"),
    ("toggle bit of guarding", "7.2.8.3.2"),
    ("guarding", "7.2.8.3.2"),
    ("unknown state", "7.2.8.3.2"),
    ("heartbeat with toggle bit", "7.2.8.3.2"),
    ("heartbeat although off", "7.5.2.20"),
    ("period of the heartbeat", "7.5.2.20"),
    ("state in error control", "7.3.2.3"),
    // EMCY
    ("length of EMCY", "7.2.7.3.1"),
    ("error register in EMCY", "7.2.7.3.1, 7.5.2.2"),
    ("EMCY in stopped", "7.3.2.2.4"),
    ("EMCY repeated", "7.2.7.1"),
    ("EMCY storm", "7.2.7.1"),
    ("EMCY although off", "7.5.2.17"),
    ("SYNC although off", "7.5.2.5"),
    ("TIME although off", "7.5.2.15"),
    // PDO
    ("PDO outside operational", "7.3.2.2.5"),
    ("length of a PDO", "7.5.2.38"),
    ("synchronous TPDO", "7.2.2.2, 7.5.2.37"),
    ("remote frame", "7.2.2.3, 7.5.2.37"),
    ("inhibit time", "7.5.2.37"),
    ("event timer", "7.5.2.37"),
    ("identifier", "7.3.3"),
    // Values that a device has to refuse
    ("a restricted CAN-ID", "7.3.5"),
    ("a reserved transmission type", "7.5.2.35, 7.5.2.37"),
    ("the CAN-ID changes only while the PDO is invalid", "7.5.2.35, 7.5.2.37"),
    ("the SYNC start value changes only while the PDO is invalid", "7.5.2.37"),
    ("the CAN-ID changes only while it is not in use", "7.5.2.5, 7.5.2.15"),
    ("the CAN-ID changes only while it is invalid", "7.5.2.17, 7.5.2.33"),
    ("only 0 can be written to the error history", "7.5.2.4"),
    ("not the signature that stores", "7.5.2.13"),
    ("not the signature that restores", "7.5.2.14"),
    ("a reserved value of the SYNC counter", "7.5.2.22"),
    ("the SYNC counter changes only while 1006h is 0", "7.5.2.22"),
    ("a reserved behaviour on errors", "7.5.2.32"),
    ("another entry already monitors the node", "7.5.2.19"),
    // The device that does not come back
    ("device death", "7.3.2.3"),
    ("reset after a sequence", "7.3.2.3"),
];

/// The clauses by rule, of CiA 305.
const CIA_305: &[(&str, &str)] = &[
    ("switch state global", "6.3.2"),
    ("switch state selective", "6.3.3"),
    ("configure node-ID", "6.4.2"),
    ("configure bit timing", "6.4.3"),
    ("activate bit timing", "6.4.4"),
    ("store configuration", "6.4.5"),
    ("inquire", "6.5.2"),
    ("inquire node-ID", "6.5.3"),
    ("identify remote slave", "6.6.2"),
    ("identify non-configured remote slave", "6.6.4"),
    ("Fastscan", "6.7"),
];

impl Violation {
    /// The clause of the standard that the behaviour breaks. If no clause names the rule, the whole service is cited.
    pub fn clause(&self) -> String {
        let of = |rows: &[(&str, &'static str)]| rows.iter().find(|row| row.0 == self.rule).map(|row| row.1);
        match self.property {
            Property::OfProfile(property) => format!("the profile: {}", property.title),
            Property::LegalLss | Property::Fastscan if self.is_of_lmt() => "CiA DS-205".to_owned(),
            Property::LegalLss | Property::Fastscan => {
                of(CIA_305).map_or_else(|| "CiA 305".to_owned(), |clause| format!("CiA 305 {clause}"))
            }
            property => format!("CiA 301 {}", of(CIA_301).unwrap_or(usual(property))),
        }
    }

    fn is_of_lmt(&self) -> bool {
        self.rule.contains("LMT") || self.rule.starts_with("switch mode") || self.rule.ends_with("NMT address")
    }
}

/// The clause of the service that a property belongs to.
const fn usual(property: Property) -> &'static str {
    match property {
        Property::Pdo => "7.5.2.36, 7.5.2.38",
        Property::NmtState | Property::NoRestart | Property::Alive | Property::Restored => "7.3.2",
        Property::EmcyRate => "7.2.7",
        _ => "7.2.4.3.17",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No rule has two rows.
    #[test]
    fn rules_are_cited_once() {
        for rows in [CIA_301, CIA_305] {
            for (number, row) in rows.iter().enumerate() {
                assert!(rows[..number].iter().all(|earlier| earlier.0 != row.0), "{}", row.0);
            }
        }
    }
}
