//! Rules on sections: existence and names.

use super::rules;

rules! {
    "eds";

    /// a section stands in the file twice
    ///
    /// Which of the two counts differs between tools: the first, the last, both together; strict ones refuse the file.
    ///
    /// # What to do
    ///
    /// Remove the one that is not meant.
    TWICE: Error DuplicateSection, "eds/section/twice", "CiA 306" Unknown;

    /// a section that CiA 306 asks for is missing
    ///
    /// Every description has FileInfo, DeviceInfo, DummyUsage, Comments, MandatoryObjects, OptionalObjects and
    /// ManufacturerObjects, empty if need be. CiA's conformance test refuses one without.
    ///
    /// # What to do
    ///
    /// Add the section: an empty list has `SupportedObjects=0`, empty comments have `Lines=0`.
    MISSING: Warning MissingSection, "eds/section/missing", "CiA 306" Unknown;

    /// a section is not one that CiA 306 defines
    ///
    /// Other tools leave it out.
    ///
    /// # What to do
    ///
    /// Correct the name if another section is meant.
    UNKNOWN: Hint UnknownSection, "eds/section/unknown", "CiA 306" Unknown;

    /// the index or sub-index in the name of a section is not in the usual form
    ///
    /// The name of an object's section is four hexadecimal digits, `[1018]`; that of a sub-index has its number in
    /// hexadecimal without leading zeros, `[1018sub1]`. Other tools don't find the section.
    ///
    /// # What to do
    ///
    /// Write the name in that form.
    SPELLING: Warning Line, "eds/section/spelling", "CiA 306" Unknown;

    /// sub-indexes are described without their object
    ///
    /// The object's own section says what it is and how many sub-indexes it has. Without it tools don't see the object.
    ///
    /// # What to do
    ///
    /// Add a section such as `[1018]` with ParameterName, ObjectType and SubNumber.
    HEAD_MISSING: Error MissingSection, "eds/section/object-missing", "CiA 306" Unknown;

    /// an ARRAY or RECORD has no sub-indexes
    ///
    /// The entries of such an object are its sub-indexes: without them a tool can't read or write the object.
    ///
    /// # What to do
    ///
    /// Describe the sub-indexes, in sections of their own or by CompactSubObj; or write ObjectType=0x7 for a single
    /// value.
    SUBS_MISSING: Error MissingSection, "eds/section/subs-missing", "CiA 306" Unknown;

    /// an ARRAY or RECORD has no sub-index 0
    ///
    /// Sub-index 0 holds the highest sub-index; a device that has such an object has it.
    ///
    /// # What to do
    ///
    /// Describe sub-index 0.
    SUB_0_MISSING: Warning MissingSection, "eds/section/sub-0-missing", "CiA 301" "7.4.7.2" Cited;
}
