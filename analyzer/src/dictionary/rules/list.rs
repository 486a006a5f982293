//! Rules on lists and counts: of objects, sub-indexes, entries of the short form.

use super::rules;

rules! {
    "eds";

    /// the count of a list is not the number of its entries
    ///
    /// Tools read as many entries as the count says: the rest of the objects is lost, or entries are missed.
    ///
    /// # What to do
    ///
    /// Write the number of entries that follow.
    COUNT: Warning Count, "eds/list/count", "CiA 306" Unknown;

    /// the entries of a list are not numbered from 1 without a gap
    ///
    /// Tools look for the entries 1 to SupportedObjects, and miss those after a gap.
    ///
    /// # What to do
    ///
    /// Number the entries from 1.
    GAP: Warning Count, "eds/list/gap", "CiA 306" Unknown;

    /// the entries of a list are not in the order of their numbers
    ///
    /// All tools read it correctly; only people have trouble.
    ///
    /// # What to do
    ///
    /// Sort the entries.
    ORDER: Hint List, "eds/list/order", "CiA 306" Unknown;

    /// a field of a list has no number as its name
    ///
    /// The field does not count as an object.
    ///
    /// # What to do
    ///
    /// Write the next number before the `=`.
    KEY: Warning Value, "eds/list/key", "CiA 306" Unknown;

    /// an object is listed twice
    ///
    /// An object stands in one list, once; tools may show it twice, or count wrongly.
    ///
    /// # What to do
    ///
    /// Remove one of the entries, and renumber the rest.
    TWICE: Warning List, "eds/list/twice", "CiA 306" Unknown;

    /// an object is listed, but not described
    ///
    /// A tool that goes by the list finds nothing about the object and refuses the file, or leaves the object out.
    ///
    /// # What to do
    ///
    /// Describe the object, or take it off the list.
    UNDESCRIBED: Error List, "eds/list/undescribed", "CiA 306" Unknown;

    /// an object is described, but not listed
    ///
    /// Tools that go by the lists don't see the object.
    ///
    /// # What to do
    ///
    /// Add it to the list of its kind.
    UNLISTED: Warning List, "eds/list/unlisted", "CiA 306" Unknown;

    /// an object is in the wrong list
    ///
    /// 1000h and 1001h (and 1018h, since CiA 301 version 4) are mandatory objects, 2000h to 5FFFh the manufacturer's, all
    /// others optional.
    ///
    /// # What to do
    ///
    /// Move it to the list of its kind.
    WRONG: Warning List, "eds/list/wrong", "CiA 306" Unknown;

    /// SubNumber is not the number of sub-indexes
    ///
    /// Tools read as many sub-indexes as it says, and lose the rest.
    ///
    /// # What to do
    ///
    /// Write the number of sections of this object's sub-indexes, sub-index 0 included.
    SUB_NUMBER: Warning Count, "eds/list/sub-number", "CiA 306" Unknown;

    /// sub-index 0 is not the highest sub-index
    ///
    /// Where sub-index 0 can't be written it holds the highest sub-index that the object has. Tools read up to that number.
    ///
    /// # What to do
    ///
    /// Correct the default of sub-index 0, or describe the sub-indexes that are missing.
    HIGHEST: Warning Count, "eds/list/highest-sub-index", "CiA 301" "7.4.7.2" Cited;

    /// NrOfEntries is not the number of names or values
    ///
    /// The sections `[xxxxName]`, `[xxxxValue]`, `[xxxxDenotation]` and `[xxxxObjectLinks]` count their entries.
    ///
    /// # What to do
    ///
    /// Write the number of entries that follow.
    BESIDE: Warning Count, "eds/list/entries", "CiA 306" Unknown;

    /// a name or value is for a sub-index that the short form does not make
    ///
    /// CompactSubObj makes the sub-indexes 1 to its number; only these can have names and values of their own.
    ///
    /// # What to do
    ///
    /// Correct the sub-index, or CompactSubObj.
    BESIDE_KEY: Warning Value, "eds/list/entry-key", "CiA 306" Unknown;

    /// a link leads to an object that is not described
    ///
    /// `[xxxxObjectLinks]` names objects that belong together; a tool finds nothing there.
    ///
    /// # What to do
    ///
    /// Correct the index, or describe the object.
    LINK: Warning List, "eds/list/link", "CiA 306" Unknown;
}
