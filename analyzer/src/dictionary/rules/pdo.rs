//! Rules on PDOs and COB-IDs.

use super::rules;

rules! {
    "eds";

    /// a PDO has only one of its two parameters
    ///
    /// A PDO has a communication parameter and a mapping parameter: 1400h with 1600h, 1800h with 1A00h, and so on. A
    /// tool can't configure a PDO with only one of them.
    ///
    /// # What to do
    ///
    /// Describe the missing parameter, or remove the other one.
    PAIR: Error Mapping, "eds/pdo/pair", "CiA 301" "7.5.2.37" Cited;

    /// the default transmission type is reserved
    ///
    /// The transmission types 241 to 251 are reserved, for an RPDO also 252 and 253. A device refuses a reserved value.
    ///
    /// # What to do
    ///
    /// Choose 0 to 240, 254 or 255; for a TPDO also 252 or 253.
    TRANSMISSION_TYPE: Warning Value, "eds/pdo/transmission-type", "CiA 301" "7.5.2.37" Cited;

    /// a TPDO communication parameter has sub-index 4
    ///
    /// Sub-index 4 is reserved: a device answers that the sub-index does not exist.
    ///
    /// # What to do
    ///
    /// Remove the sub-index.
    RESERVED_SUB: Hint Standard, "eds/pdo/reserved-sub-index", "CiA 301" "7.5.2.37" Cited;

    /// a mapping counts an entry that has no default
    ///
    /// Sub-index 0 holds the number of used entries. One of them names no object, so the content of the PDO is unknown.
    ///
    /// # What to do
    ///
    /// Add the default of the entry, or correct the count.
    ENTRY_MISSING: Error Mapping, "eds/pdo/entry-missing", "CiA 301" "7.5.2.38" Cited;

    /// a PDO maps an object that is not described
    ///
    /// A tool can't decode the bits of the PDO, and a device refuses the mapping with abort 0604 0041h.
    ///
    /// # What to do
    ///
    /// Correct the index and sub-index, or describe the object.
    TARGET: Error Mapping, "eds/pdo/target", "CiA 301" "7.5.2.38" Cited;

    /// a PDO maps an object with PDOMapping=0
    ///
    /// A tool that relies on PDOMapping refuses the mapping. A device whose description is correct refuses it with
    /// abort 0604 0041h.
    ///
    /// # What to do
    ///
    /// Set PDOMapping=1 for the object, or map another object.
    NOT_MAPPABLE: Error Mapping, "eds/pdo/not-mappable", "CiA 301" "7.5.2.38" Cited;

    /// the access type of a mapped object does not fit the direction of the PDO
    ///
    /// A TPDO carries readable entries other than rww, an RPDO writable entries other than rwr.
    ///
    /// # What to do
    ///
    /// Correct the access type, or map another object.
    DIRECTION: Warning Mapping, "eds/pdo/direction", "CiA 301" "7.5.2.38" Cited;

    /// the length in a mapping is not that of the mapped object
    ///
    /// The last byte of an entry is the length of the object in bits. With another length all following values in the
    /// PDO are read from the wrong place.
    ///
    /// # What to do
    ///
    /// Write the length of the object's data type.
    LENGTH: Error Mapping, "eds/pdo/length", "CiA 301" "7.5.2.38" Cited;

    /// a mappable entry can be read and written, without a PDO direction
    ///
    /// With AccessType=rw and PDOMapping=1 a tool offers the entry for RPDOs and for TPDOs. A device that supports only
    /// one direction refuses the other with abort 0604 0041h. Each object is reported once.
    ///
    /// # What to do
    ///
    /// Write rwr for an entry of TPDOs only and rww for an entry of RPDOs only; in XML PDOmapping="TPDO" or "RPDO".
    /// Leave the access type unchanged if both can carry the entry.
    EITHER: Hint Mapping, "eds/pdo/either-direction", "CiA 306" Unknown;

    /// a BOOLEAN is mapped as a whole byte
    ///
    /// A BOOLEAN has one bit. Devices whose PDOs hold whole bytes map it with 8 bits; tools that rely on the mapping
    /// read it correctly.
    ///
    /// # What to do
    ///
    /// Write 1 bit if the device can map single bits; otherwise give the object a data type of 8 bits.
    BOOLEAN: Warning Mapping, "eds/pdo/boolean", "CiA 301" "7.1.4.3" Cited;

    /// a PDO maps a dummy entry that is not allowed
    ///
    /// A dummy entry is the index of a data type and skips bits. It is allowed in RPDOs only, with the length of its
    /// data type, if DummyUsage allows that type.
    ///
    /// # What to do
    ///
    /// Allow the type in DummyUsage, or map another object.
    DUMMY: Error Mapping, "eds/pdo/dummy", "CiA 301" "7.4.7.1" Cited;

    /// a mapping violates Granularity
    ///
    /// Granularity is the smallest number of bits that can be mapped: mapped lengths are multiples of it.
    ///
    /// # What to do
    ///
    /// Correct Granularity, or the mapping.
    GRANULARITY: Warning Mapping, "eds/pdo/granularity", "CiA 306" Unknown;

    /// a PDO maps more than 64 bits
    ///
    /// A CAN frame has 8 bytes. A device refuses the mapping with abort 0604 0042h.
    ///
    /// # What to do
    ///
    /// Map fewer bits, or distribute the objects over two PDOs.
    TOO_LONG: Error Mapping, "eds/pdo/too-long", "CiA 301" "7.5.2.38" Cited;

    /// a COB-ID is reserved by CiA 301 for another service
    ///
    /// No other service may use the CAN-IDs of NMT, SYNC of other devices, default SDOs, heartbeat and LSS: a PDO with
    /// such a CAN-ID commands or confuses other devices.
    ///
    /// # What to do
    ///
    /// Choose a CAN-ID from 181h to 57Fh.
    RESTRICTED: Error CobId, "eds/cob-id/restricted", "CiA 301" "7.3.5" Cited;

    /// two messages that the device sends have the same COB-ID
    ///
    /// Receivers can't distinguish the two messages. A DCF is checked with its node-ID. In an EDS, a COB-ID with
    /// $NODEID is not compared with a COB-ID without it, because they are equal for one node-ID only.
    ///
    /// # What to do
    ///
    /// Give each message its own COB-ID, or switch one of them off with bit 31.
    COB_ID_TWICE: Error CobId, "eds/cob-id/twice", "CiA 301" "7.3.5" Known;

    /// two messages, at least one of them received, have the same COB-ID
    ///
    /// An RPDO receives messages for another RPDO, or messages that the device itself sends.
    ///
    /// # What to do
    ///
    /// Give each message its own COB-ID, or switch one of them off with bit 31. Leave the COB-IDs unchanged if two
    /// RPDOs are intended to receive the same message.
    COB_ID_SHARED: Warning CobId, "eds/cob-id/shared", "CiA 301" "7.3.5" Known;

    /// a default COB-ID differs from the predefined connection set
    ///
    /// By default the first four TPDOs have 180h, 280h, 380h and 480h plus the node-ID, the RPDOs 200h, 300h, 400h and
    /// 500h plus the node-ID, and EMCY 80h plus the node-ID; SYNC has 80h and TIME 100h. A network that relies on these
    /// defaults does not find the message.
    ///
    /// # What to do
    ///
    /// Write the formula of the predefined connection set, unless another COB-ID is intended.
    PREDEFINED: Hint CobId, "eds/cob-id/predefined", "CiA 301" "7.3.3" Cited;

    /// the COB-IDs of the first SDO server differ from the predefined connection set
    ///
    /// 1200h:01 is 600h plus the node-ID and 1200h:02 is 580h plus the node-ID. Both are fixed: every client uses them
    /// to reach the device. A tool that uses the COB-IDs of the file sends its requests to another node.
    ///
    /// # What to do
    ///
    /// Write $NODEID+0x600 and $NODEID+0x580.
    FIRST_SERVER: Warning CobId, "eds/cob-id/first-sdo-server", "CiA 301" "7.5.2.33" Cited;
}
