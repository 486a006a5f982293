//! Altered descriptions: errors and liberties of a device's maker in an EDS. The device itself is unaltered.

use crate::models::Model;
use crate::{Fault, Firmware, liberty};
use canvass_analyzer::dictionary::{DeviceDescription, eds};

/// Texts in the EDS of `reference-301`, and their faulty replacements.
const DAMAGES: [(Fault, &str, &str); 18] = [
    (Fault::EdsLineWithoutSense, "[DummyUsage]\n", "[DummyUsage]\nthe last update was on Monday\n"),
    (Fault::EdsSectionTwice, "[DummyUsage]\n", "[DeviceInfo]\nVendorName=other\n\n[DummyUsage]\n"),
    (Fault::EdsSubIndexMissing, "[1018sub0]\n", "[101Fsub0]\n"),
    (Fault::EdsFieldTwice, "LSS_Supported=1\n", "LSS_Supported=1\nLSS_Supported=0\n"),
    (
        Fault::EdsDataTypeMissing,
        "[1017]\nParameterName=Producer heartbeat time\nObjectType=0x7\nDataType=0x0006\n",
        "[1017]\nParameterName=Producer heartbeat time\nObjectType=0x7\n",
    ),
    (Fault::EdsNumberUnreadable, "VendorNumber=0x7FFFFFFF\n", "VendorNumber=7FFFFFFFh\n"),
    (Fault::EdsFloatDefault, "DefaultValue=100\nLowLimit=10\n", "DefaultValue=100.0\nLowLimit=10\n"),
    (
        Fault::EdsSubNumberWrong,
        "[1018]\nParameterName=Identity object\nObjectType=0x9\nSubNumber=5\n",
        "[1018]\nParameterName=Identity object\nObjectType=0x9\nSubNumber=7\n",
    ),
    (Fault::EdsPdoCountWrong, "NrOfTXPDO=4\n", "NrOfTXPDO=9\n"),
    (Fault::EdsDateWrong, "CreationDate=11-21-2026\n", "CreationDate=2026-11-21\n"),
    (Fault::EdsBooleanWrong, "SimpleBootUpSlave=1\n", "SimpleBootUpSlave=2\n"),
    (Fault::EdsObjectListedTwice, "2=0x1001\n", "2=0x1000\n"),
    (
        Fault::EdsAccessTypeUnknown,
        "[1001]\nParameterName=Error register\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\n",
        "[1001]\nParameterName=Error register\nObjectType=0x7\nDataType=0x0005\nAccessType=readonly\n",
    ),
    (Fault::EdsVendorNumberDiffers, "VendorNumber=0x7FFFFFFF\n", "VendorNumber=0x13\n"),
    (Fault::EdsDefaultBeyondLimit, "DefaultValue=100\nLowLimit=10\n", "DefaultValue=5\nLowLimit=10\n"),
    (Fault::EdsMappingWrong, "DefaultValue=0x60000108\n", "DefaultValue=0x60000110\n"),
    (Fault::EdsCobIdTwice, "DefaultValue=$NODEID+0x280\n", "DefaultValue=$NODEID+0x180\n"),
    (
        Fault::EdsDataTypeWrong,
        "[1017]\nParameterName=Producer heartbeat time\nObjectType=0x7\nDataType=0x0006\n",
        "[1017]\nParameterName=Producer heartbeat time\nObjectType=0x7\nDataType=0x0007\n",
    ),
];

impl Fault {
    /// Whether the fault is only in the description; the device itself is then fault-free.
    pub fn is_in_description(self) -> bool {
        DAMAGES.iter().any(|(fault, ..)| *fault == self)
    }
}

impl Model {
    /// The description that a maker delivers with a device of this firmware, with the firmware's faults and liberties
    /// of descriptions.
    pub fn description_with(&self, firmware: impl Into<Firmware>) -> DeviceDescription {
        let firmware = firmware.into();
        let mut description = self.rewritten(&firmware).unwrap_or_else(|| self.description().clone());
        if !firmware.liberties.is_empty() {
            liberty::apply(&mut description, &mut self.sheet().clone(), firmware.liberties);
        }
        description
    }

    /// The rewritten description; `None` if no fault or liberty alters it, or if it can't be read.
    fn rewritten(&self, firmware: &Firmware) -> Option<DeviceDescription> {
        let damages: Vec<_> = DAMAGES.iter().filter(|(fault, ..)| firmware.has(*fault)).collect();
        if damages.is_empty() && !liberty::changes_text(firmware.liberties) {
            return None;
        }
        let damaged =
            damages.iter().fold(self.eds_text()?.to_owned(), |text, (_, from, to)| text.replacen(from, to, 1));
        eds::read(&liberty::rewrite(&damaged, firmware.liberties)).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every damage replaces a text that is in the file; otherwise it would have no effect.
    #[test]
    fn every_damage_finds_its_place() {
        let text = Model::by_id("reference-301").unwrap().eds_text().unwrap();
        for (fault, from, to) in DAMAGES {
            assert!(text.contains(from) && from != to, "{fault}");
            assert_eq!(fault.model(), "reference-301");
        }
    }
}
