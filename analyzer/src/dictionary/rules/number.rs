//! Rules on the form and the range of numbers and formulas.

use super::rules;

rules! {
    "eds";

    /// a number or value can't be read
    ///
    /// The text could not be used: the field has no value.
    ///
    /// # What to do
    ///
    /// Write a decimal number, a hexadecimal one with 0x, or a formula such as `$NODEID+0x180`.
    UNREADABLE: Error Number, "eds/number/unreadable", "CiA 306" Unknown;

    /// a number is written in a form that CiA 306 has not
    ///
    /// It has decimal numbers, hexadecimal ones with 0x, octal ones with a leading 0, and formulas with `$NODEID`. A trailing
    /// h, quotes, a decimal point or other spellings are understood by some tools only.
    ///
    /// # What to do
    ///
    /// Write the number in one of these forms.
    FORM: Warning Number, "eds/number/form", "CiA 306" Unknown;

    /// the node-ID stands after the number in a formula
    ///
    /// CiA 306 has `$NODEID+0x180`. Some tools read `0x180+$NODEID` as 180h, and so give every device the same COB-ID.
    ///
    /// # What to do
    ///
    /// Write `$NODEID` first.
    NODE_ID_BEHIND: Warning Number, "eds/number/node-id-behind", "CiA 306" Unknown;

    /// a number begins with 0, which makes it octal
    ///
    /// `010` is 8 by CiA 306; many tools, and most authors, read 10.
    ///
    /// # What to do
    ///
    /// Write the number that is meant without leading 0.
    OCTAL: Warning Number, "eds/number/octal", "CiA 306" Unknown;

    /// a comment stands after a value
    ///
    /// In CiA 306 a comment has a line of its own. Most tools cut it off all the same.
    ///
    /// # What to do
    ///
    /// Move the comment into a line of its own.
    COMMENT: Hint Number, "eds/number/comment", "CiA 306" Unknown;

    /// a number does not fit its data type
    ///
    /// The device can't hold it, and a tool that writes it sends the wrong bytes or nothing. A formula must fit with node-ID
    /// 127.
    ///
    /// # What to do
    ///
    /// Correct the number or the data type.
    RANGE: Error Range, "eds/number/range", "CiA 306" Unknown;

    /// a number fits its data type only by its bits
    ///
    /// A negative number for an unsigned type, or a decimal one above the highest of a signed type: canvass takes it as
    /// its bits, but not every tool does. The same holds for HighLimit=0xFF of a signed type, which is -1.
    ///
    /// # What to do
    ///
    /// Write a number within the range of the data type, or write it in hexadecimal.
    WRAPPED: Warning Range, "eds/number/wrapped", "CiA 306" Unknown;
}
