//! Rules on fields: which exist, and the values of every field of a kind.

use super::rules;

rules! {
    "eds";

    /// a field occurs twice in its section, with two values
    ///
    /// Some tools use the first value, others the second; strict tools refuse the file.
    ///
    /// # What to do
    ///
    /// Remove the wrong field.
    TWICE: Error DuplicateField, "eds/field/twice", "CiA 306" Unknown;

    /// a field occurs twice in its section, with the same value
    ///
    /// Strict tools refuse the file.
    ///
    /// # What to do
    ///
    /// Remove one of the two fields.
    REPEATED: Warning DuplicateField, "eds/field/repeated", "CiA 306" Unknown;

    /// a field is not defined by CiA 306 in its section
    ///
    /// Other tools ignore the field.
    ///
    /// # What to do
    ///
    /// Correct the name if it is misspelled.
    UNKNOWN: Hint UnknownField, "eds/field/unknown", "CiA 306" Unknown;

    /// a field's name contains blanks
    ///
    /// canvass reads `Supported Objects` as `SupportedObjects`. Other tools do not find the field.
    ///
    /// # What to do
    ///
    /// Remove the blanks from the name.
    BLANKS: Warning UnknownField, "eds/field/blanks", "CiA 306" Unknown;

    /// an EDS has the value of a configured device
    ///
    /// ParameterValue belongs to a DCF, which has the section DeviceComissioning. An EDS describes a type of device, and
    /// its values are defaults. canvass does not use the value. It takes a file for an EDS if the name in FileInfo ends
    /// in .eds and the section is missing. The first value is reported, with the number of all.
    ///
    /// # What to do
    ///
    /// Write the value as DefaultValue, or make the file a DCF.
    CONFIGURED: Warning UnknownField, "eds/field/configured", "CiA 306" Unknown;

    /// an object or entry has no name
    ///
    /// Without ParameterName a user of a configuration tool sees only a number.
    ///
    /// # What to do
    ///
    /// Add ParameterName.
    NAME_MISSING: Warning MissingField, "eds/field/name-missing", "CiA 306" Unknown;

    /// a name is enclosed in quotes
    ///
    /// An EDS does not quote texts: the quotes become a part of the name.
    ///
    /// # What to do
    ///
    /// Remove the quotes.
    NAME_QUOTED: Hint Value, "eds/field/name-quoted", "CiA 306" Unknown;

    /// two objects, or two entries of an object, have the same name
    ///
    /// Programs that find objects by their names, such as python-canopen, find only one of the two; a user of a
    /// configuration tool can't distinguish them. The rule reports the first object or entry that repeats a name.
    ///
    /// # What to do
    ///
    /// Give each a unique name, for example with a number.
    NAME_TWICE: Hint Value, "eds/field/name-twice", "CiA 306" Unknown;

    /// a name has more than 241 characters
    ///
    /// CiA 306 allows 241.
    ///
    /// # What to do
    ///
    /// Shorten the name.
    NAME_LONG: Warning Value, "eds/field/name-too-long", "CiA 306" Unknown;

    /// ObjectType is missing
    ///
    /// CiA 306 then assumes VAR; some tools do not.
    ///
    /// # What to do
    ///
    /// Write `ObjectType=0x7`.
    OBJECT_TYPE_MISSING: Hint MissingField, "eds/field/object-type-missing", "CiA 306" Unknown;

    /// DataType is missing
    ///
    /// Without a data type a tool does not know how many bytes to read or to write.
    ///
    /// # What to do
    ///
    /// Give the index of the data type, such as `DataType=0x0007` for UNSIGNED32.
    DATA_TYPE_MISSING: Error MissingField, "eds/field/data-type-missing", "CiA 306" Unknown;

    /// AccessType is missing
    ///
    /// Only a DOMAIN may omit AccessType, and is `rw` then. For other entries some tools assume `ro`, others `rw`.
    ///
    /// # What to do
    ///
    /// Write const, ro, wo, rw, rwr or rww.
    ACCESS_MISSING: Warning MissingField, "eds/field/access-missing", "CiA 306" Unknown;

    /// a flag is neither 0 nor 1
    ///
    /// Fields such as PDOMapping or LSS_Supported are 0 or 1. Tools interpret other values differently.
    ///
    /// # What to do
    ///
    /// Write 0 or 1.
    FLAG: Warning Value, "eds/field/flag", "CiA 306" Unknown;

    /// a number is outside the range of its field
    ///
    /// The value can't be used.
    ///
    /// # What to do
    ///
    /// Correct the number.
    RANGE: Error Value, "eds/field/range", "CiA 306" Unknown;
}
