//! Rules on standard objects: CiA 301, CiA 302.

use super::rules;

rules! {
    "eds";

    /// a standard object has another object code: a single value in place of sub-indexes, an ARRAY in place of a RECORD
    ///
    /// Tools that know the standard look for the entries at other sub-indexes. An ARRAY can't hold the data types of a
    /// RECORD.
    ///
    /// # What to do
    ///
    /// Describe the object as its standard defines it.
    OBJECT_CODE: Warning Standard, "eds/standard/object-code", "CiA 301" "7.5.2" Cited;

    /// a standard object has the name of another standard object
    ///
    /// The index and the name of the object contradict each other, mostly because the section was copied. A user of a
    /// configuration tool relies on the name and sets the wrong parameter.
    ///
    /// # What to do
    ///
    /// Correct the name, or the index of the section.
    NAME: Warning Standard, "eds/standard/name", "CiA 301" "7.5.2" Cited;

    /// the data type of a standard object differs from the standard
    ///
    /// Masters that know the standard read and write the object with the length of the standard, and a device with
    /// another length aborts.
    ///
    /// # What to do
    ///
    /// Use the data type of the standard. If the device really has another type, that is a fault of the device.
    DATA_TYPE: Warning Standard, "eds/standard/data-type", "CiA 301" "7.5.2" Cited;

    /// the access type of a standard object differs from the standard
    ///
    /// Masters write the objects that are writable in the standard, and expect that read-only objects do not change by
    /// writing.
    ///
    /// # What to do
    ///
    /// Use the access type of the standard.
    ACCESS: Warning Standard, "eds/standard/access", "CiA 301" "7.5.2" Cited;

    /// an object that is writable in the standard can't be written
    ///
    /// Many devices have a fixed value for a parameter; a master that sets it gets abort 0601 0002h.
    ///
    /// # What to do
    ///
    /// No action is needed if the device behaves as described.
    ACCESS_LESS: Hint Standard, "eds/standard/read-only", "CiA 301" "7.5.2" Cited;

    /// an object of the communication profile has PDOMapping=1
    ///
    /// CiA 301 allows only 1001h, 1002h, 1013h, the streams of 1026h and the COB-IDs of SDO parameters to be mapped into
    /// PDOs.
    ///
    /// # What to do
    ///
    /// Set PDOMapping=0.
    MAPPING: Hint Standard, "eds/standard/pdo-mapping", "CiA 301" "7.5.2" Cited;

    /// the default of a standard object is not allowed by its standard
    ///
    /// The value has no meaning, and a device that follows the standard refuses it with abort 0609 0030h.
    ///
    /// # What to do
    ///
    /// Correct the default.
    RANGE: Warning Standard, "eds/standard/range", "CiA 301" "7.5.2" Cited;

    /// an object that every device must have is missing
    ///
    /// Every CANopen device has 1000h (device type) and 1001h (error register).
    ///
    /// # What to do
    ///
    /// Describe the object.
    MANDATORY: Warning MissingSection, "eds/standard/mandatory", "CiA 301" "7.5.2" Known;

    /// the identity object is missing
    ///
    /// 1018h is mandatory since version 4 of CiA 301; without it a master can't identify the device.
    ///
    /// # What to do
    ///
    /// Describe 1018h, if the device has it.
    IDENTITY_MISSING: Hint MissingSection, "eds/standard/identity-missing", "CiA 301" "7.5.2.21" Cited;

    /// an object is described without another object that it needs
    ///
    /// Restoring (1011h) needs storing (1010h), life guarding needs both 100Ch and 100Dh, the EMCY inhibit time (1015h)
    /// needs EMCY (1014h), and synchronous PDOs, their window (1007h) and the SYNC counter (1019h) need SYNC (1005h).
    ///
    /// # What to do
    ///
    /// Describe the other object as well, or remove this object.
    COMPANION: Hint Standard, "eds/standard/companion", "CiA 301" "7.5.2" Cited;
}
