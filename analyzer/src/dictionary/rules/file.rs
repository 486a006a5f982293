//! Rules on the data about the file and the whole device: FileInfo, DeviceInfo, DummyUsage, Comments, commissioning.

use super::rules;

rules! {
    "eds";

    /// a date does not have the form mm-dd-yyyy
    ///
    /// Tools that compare dates to find the newer description choose the wrong one.
    ///
    /// # What to do
    ///
    /// Write month, day and year: `12-31-2026`.
    DATE: Warning Value, "eds/file/date", "CiA 306" Unknown;

    /// a time does not have the form hh:mm(AM|PM)
    ///
    /// CiA 306 uses twelve hours with AM or PM. An hour of one digit is usual, and all tools read it.
    ///
    /// # What to do
    ///
    /// Write the time as `09:00PM`.
    TIME: Warning Value, "eds/file/time", "CiA 306" Unknown;

    /// EDSVersion is not a version of CiA 306
    ///
    /// EDSVersion is 3.0 or 4.0. If it is missing, tools assume 3.0.
    ///
    /// # What to do
    ///
    /// Write `EDSVersion=4.0`. The version of the file itself is FileVersion.
    VERSION: Hint Value, "eds/file/eds-version", "CiA 306" Unknown;

    /// FileName is not the name of the file
    ///
    /// A file that was copied and renamed can't be distinguished from its original.
    ///
    /// # What to do
    ///
    /// Write the name of the file.
    NAME: Hint Value, "eds/file/name", "CiA 306" Unknown;

    /// an EDS has the field LastEDS
    ///
    /// LastEDS belongs in a DCF, where it names the EDS from which the DCF was made. CiA's conformance test warns about
    /// it in an EDS.
    ///
    /// # What to do
    ///
    /// Remove the field.
    LAST_EDS: Hint Value, "eds/file/last-eds", "CiA 306" Unknown;

    /// a standard field of FileInfo or DeviceInfo is missing
    ///
    /// Tools show these fields and use them to find a device.
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
    /// NrOfRXPDO and NrOfTXPDO count the objects 1400h to 15FFh and 1800h to 19FFh that the file describes.
    ///
    /// # What to do
    ///
    /// Write the number of described PDOs, or describe the missing PDOs.
    PDO_COUNT: Warning Count, "eds/device/pdo-count", "CiA 306" Unknown;

    /// VendorNumber, ProductNumber or RevisionNumber differs from the identity object
    ///
    /// A tool that looks for the description of a device compares the values of 1018h with these fields.
    ///
    /// # What to do
    ///
    /// Write the same number in both places.
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
    /// A device supports the heartbeat (1017h), or node guarding with both guard time (100Ch) and life time factor
    /// (100Dh): otherwise no node detects its loss.
    ///
    /// # What to do
    ///
    /// Describe 1017h.
    ERROR_CONTROL: Warning MissingSection, "eds/device/error-control", "CiA 301" "7.2.8.2.2" Cited;

    /// a field of DummyUsage does not have the name of a data type
    ///
    /// The name of a field is Dummy and the four digits of the data type's index, such as Dummy0005 for UNSIGNED8.
    ///
    /// # What to do
    ///
    /// Write all four digits.
    DUMMY: Warning Value, "eds/device/dummy-name", "CiA 306" Unknown;

    /// Lines is not the number of comment lines
    ///
    /// Tools that rely on the number lose lines, or look for missing lines.
    ///
    /// # What to do
    ///
    /// Write the number of lines that follow.
    COMMENT_COUNT: Warning Count, "eds/file/comment-count", "CiA 306" Unknown;

    /// the node-ID of a DCF is not in the range 1 to 127
    ///
    /// No device can have another node-ID.
    ///
    /// # What to do
    ///
    /// Write a node-ID from 1 to 127.
    NODE_ID: Error Value, "eds/dcf/node-id", "CiA 306" Unknown;

    /// the bit rate of a DCF is not a bit rate of CiA 301
    ///
    /// The bit rates are 10, 20, 50, 100, 125, 250, 500, 800 and 1000 kbit/s.
    ///
    /// # What to do
    ///
    /// Write one of these numbers, without unit.
    BIT_RATE: Error Value, "eds/dcf/bit-rate", "CiA 306" Unknown;

    /// a DCF leaves its node-ID or bit rate open
    ///
    /// A node-ID of 255 means that the device receives its node-ID by LSS; a bit rate of 0 means that there is none. A
    /// tool with only this file can't find the device.
    ///
    /// # What to do
    ///
    /// Write the node-ID and the bit rate of the network, or remove the field.
    OPEN: Warning Value, "eds/dcf/open", "CiA 306" Unknown;

    /// a DCF names a download file that is missing
    ///
    /// DownloadFile of a DOMAIN names the file that a configuration tool writes to the device. Without the file the
    /// tool stops, or does not change the object. A plain file name is searched in the folder of the DCF.
    ///
    /// # What to do
    ///
    /// Put the file into the folder of the DCF, or correct the name.
    DOWNLOAD: Warning MissingField, "eds/dcf/download-file", "CiA 306" Unknown;

    /// a DCF describes the device differently from its EDS
    ///
    /// A DCF is its EDS with the configured values of one device. If objects, types, access or limits differ, the DCF
    /// belongs to another release of the device, or was edited. LastEDS names the EDS, which is searched in the folder
    /// of the DCF.
    ///
    /// # What to do
    ///
    /// Create the DCF again from the right EDS; `canvass eds diff` shows all differences.
    OTHER_EDS: Warning List, "eds/dcf/other-eds", "CiA 306" Unknown;

    /// the section DeviceComissioning is written with double m
    ///
    /// CiA 306 spells the section with one m; tools that look for that name do not find node-ID and bit rate.
    ///
    /// # What to do
    ///
    /// Write `[DeviceComissioning]`.
    COMMISSIONING: Hint UnknownSection, "eds/dcf/section-name", "CiA 306" Unknown;
}
