//! Rules on the data about the file and the whole device: FileInfo, DeviceInfo, DummyUsage, Comments, commissioning.

use super::rules;

rules! {
    "eds";

    /// a date has not the form mm-dd-yyyy
    ///
    /// Tools that compare dates to find the newer description take the wrong one.
    ///
    /// # What to do
    ///
    /// Write month, day and year: `12-31-2026`.
    DATE: Warning Value, "eds/file/date", "CiA 306" Unknown;

    /// a time has not the form hh:mm(AM|PM)
    ///
    /// CiA 306 counts twelve hours, with AM or PM. An hour of one digit is usual and read by all tools.
    ///
    /// # What to do
    ///
    /// Write the time as `09:00PM`.
    TIME: Warning Value, "eds/file/time", "CiA 306" Unknown;

    /// EDSVersion is not a version of CiA 306
    ///
    /// It is 3.0 or 4.0; without it tools take 3.0.
    ///
    /// # What to do
    ///
    /// Write `EDSVersion=4.0`. The version of the file itself is FileVersion.
    VERSION: Hint Value, "eds/file/eds-version", "CiA 306" Unknown;

    /// FileName is not the name of the file
    ///
    /// A file that was copied and renamed can't be distinguished from the one that it was made of.
    ///
    /// # What to do
    ///
    /// Write the name of the file.
    NAME: Hint Value, "eds/file/name", "CiA 306" Unknown;

    /// an EDS has LastEDS
    ///
    /// Only a DCF names the EDS that it was made from. CiA's conformance test warns of it.
    ///
    /// # What to do
    ///
    /// Remove the field.
    LAST_EDS: Hint Value, "eds/file/last-eds", "CiA 306" Unknown;

    /// a field that every FileInfo or DeviceInfo has is missing
    ///
    /// Tools show these fields and look for a device by them.
    ///
    /// # What to do
    ///
    /// Add the field.
    FIELD_MISSING: Hint MissingField, "eds/file/field-missing", "CiA 306" Unknown;

    /// no bit rate is supported
    ///
    /// A tool that sets up a network finds no bit rate that this device shares with others.
    ///
    /// # What to do
    ///
    /// Set the bit rates that the device supports, such as `BaudRate_250=1`.
    BIT_RATE_MISSING: Warning MissingField, "eds/device/bit-rate-missing", "CiA 306" Unknown;

    /// NrOfRXPDO or NrOfTXPDO is not the number of PDOs
    ///
    /// They count the objects 1400h to 15FFh and 1800h to 19FFh that the file describes.
    ///
    /// # What to do
    ///
    /// Write the number of PDOs that are described, or describe the others.
    PDO_COUNT: Warning Count, "eds/device/pdo-count", "CiA 306" Unknown;

    /// VendorNumber, ProductNumber or RevisionNumber differs from the identity object
    ///
    /// A tool that looks for the description of a device compares what it reads of 1018h with these fields.
    ///
    /// # What to do
    ///
    /// Give both the same number.
    IDENTITY: Warning Value, "eds/device/identity", "CiA 306" Unknown;

    /// LSS is supported, but the identity object is not complete
    ///
    /// An LSS master addresses a device by vendor-ID, product code, revision number and serial number: 1018h with
    /// sub-indexes 1 to 4.
    ///
    /// # What to do
    ///
    /// Describe all four sub-indexes of 1018h, or set LSS_Supported=0.
    LSS: Hint MissingSection, "eds/device/lss-identity", "CiA 305" Known;

    /// the device has neither heartbeat nor node guarding
    ///
    /// A device has the heartbeat (1017h), or node guarding with both guard time (100Ch) and life time factor (100Dh):
    /// otherwise no node notices its loss.
    ///
    /// # What to do
    ///
    /// Describe 1017h.
    ERROR_CONTROL: Warning MissingSection, "eds/device/error-control", "CiA 301" "7.2.8.2.2" Cited;

    /// a field of DummyUsage has not the name of a data type
    ///
    /// Its fields are called Dummy and the four digits of a data type's index, such as Dummy0005 for UNSIGNED8.
    ///
    /// # What to do
    ///
    /// Write all four digits.
    DUMMY: Warning Value, "eds/device/dummy-name", "CiA 306" Unknown;

    /// Lines is not the number of lines of comments
    ///
    /// Tools that go by the number lose lines, or look for ones that are not there.
    ///
    /// # What to do
    ///
    /// Write the number of lines that follow.
    COMMENT_COUNT: Warning Count, "eds/file/comment-count", "CiA 306" Unknown;

    /// the node-ID of a DCF is not one of 1 to 127
    ///
    /// No device can be given such a node-ID.
    ///
    /// # What to do
    ///
    /// Write a node-ID from 1 to 127.
    NODE_ID: Error Value, "eds/dcf/node-id", "CiA 306" Unknown;

    /// the bit rate of a DCF is not one of CiA 301
    ///
    /// It is 10, 20, 50, 100, 125, 250, 500, 800 or 1000, in kbit/s.
    ///
    /// # What to do
    ///
    /// Write one of them, without unit.
    BIT_RATE: Error Value, "eds/dcf/bit-rate", "CiA 306" Unknown;

    /// a DCF leaves its node-ID or bit rate open
    ///
    /// A node-ID of 255 means that the device gets its node-ID by LSS, and a bit rate of 0 means none: a tool with only
    /// this file can't find the device.
    ///
    /// # What to do
    ///
    /// Write the node-ID and the bit rate of the network, or remove the field.
    OPEN: Warning Value, "eds/dcf/open", "CiA 306" Unknown;

    /// a DCF names a file to download that is not there
    ///
    /// DownloadFile of a DOMAIN is what a configuration tool writes to the device. Without it the tool stops, or leaves the
    /// object as it is. A plain file name is looked for beside the DCF.
    ///
    /// # What to do
    ///
    /// Put the file beside the DCF, or correct the name.
    DOWNLOAD: Warning MissingField, "eds/dcf/download-file", "CiA 306" Unknown;

    /// a DCF describes the device differently from its EDS
    ///
    /// A DCF is its EDS with the values that one device is configured to. If objects, types, access or limits differ,
    /// the DCF belongs to another release of the device, or was edited. LastEDS names the EDS, which is looked for
    /// beside the DCF.
    ///
    /// # What to do
    ///
    /// Make the DCF again from the right EDS; `canvass eds diff` shows all differences.
    OTHER_EDS: Warning List, "eds/dcf/other-eds", "CiA 306" Unknown;

    /// the section DeviceComissioning is written with double m
    ///
    /// CiA 306 spells it with one m; tools that look for that don't find node-ID and bit rate.
    ///
    /// # What to do
    ///
    /// Write `[DeviceComissioning]`.
    COMMISSIONING: Hint UnknownSection, "eds/dcf/section-name", "CiA 306" Unknown;
}
