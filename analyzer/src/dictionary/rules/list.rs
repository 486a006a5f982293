//! Rules on lists and counts: of objects, sub-indexes, entries of the short form.

use super::rules;

rules! {
    "eds";

    /// the count of a list is not the number of its entries
    ///
    /// Tools read the number of entries that the count gives: further objects are lost, or entries are missing.
    ///
    /// # What to do
    ///
    /// Write the number of entries that follow.
    COUNT: Warning Count, "eds/list/count", "CiA 306" Unknown;

    /// the numbers of the entries of a list do not start at 1, or have a gap
    ///
    /// Tools look for the entries 1 to SupportedObjects, and miss the entries after a gap.
    ///
    /// # What to do
    ///
    /// Number the entries from 1 without a gap.
    GAP: Warning Count, "eds/list/gap", "CiA 306" Unknown;

    /// the entries of a list are not in the order of their numbers
    ///
    /// All tools read the list correctly; only people find it hard to read.
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
    /// An object occurs once, in one list. Tools may show it twice, or count wrongly.
    ///
    /// # What to do
    ///
    /// Remove one of the two entries, and renumber the others.
    TWICE: Warning List, "eds/list/twice", "CiA 306" Unknown;

    /// an object is listed, but not described
    ///
    /// A tool that relies on the list does not find the object and refuses the file, or omits the object.
    ///
    /// # What to do
    ///
    /// Describe the object, or remove it from the list.
    UNDESCRIBED: Error List, "eds/list/undescribed", "CiA 306" Unknown;

    /// an object is described, but not listed
    ///
    /// Tools that rely on the lists do not find the object.
    ///
    /// # What to do
    ///
    /// Add the object to the list of its kind.
    UNLISTED: Warning List, "eds/list/unlisted", "CiA 306" Unknown;

    /// an object is in the wrong list
    ///
    /// 1000h and 1001h (and 1018h, since CiA 301 version 4) are mandatory objects, 2000h to 5FFFh are
    /// manufacturer-specific objects, and all others are optional objects.
    ///
    /// # What to do
    ///
    /// Move the object to the list of its kind.
    WRONG: Warning List, "eds/list/wrong", "CiA 306" Unknown;

    /// SubNumber is not the number of sub-indexes
    ///
    /// Tools read the number of sub-indexes that SubNumber gives, and lose the others.
    ///
    /// # What to do
    ///
    /// Write the number of sections of this object's sub-indexes, sub-index 0 included.
    SUB_NUMBER: Warning Count, "eds/list/sub-number", "CiA 306" Unknown;

    /// sub-index 0 is not the highest sub-index
    ///
    /// A sub-index 0 that can't be written holds the highest sub-index of the object. Tools read the sub-indexes up to
    /// that number.
    ///
    /// # What to do
    ///
    /// Correct the default of sub-index 0, or describe the missing sub-indexes.
    HIGHEST: Warning Count, "eds/list/highest-sub-index", "CiA 301" "7.4.7.2" Cited;

    /// NrOfEntries is not the number of names or values
    ///
    /// The sections `[xxxxName]`, `[xxxxValue]`, `[xxxxDenotation]` and `[xxxxObjectLinks]` count their entries.
    ///
    /// # What to do
    ///
    /// Write the number of entries that follow.
    BESIDE: Warning Count, "eds/list/entries", "CiA 306" Unknown;

    /// a name or value belongs to a sub-index that CompactSubObj does not create
    ///
    /// CompactSubObj creates the sub-indexes from 1 to its number. Only these can have their own names and values.
    ///
    /// # What to do
    ///
    /// Correct the sub-index, or CompactSubObj.
    BESIDE_KEY: Warning Value, "eds/list/entry-key", "CiA 306" Unknown;

    /// a link leads to an object that is not described
    ///
    /// `[xxxxObjectLinks]` names objects that belong together; a tool finds no object at this index.
    ///
    /// # What to do
    ///
    /// Correct the index, or describe the object.
    LINK: Warning List, "eds/list/link", "CiA 306" Unknown;
}
