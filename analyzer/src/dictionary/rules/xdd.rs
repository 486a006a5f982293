//! Rules on descriptions in XML.

use super::rules;

rules! {
    "xdd";

    /// the file is not well-formed XML
    ///
    /// Tools can't read the rest of the file.
    ///
    /// # What to do
    ///
    /// Close all open elements, and write & as &amp;.
    MALFORMED: Error Line, "xdd/text/malformed", "CiA 311" Unknown;

    /// an element has an attribute twice
    ///
    /// XML forbids it: other tools refuse the file.
    ///
    /// # What to do
    ///
    /// Remove one of the two.
    ATTRIBUTE_TWICE: Warning DuplicateField, "xdd/element/attribute-twice", "CiA 311" Unknown;

    /// an object or sub-index is described twice
    ///
    /// Some tools use the first description, others the second.
    ///
    /// # What to do
    ///
    /// Remove the wrong description.
    TWICE: Error DuplicateSection, "xdd/object/twice", "CiA 311" Unknown;

    /// a hexadecimal number has a prefix
    ///
    /// Index, subIndex, dataType and objFlags are hexadecimal digits without 0x: a file with a prefix violates the
    /// schema.
    ///
    /// # What to do
    ///
    /// Remove the 0x.
    PREFIX: Warning Number, "xdd/number/prefix", "CiA 311" Unknown;

    /// an index, data type or flag is not a hexadecimal number, or too large
    ///
    /// canvass ignores the value.
    ///
    /// # What to do
    ///
    /// Write the hexadecimal digits.
    NUMBER: Error Number, "xdd/number/unreadable", "CiA 311" Unknown;

    /// an object refers to a missing parameter
    ///
    /// uniqueIDRef names a parameter of the application process; the parameter describes type and access.
    ///
    /// # What to do
    ///
    /// Correct the reference, or describe the parameter.
    REFERENCE: Error Value, "xdd/object/reference", "CiA 311" Unknown;

    /// subNumber is not the number of sub-indexes
    ///
    /// Tools read the number of sub-indexes that subNumber gives.
    ///
    /// # What to do
    ///
    /// Write the number of CANopenSubObject elements.
    SUB_NUMBER: Warning Count, "xdd/object/sub-number", "CiA 311" Unknown;

    /// objectType is not defined by CiA 301
    ///
    /// objectType is 0, 2, 5, 6, 7, 8 or 9.
    ///
    /// # What to do
    ///
    /// Write 7 for a single value, 8 for entries of one data type, 9 for entries of several.
    OBJECT_TYPE: Error Value, "xdd/object/object-type", "CiA 311" Unknown;

    /// an object has no data type
    ///
    /// Without a data type a tool does not know how many bytes to read or to write.
    ///
    /// # What to do
    ///
    /// Add dataType, or a reference to a parameter with a data type.
    DATA_TYPE_MISSING: Error MissingField, "xdd/object/data-type-missing", "CiA 311" Unknown;

    /// accessType is not defined by CiA 311
    ///
    /// accessType is const, ro, wo or rw. With another value a tool does not know whether it may read or write the
    /// entry.
    ///
    /// # What to do
    ///
    /// Write one of these access types.
    ACCESS: Warning Value, "xdd/object/access", "CiA 311" Unknown;

    /// accessType is missing
    ///
    /// The access type is unknown; canvass assumes ro.
    ///
    /// # What to do
    ///
    /// Write const, ro, wo or rw.
    ACCESS_DEFAULT: Hint MissingField, "xdd/object/access-missing", "CiA 311" Unknown;
}
