//! Rules on fields: which exist, and the values of every field of a kind.

use super::rules;

rules! {
    "eds";

    /// a field stands in its section twice, with two values
    ///
    /// Which of the two counts differs between tools; strict ones refuse the file.
    ///
    /// # What to do
    ///
    /// Remove the one that is not meant.
    TWICE: Error DuplicateField, "eds/field/twice", "CiA 306" Unknown;

    /// a field stands in its section twice, with the same value
    ///
    /// Strict tools refuse the file.
    ///
    /// # What to do
    ///
    /// Remove one of the two.
    REPEATED: Warning DuplicateField, "eds/field/repeated", "CiA 306" Unknown;

    /// a field is not one that CiA 306 defines in its section
    ///
    /// Other tools leave it out.
    ///
    /// # What to do
    ///
    /// Correct the name if another field is meant.
    UNKNOWN: Hint UnknownField, "eds/field/unknown", "CiA 306" Unknown;

    /// an object or entry has no name
    ///
    /// Without ParameterName a user of a configuration tool sees a bare number.
    ///
    /// # What to do
    ///
    /// Give it a name.
    NAME_MISSING: Warning MissingField, "eds/field/name-missing", "CiA 306" Unknown;

    /// a name stands in quotes
    ///
    /// An EDS has no quoted texts: the quotes become a part of the name.
    ///
    /// # What to do
    ///
    /// Remove the quotes.
    NAME_QUOTED: Hint Value, "eds/field/name-quoted", "CiA 306" Unknown;

    /// two objects, or two entries of an object, have the same name
    ///
    /// Programs that find objects by their names, such as python-canopen, find only one of them; a user of a configuration
    /// tool can't tell them apart. The first that repeats a name is reported.
    ///
    /// # What to do
    ///
    /// Give each a name of its own, for example with a number.
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
    /// CiA 306 takes it for VAR then; some tools don't.
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
    /// Only a DOMAIN may leave it out, and is `rw` then. For other entries some tools assume `ro`, some `rw`.
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
