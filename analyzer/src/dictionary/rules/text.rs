//! Rules on the text of the file: characters, lines, comments.

use super::rules;

rules! {
    "eds";

    /// the file has characters that are not ASCII
    ///
    /// CiA 306 requires ASCII. Some files have UTF-8 or Latin-1, and tools guess differently, so that names of objects
    /// are garbled.
    ///
    /// # What to do
    ///
    /// Write names without accents and special characters.
    ENCODING: Hint Encoding, "eds/text/encoding", "CiA 306" Unknown;

    /// the file begins with a byte order mark
    ///
    /// Tools that do not know the mark treat it as a part of the first line, and then miss the section `[FileInfo]` or
    /// refuse the file.
    ///
    /// # What to do
    ///
    /// Save the file without byte order mark, as ASCII or "UTF-8 without BOM".
    BYTE_ORDER_MARK: Warning Encoding, "eds/text/byte-order-mark", "CiA 306" Unknown;

    /// the file is UTF-16
    ///
    /// Most tools read one byte as one character and find no section in the file.
    ///
    /// # What to do
    ///
    /// Save the file as ASCII.
    UTF_16: Warning Encoding, "eds/text/utf-16", "CiA 306" Unknown;

    /// lines end in more than one way, or in a carriage return alone
    ///
    /// Few tools accept a carriage return alone as the end of a line: others read the whole file as one line, or the
    /// rest of it as a comment.
    ///
    /// # What to do
    ///
    /// End all lines in the same way, with CR LF or LF.
    LINE_ENDS: Hint Encoding, "eds/text/line-ends", "CiA 306" Unknown;

    /// the file has control characters
    ///
    /// Tabulators and line ends are the only control characters with a meaning in a description. Some tools stop
    /// reading at another control character, and its effect on a terminal is unpredictable.
    ///
    /// # What to do
    ///
    /// Remove the control characters.
    CONTROL: Warning Encoding, "eds/text/control-character", "CiA 306" Unknown;

    /// a line is longer than 255 characters
    ///
    /// CiA 306 allows 255 characters; tools with a fixed buffer cut the line and read the rest as another line.
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
    /// In an EDS a comment begins with `;`. Some tools read such a line as a field.
    ///
    /// # What to do
    ///
    /// Begin the comment with `;`.
    COMMENT: Warning Line, "eds/text/comment", "CiA 306" Unknown;

    /// a section line is not closed, or something follows its name
    ///
    /// The line of a section is its name between `[` and `]`. Tools that find no `]` miss the section and assign its
    /// fields to the section before it.
    ///
    /// # What to do
    ///
    /// Close the name with `]`, and move any other text to a separate line.
    SECTION_LINE: Warning Line, "eds/text/section-line", "CiA 306" Unknown;

    /// a merge conflict was left in the file
    ///
    /// A version control system marks the two sides of a conflict by `<<<<<<<`, `=======` and `>>>>>>>`. Tools use
    /// either side.
    ///
    /// # What to do
    ///
    /// Keep one side, and remove the other side and the marks.
    CONFLICT: Error Line, "eds/text/conflict", "CiA 306" Unknown;

    /// half of the lines can't be read
    ///
    /// The file is not a device description, or was damaged: the readable lines are unreliable too.
    ///
    /// # What to do
    ///
    /// Get the file again from its maker.
    HALF_READ: Error Line, "eds/text/half-read", "CiA 306" Unknown;

    /// the file is so large that the rest was left out
    ///
    /// No device description has this many lines or objects. Text beyond the limit was neither read nor checked.
    ///
    /// # What to do
    ///
    /// Split the description, or correct the count that makes it so large.
    TOO_MUCH: Error TooMuch, "eds/text/too-much", "CiA 306" Unknown;
}
