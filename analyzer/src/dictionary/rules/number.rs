//! Rules on the form and the range of numbers and formulas.

use super::rules;

rules! {
    "eds";

    /// a number or value can't be read
    ///
    /// canvass ignores the text, so the field has no value.
    ///
    /// # What to do
    ///
    /// Write a decimal number, a hexadecimal number with 0x, or a formula such as `$NODEID+0x180`.
    UNREADABLE: Error Number, "eds/number/unreadable", "CiA 306" Unknown;

    /// a number has a form that CiA 306 does not define
    ///
    /// CiA 306 defines decimal numbers, hexadecimal numbers with 0x, octal numbers with a leading 0, and formulas with
    /// `$NODEID`. Only some tools understand a trailing h, quotes, a decimal point or other spellings.
    ///
    /// # What to do
    ///
    /// Write the number in one of these forms.
    FORM: Warning Number, "eds/number/form", "CiA 306" Unknown;

    /// the node-ID stands after the number in a formula
    ///
    /// The form of CiA 306 is `$NODEID+0x180`. Some tools read `0x180+$NODEID` as 180h, so that every device gets the
    /// same COB-ID.
    ///
    /// # What to do
    ///
    /// Write `$NODEID` first.
    NODE_ID_BEHIND: Warning Number, "eds/number/node-id-behind", "CiA 306" Unknown;

    /// a number begins with 0, which makes it octal
    ///
    /// CiA 306 reads `010` as 8; many tools and most authors read 10.
    ///
    /// # What to do
    ///
    /// Write the intended number without leading 0.
    OCTAL: Warning Number, "eds/number/octal", "CiA 306" Unknown;

    /// a comment stands after a value
    ///
    /// In CiA 306 a comment is a separate line. Most tools nevertheless ignore a comment after a value.
    ///
    /// # What to do
    ///
    /// Move the comment to a separate line.
    COMMENT: Hint Number, "eds/number/comment", "CiA 306" Unknown;

    /// a number does not fit its data type
    ///
    /// The device can't hold the number, and a tool that writes it sends the wrong bytes or nothing. A formula must
    /// also fit with node-ID 127.
    ///
    /// # What to do
    ///
    /// Correct the number or the data type.
    RANGE: Error Range, "eds/number/range", "CiA 306" Unknown;

    /// a number fits its data type only as a bit pattern
    ///
    /// The number is negative for an unsigned type, or a decimal number above the maximum of a signed type. canvass
    /// uses its bit pattern, but not every tool does. The same holds for HighLimit=0xFF of a signed type, which is -1.
    ///
    /// # What to do
    ///
    /// Write a number within the range of the data type, or write it in hexadecimal.
    WRAPPED: Warning Range, "eds/number/wrapped", "CiA 306" Unknown;
}
