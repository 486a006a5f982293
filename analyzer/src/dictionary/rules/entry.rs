//! Rules on single objects and entries: codes, types, access, limits.

use super::rules;

rules! {
    "eds";

    /// ObjectType is not defined by CiA 301, or does not match the sub-indexes
    ///
    /// ObjectType is 0 (NULL), 2 (DOMAIN), 5 (DEFTYPE), 6 (DEFSTRUCT), 7 (VAR), 8 (ARRAY) or 9 (RECORD); only ARRAY,
    /// RECORD and DEFSTRUCT have sub-indexes.
    ///
    /// # What to do
    ///
    /// Write `ObjectType=0x7` for a single value, `0x8` for entries of one data type, `0x9` for entries of several.
    OBJECT_TYPE: Error Value, "eds/entry/object-type", "CiA 301" "7.4.3" Cited;

    /// a sub-index has an ObjectType of its own
    ///
    /// A sub-index holds one value: its ObjectType is VAR, or DOMAIN if its data type is DOMAIN. Tools that take the
    /// text by its word look for sub-indexes of a sub-index.
    ///
    /// # What to do
    ///
    /// Write `ObjectType=0x7`.
    SUB_OBJECT_TYPE: Warning Value, "eds/entry/sub-object-type", "CiA 306" Unknown;

    /// a VAR has sub-indexes
    ///
    /// An object with sub-indexes is an ARRAY, a RECORD or a DEFSTRUCT. Tools that rely on ObjectType do not find the
    /// sub-indexes.
    ///
    /// # What to do
    ///
    /// Write `ObjectType=0x8` for entries of one data type, `0x9` for entries of several.
    SUBS_OF_VAR: Warning Value, "eds/entry/subs-of-var", "CiA 306" Unknown;

    /// DataType is not defined by CiA 301
    ///
    /// Data types are 0001h to 001Bh and 0020h to 0025h of CiA 301, or 0040h to 025Fh of the manufacturer and the
    /// profiles. The length of any other data type is unknown.
    ///
    /// # What to do
    ///
    /// Correct the data type: it is an index, written in hexadecimal.
    DATA_TYPE: Error Value, "eds/entry/data-type", "CiA 301" "7.4.7.1" Cited;

    /// AccessType is not defined by CiA 306
    ///
    /// AccessType is const, ro, wo, rw, rwr or rww. With another value a tool does not know whether it may read or
    /// write the entry.
    ///
    /// # What to do
    ///
    /// Write one of these access types.
    ACCESS: Error Value, "eds/entry/access", "CiA 306" Unknown;

    /// AccessType has another spelling than in CiA 306
    ///
    /// AccessType is const, ro, wo, rw, rwr or rww. People understand other spellings, but not every tool does.
    ///
    /// # What to do
    ///
    /// Write one of these access types.
    ACCESS_FORM: Warning Value, "eds/entry/access-form", "CiA 306" Unknown;

    /// LowLimit is above HighLimit
    ///
    /// No value lies between the limits: a tool that checks the input of a user refuses every value.
    ///
    /// # What to do
    ///
    /// Correct the limits.
    LIMITS: Error Range, "eds/entry/limits", "CiA 306" Unknown;

    /// a limit does not fit the data type
    ///
    /// The limit is outside the range of the data type. Tools ignore it, or truncate it to another number.
    ///
    /// # What to do
    ///
    /// Write the highest number of the data type, or leave the limit out.
    LIMIT_RANGE: Warning Range, "eds/entry/limit-range", "CiA 306" Unknown;

    /// a value lies outside its limits
    ///
    /// A tool that checks values refuses to write the default back.
    ///
    /// # What to do
    ///
    /// Correct the value or the limits.
    BEYOND_LIMITS: Warning Range, "eds/entry/beyond-limits", "CiA 306" Unknown;

    /// ObjFlags has bits that CiA 306 does not define
    ///
    /// Bit 0 excludes the entry when a tool writes all entries, bit 1 excludes it when a tool reads all entries.
    ///
    /// # What to do
    ///
    /// Write 0, 1, 2 or 3.
    FLAGS: Hint Value, "eds/entry/flags", "CiA 306" Unknown;

    /// the default of a VISIBLE_STRING has characters that are not visible
    ///
    /// A VISIBLE_STRING has the characters 20h to 7Eh.
    ///
    /// # What to do
    ///
    /// Correct the text.
    STRING: Hint Value, "eds/entry/visible-string", "CiA 301" "7.1.6.3" Cited;

    /// sub-index 0 of an ARRAY or RECORD is not UNSIGNED8
    ///
    /// Sub-index 0 holds the highest sub-index, in one byte. A tool that reads it with another length gets the wrong
    /// number.
    ///
    /// # What to do
    ///
    /// Write `DataType=0x0005` for sub-index 0.
    SUB_0: Warning Value, "eds/entry/sub-0-type", "CiA 301" "7.4.7.2" Cited;

    /// the elements of an ARRAY have different data types
    ///
    /// All elements of an ARRAY have the same data type. Tools that use the type of the first element for all misread
    /// the others.
    ///
    /// # What to do
    ///
    /// Correct the data type, or make the object a RECORD (`ObjectType=0x9`).
    ARRAY_TYPE: Warning Value, "eds/entry/array-type", "CiA 301" "7.4.3" Cited;

    /// an ARRAY has a gap in its sub-indexes
    ///
    /// Only a RECORD may leave sub-indexes out.
    ///
    /// # What to do
    ///
    /// Describe the missing sub-indexes, or make the object a RECORD.
    ARRAY_GAP: Hint Count, "eds/entry/array-gap", "CiA 301" "7.4.3" Cited;
}
