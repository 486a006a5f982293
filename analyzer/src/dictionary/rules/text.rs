//! Rules on the text of the file: characters, lines, comments.

use super::rules;

rules! {
    "eds";

    /// the file has characters that are not ASCII
    ///
    /// CiA 306 asks for ASCII. Files in the field have UTF-8 and Latin-1, and tools guess differently, so that names of
    /// objects come out garbled.
    ///
    /// # What to do
    ///
    /// Write names without accents and special signs.
    ENCODING: Hint Encoding, "eds/text/encoding", "CiA 306" Unknown;

    /// the file begins with a byte order mark
    ///
    /// Tools that don't know the mark take it for a part of the first line, and so miss the section `[FileInfo]` or refuse
    /// the file.
    ///
    /// # What to do
    ///
    /// Store the file without byte order mark, as ASCII or "UTF-8 without BOM".
    BYTE_ORDER_MARK: Warning Encoding, "eds/text/byte-order-mark", "CiA 306" Unknown;

    /// the file is UTF-16
    ///
    /// Most tools read one byte as one character and find nothing in such a file.
    ///
    /// # What to do
    ///
    /// Store the file as ASCII.
    UTF_16: Warning Encoding, "eds/text/utf-16", "CiA 306" Unknown;

    /// lines end in more than one way, or in a carriage return alone
    ///
    /// A carriage return alone ends a line for few tools: the others see one line, or the rest of the file as a comment.
    ///
    /// # What to do
    ///
    /// End all lines in the same way, with CR LF or LF.
    LINE_ENDS: Hint Encoding, "eds/text/line-ends", "CiA 306" Unknown;

    /// the file has control characters
    ///
    /// Nothing but tabulators and line ends has a meaning in a description; some tools stop reading at such a character, and
    /// a terminal that shows it may do anything.
    ///
    /// # What to do
    ///
    /// Remove them.
    CONTROL: Warning Encoding, "eds/text/control-character", "CiA 306" Unknown;

    /// a line is longer than 255 characters
    ///
    /// CiA 306 allows 255; tools with a fixed buffer cut the line and take the rest for another one.
    ///
    /// # What to do
    ///
    /// Shorten the text.
    TOO_LONG: Warning Line, "eds/text/line-too-long", "CiA 306" Unknown;

    /// a line is neither section, field nor comment
    ///
    /// A line is `[section]`, `field=value`, `;comment` or empty. Strict tools refuse the whole file, others skip the
    /// line and lose its content.
    ///
    /// # What to do
    ///
    /// Write the missing `=`, or a `;` before a comment.
    UNREAD: Warning Line, "eds/text/unread", "CiA 306" Unknown;

    /// a comment begins with # or //
    ///
    /// In an EDS a comment begins with `;`. Some tools take such a line for a field.
    ///
    /// # What to do
    ///
    /// Begin it with `;`.
    COMMENT: Warning Line, "eds/text/comment", "CiA 306" Unknown;

    /// a section line is not closed, or something follows its name
    ///
    /// The line of a section is its name between `[` and `]`. Tools that find no `]` miss the section, and its fields fall to
    /// the one before it.
    ///
    /// # What to do
    ///
    /// Close the name with `]`, and write anything else in a line of its own.
    SECTION_LINE: Warning Line, "eds/text/section-line", "CiA 306" Unknown;

    /// a merge conflict was left in the file
    ///
    /// A version control system marks the two sides of a conflict by `<<<<<<<`, `=======` and `>>>>>>>`. Which side a tool
    /// takes is chance.
    ///
    /// # What to do
    ///
    /// Choose one side, and remove the other with the marks.
    CONFLICT: Error Line, "eds/text/conflict", "CiA 306" Unknown;

    /// half of the lines can't be read
    ///
    /// Such a file is no device description, or was damaged: its rest is not reliable.
    ///
    /// # What to do
    ///
    /// Get the file again from its maker.
    HALF_READ: Error Line, "eds/text/half-read", "CiA 306" Unknown;

    /// the file is so large that the rest was left out
    ///
    /// No device has so many lines or objects. Nothing beyond the bound was read or checked.
    ///
    /// # What to do
    ///
    /// Split the description, or correct the count that makes it so large.
    TOO_MUCH: Error TooMuch, "eds/text/too-much", "CiA 306" Unknown;
}
