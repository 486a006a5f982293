//! Descriptions with a fault: what a maker of devices can get wrong in an EDS. The device itself is as it should be.

use super::Model;
use crate::{Fault, Faults};
use canvass_analyzer::dictionary::{DeviceDescription, eds};

/// What stands in the EDS of `reference-301`, and what a faulty one has instead.
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

impl Model {
    /// The description that a maker with those faults delivers with the device; without such a fault the right one.
    pub fn description_with(&self, faults: Faults) -> DeviceDescription {
        let damages: Vec<_> = DAMAGES.iter().filter(|(fault, ..)| faults.has(*fault)).collect();
        let right = || self.description().clone();
        let Some(text) = self.eds_text().filter(|_| !damages.is_empty()) else { return right() };
        let damaged = damages.iter().fold(text.to_owned(), |text, (_, from, to)| text.replacen(from, to, 1));
        let Ok(mut description) = eds::read(damaged.as_bytes()) else { return right() };
        description.annotations = self.description().annotations.clone();
        description.settings = self.description().settings.clone();
        description.emergencies = self.description().emergencies.clone();
        description
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A damage whose text is not in the file would damage nothing.
    #[test]
    fn every_damage_finds_its_place() {
        let text = Model::by_id("reference-301").unwrap().eds_text().unwrap();
        for (fault, from, to) in DAMAGES {
            assert!(text.contains(from) && from != to, "{fault}");
            assert_eq!(fault.model(), "reference-301");
        }
    }
}
