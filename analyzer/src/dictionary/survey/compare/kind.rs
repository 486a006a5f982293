//! Kinds of differences between a description and a device, and their certainty.

/// The kind of a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MismatchKind {
    /// Vendor-ID, product code, device type or device name.
    Identity,
    /// Revision number, hardware or software version.
    Release,
    /// A described object that the device does not have.
    MissingObject,
    /// A described sub-index that the device does not have.
    MissingEntry,
    /// An object of the device that is not described.
    UndescribedObject,
    /// A sub-index of a described object that is not described.
    UndescribedEntry,
    /// The length differs from that of the data type.
    Length,
    /// The bytes are no value of the data type.
    NoValue,
    /// The description and the device differ in whether the entry can be read.
    Access,
    /// The value lies outside the limits.
    Limits,
    /// Sub-index 0 counts other sub-indexes than are described.
    Count,
    /// A constant entry has another value.
    Constant,
    /// A DCF or XDC configures another value.
    Configured,
    /// A writable entry has another value than its default.
    Setting,
    /// An entry that the device itself sets has another value than its default.
    State,
    /// A PDO carries other objects.
    Mapping,
    /// A PDO carries an object that the description excludes from mapping.
    Unmappable,
    /// A COB-ID differs.
    CobId,
    /// The device refuses to upload the value.
    Refused,
    /// The device does not answer.
    NoAnswer,
    /// The device's answer breaks the protocol.
    Violation,
}

/// Whether a difference proves an error in the description or the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Weight {
    /// The description or the device is wrong.
    Differs,
    /// The device may have been configured.
    MayBeConfiguration,
    /// The device may have set the value itself, as a measurement or a state.
    MayBeState,
}

impl Weight {
    /// The name of the weight in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Differs => "differs",
            Self::MayBeConfiguration => "may-be-configuration",
            Self::MayBeState => "may-be-state",
        }
    }
}

impl MismatchKind {
    /// All kinds.
    pub const ALL: [Self; 21] = [
        Self::Identity,
        Self::Release,
        Self::MissingObject,
        Self::MissingEntry,
        Self::UndescribedObject,
        Self::UndescribedEntry,
        Self::Length,
        Self::NoValue,
        Self::Access,
        Self::Limits,
        Self::Count,
        Self::Constant,
        Self::Configured,
        Self::Setting,
        Self::State,
        Self::Mapping,
        Self::Unmappable,
        Self::CobId,
        Self::Refused,
        Self::NoAnswer,
        Self::Violation,
    ];

    /// The stable name of the kind in tables and JSON.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Identity => "identity",
            Self::Release => "release",
            Self::MissingObject => "missing-object",
            Self::MissingEntry => "missing-sub-index",
            Self::UndescribedObject => "undescribed-object",
            Self::UndescribedEntry => "undescribed-sub-index",
            Self::Length => "length",
            Self::NoValue => "no-value",
            Self::Access => "access",
            Self::Limits => "limits",
            Self::Count => "count",
            Self::Constant => "constant",
            Self::Configured => "configured",
            Self::Setting => "setting",
            Self::State => "state",
            Self::Mapping => "mapping",
            Self::Unmappable => "unmappable",
            Self::CobId => "cob-id",
            Self::Refused => "refused",
            Self::NoAnswer => "no-answer",
            Self::Violation => "violation",
        }
    }

    /// The consequence for users of the description.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Identity => "another device than the description is for: a master that checks it does not start it",
            Self::Release => "another release than the description is for: the other differences may follow from it",
            Self::MissingObject => "an access to the object is refused with abort 0602 0000h",
            Self::MissingEntry => "an access to the sub-index is refused with abort 0609 0011h",
            Self::UndescribedObject => "no tool shows the object or configures it",
            Self::UndescribedEntry => "no tool shows the sub-index or configures it",
            Self::Length => "a value of the described length is refused with abort 0607 0010h, or is read wrongly",
            Self::NoValue => "a tool can't show the value",
            Self::Access => "a tool tries to read an unreadable entry, or skips a readable one",
            Self::Limits => "a tool shows the value as wrong, and can't write it back",
            Self::Count => "a tool reads too few sub-indexes, or too many",
            Self::Constant => "by the description it never changes: another release or variant of the device",
            Self::Configured => "the device is not configured as in the file, or was not restarted since",
            Self::Setting => {
                "not as delivered: the device may have been configured, or has another default than the description"
            }
            Self::State => {
                "the device sets it: it may depend on its state or variant, or has another default than the \
                 description"
            }
            Self::Mapping => "consumers that decode the PDO by the description get wrong values",
            Self::Unmappable => "a tool refuses the mapping that the device has",
            Self::CobId => "nodes that use the described COB-ID receive nothing, or reach no one",
            Self::Refused => "by the description it can be read",
            Self::NoAnswer => "a tool that reads it gets no answer",
            Self::Violation => "a tool that reads it gets no value",
        }
    }
}
