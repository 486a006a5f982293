//! The fields that CiA 306 defines, each with a number, so that names are compared only once.

/// Declares the names of the fields, by rising length.
macro_rules! field_names {
    ($($field:ident $name:literal)*) => {
        /// A field that CiA 306 defines.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(in crate::dictionary) enum FieldName {
            $($field),*
        }

        /// The names in the spelling of CiA 306, in the order of the enumeration.
        static ALL: [(FieldName, &str); const { [$($name),*].len() }] = [$((FieldName::$field, $name)),*];
    };
}

field_names! {
    Count "Count"
    Lines "Lines"
    NodeId "NodeID"
    LastEds "LastEDS"
    NetRefd "NetRefd"
    Baudrate "Baudrate"
    DataType "DataType"
    FileName "FileName"
    LowLimit "LowLimit"
    NodeName "NodeName"
    NodeRefd "NodeRefd"
    ObjFlags "ObjFlags"
    CreatedBy "CreatedBy"
    HighLimit "HighLimit"
    NetNumber "NetNumber"
    NrOfRxPdo "NrOfRXPDO"
    NrOfTxPdo "NrOfTXPDO"
    ObjExtend "ObjExtend"
    OrderCode "OrderCode"
    ParamRefd "ParamRefd"
    SubNumber "SubNumber"
    AccessType "AccessType"
    CompactPdo "CompactPDO"
    Denotation "Denotation"
    EdsVersion "EDSVersion"
    ModifiedBy "ModifiedBy"
    ObjectType "ObjectType"
    PdoMapping "PDOMapping"
    UploadFile "UploadFile"
    VendorName "VendorName"
    BaudRate10 "BaudRate_10"
    BaudRate20 "BaudRate_20"
    BaudRate50 "BaudRate_50"
    Description "Description"
    FileVersion "FileVersion"
    Granularity "Granularity"
    NetworkName "NetworkName"
    NrOfEntries "NrOfEntries"
    ObjectLinks "ObjectLinks"
    ProductName "ProductName"
    BaudRate100 "BaudRate_100"
    BaudRate125 "BaudRate_125"
    BaudRate250 "BaudRate_250"
    BaudRate500 "BaudRate_500"
    BaudRate800 "BaudRate_800"
    CreationDate "CreationDate"
    CreationTime "CreationTime"
    DefaultValue "DefaultValue"
    DownloadFile "DownloadFile"
    FileRevision "FileRevision"
    VendorNumber "VendorNumber"
    BaudRate1000 "BaudRate_1000"
    CompactSubObj "CompactSubObj"
    LssSupported "LSS_Supported"
    ParameterName "ParameterName"
    ProductNumber "ProductNumber"
    CanopenManager "CANopenManager"
    GroupMessaging "GroupMessaging"
    ParameterValue "ParameterValue"
    ProductVersion "ProductVersion"
    RevisionNumber "RevisionNumber"
    ProductRevision "ProductRevision"
    LssSerialNumber "LSS_SerialNumber"
    ModificationDate "ModificationDate"
    ModificationTime "ModificationTime"
    SupportedObjects "SupportedObjects"
    SimpleBootUpSlave "SimpleBootUpSlave"
    SimpleBootUpMaster "SimpleBootUpMaster"
    ExtendedBootUpSlave "ExtendedBootUpSlave"
    ExtendedBootUpMaster "ExtendedBootUpMaster"
    CanopenSafetySupported "CANopenSafetySupported"
    DynamicChannelsSupported "DynamicChannelsSupported"
}

const LONGEST: usize = 24;

/// The number of names shorter than a length.
static SHORTER: [usize; LONGEST + 2] = {
    let mut shorter = [0; LONGEST + 2];
    let mut length = 1;
    while length < shorter.len() {
        let mut at: usize = shorter[length - 1];
        while at < ALL.len() && ALL[at].1.len() < length {
            at += 1;
        }
        shorter[length] = at;
        length += 1;
    }
    shorter
};

impl FieldName {
    /// The spelling of CiA 306.
    pub fn text(self) -> &'static str {
        ALL.get(self as usize).map_or("", |(_, text)| text)
    }

    /// The field of that name, ignoring case; the name must not contain blanks.
    pub fn parse(name: &str) -> Option<Self> {
        let alike = ALL.get(*SHORTER.get(name.len())?..*SHORTER.get(name.len() + 1)?)?;
        // Names begin with a letter, which already differs between most names of the same length.
        let first = name.as_bytes().first()? | 0x20;
        let is_it = |known: &str| known.as_bytes()[0] | 0x20 == first && known.eq_ignore_ascii_case(name);
        alike.iter().find(|(_, known)| is_it(known)).map(|&(field, _)| field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_is_found_in_any_case() {
        assert!(ALL.iter().is_sorted_by_key(|(_, name)| name.len()));
        assert_eq!(ALL.last().map(|(_, name)| name.len()), Some(LONGEST));
        for (field, name) in ALL {
            assert_eq!(field.text(), name);
            for name in [name.to_owned(), name.to_ascii_uppercase(), name.to_ascii_lowercase()] {
                assert_eq!(FieldName::parse(&name), Some(field));
            }
        }
        for other in ["", "1", "Data", "DataTypes", "BaudRate_010", "DynamicChannelsSupported_"] {
            assert_eq!(FieldName::parse(other), None, "{other}");
        }
    }
}
