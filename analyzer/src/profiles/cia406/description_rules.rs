//! The rules for descriptions of encoders.

use crate::dictionary::rules::{OfProfile, rules};

inventory::submit! { OfProfile(RULES) }

rules! {
    "eds";

    /// the number of revolutions contradicts the type of the encoder
    ///
    /// The high word of 1000h is 1 for a single-turn encoder and 2 for a multi-turn encoder. A single-turn encoder has
    /// one distinguishable revolution (6502h), a multi-turn encoder has several.
    ///
    /// # What to do
    ///
    /// Correct the default of 1000h or of 6502h.
    REVOLUTIONS: Warning Standard, "eds/encoder/revolutions", "CiA 406" Known;

    /// the total measuring range is larger than the encoder's resolution
    ///
    /// The number of positions is the steps of a revolution (6501h) multiplied by the number of revolutions (6502h).
    /// The default of 6002h exceeds it, or the HighLimit of 6002h if 6501h and 6502h are constant.
    ///
    /// # What to do
    ///
    /// Correct 6002h, 6501h or 6502h.
    MEASURING_RANGE: Warning Range, "eds/encoder/measuring-range", "CiA 406" Known;

    /// the measuring units per revolution are more than the encoder's resolution
    ///
    /// The default of 6001h exceeds the steps of a revolution (6501h), or the HighLimit of 6001h does if 6501h is
    /// constant: the position would count in steps that the encoder can't measure.
    ///
    /// # What to do
    ///
    /// Correct 6001h or 6501h.
    UNITS: Warning Range, "eds/encoder/units-per-revolution", "CiA 406" Known;

    /// the preset value lies outside the measuring range
    ///
    /// The position is always below the total measuring range (6002h). The default of 6003h is not, or the HighLimit of
    /// 6003h if 6002h is constant: a device refuses such a value with abort 0609 0030h.
    ///
    /// # What to do
    ///
    /// Correct 6003h or 6002h.
    PRESET: Warning Range, "eds/encoder/preset", "CiA 406" Known;
}
