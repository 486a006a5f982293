//! What can differ between a description and a device, and how certain it is that one of them is wrong.

/// What differs.
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
    /// The length is not that of the data type.
    Length,
    /// The bytes are no value of the data type.
    NoValue,
    /// What is described as readable is not, or the other way round.
    Access,
    /// The value lies outside the limits.
    Limits,
    /// Sub-index 0 counts other sub-indexes than are described.
    Count,
    /// An entry that never changes has another value.
    Constant,
    /// A DCF or XDC configures another value.
    Configured,
    /// An entry that can be written has another value than its default.
    Setting,
    /// An entry that the device itself sets has another value than its default.
    State,
    /// A PDO carries other objects.
    Mapping,
    /// A PDO carries an object that can't be mapped by the description.
    Unmappable,
    /// A COB-ID differs.
    CobId,
    /// The device refuses to give the value.
    Refused,
    /// The device does not answer.
    NoAnswer,
    /// The device's answer breaks the protocol.
    Violation,
}

/// Whether a difference shows that description or device is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Weight {
    /// One of the two is wrong.
    Differs,
    /// Somebody may have configured the device so.
    MayBeConfiguration,
    /// The device may have set it itself, as what it measures or is in.
    MayBeState,
}

impl Weight {
    /// The word for it in JSON.
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

    /// The name of the kind in tables and JSON; it does not change.
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

    /// What it means for users of the description.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Identity => "another device than the description is of: a master that checks it does not start it",
            Self::Release => "another release than the description is of: the other differences may follow from it",
            Self::MissingObject => "who uses the object is refused with abort 0602 0000h",
            Self::MissingEntry => "who uses the sub-index is refused with abort 0609 0011h",
            Self::UndescribedObject => "no tool shows the object or configures it",
            Self::UndescribedEntry => "no tool shows the sub-index or configures it",
            Self::Length => "a value of the described length is refused with abort 0607 0010h, or is read wrongly",
            Self::NoValue => "a tool can't show the value",
            Self::Access => "a tool reads what it can't, or does not read what it could",
            Self::Limits => "a tool shows the value as wrong, and can't write it back",
            Self::Count => "a tool looks at too few sub-indexes, or at too many",
            Self::Constant => "it never changes by the description: another release or variant of the device",
            Self::Configured => "the device is not configured as the file says, or not restarted since",
            Self::Setting => {
                "not as delivered: somebody may have configured the device, or its default is not that of the description"
            }
            Self::State => {
                "the device sets it: it may depend on its state or variant, or its default is not that of the description"
            }
            Self::Mapping => "who takes values out of the PDO by the description gets others",
            Self::Unmappable => "a tool refuses the mapping that the device has",
            Self::CobId => "who expects the described CAN-ID hears nothing or reaches nobody",
            Self::Refused => "the description says that it can be read",
            Self::NoAnswer => "a tool that reads it gets no answer",
            Self::Violation => "a tool that reads it gets no value",
        }
    }
}
