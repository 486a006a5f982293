//! Rules on standard objects: CiA 301, CiA 302, CiA 406.

use super::rules;

rules! {
    "eds";

    /// a standard object is described as a single value although it has sub-indexes, or vice versa
    ///
    /// Tools that know the standard look for the entries at other sub-indexes.
    ///
    /// # What to do
    ///
    /// Describe the object as its standard defines it.
    OBJECT_CODE: Warning Standard, "eds/standard/object-code", "CiA 301" "7.5.2" Cited;

    /// an object of a standard has the name of another one
    ///
    /// Its index says what it is, and the name says something else, mostly because the section was copied. A user of a
    /// configuration tool goes by the name and sets the wrong parameter.
    ///
    /// # What to do
    ///
    /// Correct the name, or the index of the section.
    NAME: Warning Standard, "eds/standard/name", "CiA 301" "7.5.2" Cited;

    /// an object of a standard has another data type
    ///
    /// Masters that know the standard read and write the object in the standard's length, and a device with another one
    /// aborts.
    ///
    /// # What to do
    ///
    /// Use the data type of the standard. If the device really has another type, that is a fault of the device.
    DATA_TYPE: Warning Standard, "eds/standard/data-type", "CiA 301" "7.5.2" Cited;

    /// an object of a standard has another access type
    ///
    /// Masters write what the standard lets them write, and rely on not overwriting what is read only.
    ///
    /// # What to do
    ///
    /// Use the access type of the standard.
    ACCESS: Warning Standard, "eds/standard/access", "CiA 301" "7.5.2" Cited;

    /// an object that the standard makes writable can't be written
    ///
    /// Many devices fix a parameter; a master that sets it gets abort 0601 0002h.
    ///
    /// # What to do
    ///
    /// Nothing, if the device is like that.
    ACCESS_LESS: Hint Standard, "eds/standard/read-only", "CiA 301" "7.5.2" Cited;

    /// an object of the communication profile has PDOMapping=1
    ///
    /// CiA 301 lets only 1001h, 1002h and 1013h be mapped into PDOs.
    ///
    /// # What to do
    ///
    /// Set PDOMapping=0.
    MAPPING: Hint Standard, "eds/standard/pdo-mapping", "CiA 301" "7.5.2" Cited;

    /// the default of a standard object is outside what its standard allows
    ///
    /// Such a value has no meaning, and a device that follows the standard refuses it with abort 0609 0030h.
    ///
    /// # What to do
    ///
    /// Correct the default.
    RANGE: Warning Standard, "eds/standard/range", "CiA 301" "7.5.2" Cited;

    /// an object that every device has is missing
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

    /// an object is there without the one that it belongs to
    ///
    /// Restoring (1011h) needs storing (1010h), life guarding both 100Ch and 100Dh, the EMCY inhibit time (1015h) needs
    /// EMCY (1014h), the window of synchronous PDOs (1007h) and the SYNC counter (1019h) need SYNC (1005h).
    ///
    /// # What to do
    ///
    /// Describe the other object, too, or remove this one.
    COMPANION: Hint Standard, "eds/standard/companion", "CiA 301" "7.5.2" Cited;

    /// the number of revolutions contradicts the type of the encoder
    ///
    /// The high word of 1000h says single-turn (1) or multi-turn (2); a single-turn encoder has one distinguishable
    /// revolution (6502h), a multi-turn encoder more.
    ///
    /// # What to do
    ///
    /// Correct the default of 1000h or of 6502h.
    REVOLUTIONS: Warning Standard, "eds/encoder/revolutions", "CiA 406" Known;

    /// the total measuring range is larger than the encoder's resolution
    ///
    /// The steps of a revolution (6501h) times the number of revolutions (6502h) are all positions that there are; the
    /// default of 6002h is beyond that, or its HighLimit where 6501h and 6502h are constant.
    ///
    /// # What to do
    ///
    /// Correct 6002h, 6501h or 6502h.
    MEASURING_RANGE: Warning Range, "eds/encoder/measuring-range", "CiA 406" Known;

    /// the measuring units per revolution are more than the encoder's resolution
    ///
    /// The default of 6001h is beyond the steps of a revolution (6501h), or its HighLimit where 6501h is constant: the
    /// position would count in steps that the encoder does not see.
    ///
    /// # What to do
    ///
    /// Correct 6001h or 6501h.
    UNITS: Warning Range, "eds/encoder/units-per-revolution", "CiA 406" Known;

    /// the preset value lies outside the measuring range
    ///
    /// The position counts from 0 up to the total measuring range (6002h), which is not reached. The default of 6003h, or its
    /// HighLimit where 6002h is constant, lies beyond: a device refuses such a value with abort 0609 0030h.
    ///
    /// # What to do
    ///
    /// Correct 6003h or 6002h.
    PRESET: Warning Range, "eds/encoder/preset", "CiA 406" Known;
}
