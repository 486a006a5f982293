//! Rules on sections: existence and names.

use super::rules;

rules! {
    "eds";

    /// a section occurs twice in the file
    ///
    /// Some tools use the first section, others the last, or both together; strict tools refuse the file.
    ///
    /// # What to do
    ///
    /// Remove the wrong section.
    TWICE: Error DuplicateSection, "eds/section/twice", "CiA 306" Unknown;

    /// a section that CiA 306 requires is missing
    ///
    /// Every description has FileInfo, DeviceInfo, DummyUsage, Comments, MandatoryObjects, OptionalObjects and
    /// ManufacturerObjects, which may be empty. CiA's conformance test refuses a description without them.
    ///
    /// # What to do
    ///
    /// Add the section: an empty list has `SupportedObjects=0`, empty comments have `Lines=0`.
    MISSING: Warning MissingSection, "eds/section/missing", "CiA 306" Unknown;

    /// a section is not defined by CiA 306
    ///
    /// Other tools ignore the section.
    ///
    /// # What to do
    ///
    /// Correct the name if it is misspelled.
    UNKNOWN: Hint UnknownSection, "eds/section/unknown", "CiA 306" Unknown;

    /// the index or sub-index in the name of a section is not in the usual form
    ///
    /// The name of an object's section is four hexadecimal digits, `[1018]`. The section of a sub-index has its number
    /// in hexadecimal without leading zeros, `[1018sub1]`. Other tools do not find the section.
    ///
    /// # What to do
    ///
    /// Write the name in the usual form.
    SPELLING: Warning Line, "eds/section/spelling", "CiA 306" Unknown;

    /// sub-indexes are described without their object
    ///
    /// The section of the object defines its type and its number of sub-indexes. Without it tools do not find the
    /// object.
    ///
    /// # What to do
    ///
    /// Add a section such as `[1018]` with ParameterName, ObjectType and SubNumber.
    HEAD_MISSING: Error MissingSection, "eds/section/object-missing", "CiA 306" Unknown;

    /// an ARRAY or RECORD has no sub-indexes
    ///
    /// The entries of an ARRAY or RECORD are its sub-indexes: without them a tool can't read or write the object.
    ///
    /// # What to do
    ///
    /// Describe the sub-indexes, in separate sections or by CompactSubObj, or write ObjectType=0x7 for a single value.
    SUBS_MISSING: Error MissingSection, "eds/section/subs-missing", "CiA 306" Unknown;

    /// an ARRAY or RECORD has no sub-index 0
    ///
    /// Sub-index 0 holds the highest sub-index; a device with an ARRAY or RECORD always has it.
    ///
    /// # What to do
    ///
    /// Describe sub-index 0.
    SUB_0_MISSING: Warning MissingSection, "eds/section/sub-0-missing", "CiA 301" "7.4.7.2" Cited;
}
