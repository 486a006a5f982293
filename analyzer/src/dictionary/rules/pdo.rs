//! Rules on PDOs and COB-IDs.

use super::rules;

rules! {
    "eds";

    /// a PDO has only one of its two parameters
    ///
    /// Communication parameter and mapping parameter come in pairs: 1400h with 1600h, 1800h with 1A00h, and so on. A tool
    /// can't configure half a PDO.
    ///
    /// # What to do
    ///
    /// Describe the other one, or remove the one that is there.
    PAIR: Error Mapping, "eds/pdo/pair", "CiA 301" "7.5.2.37" Cited;

    /// the default of a transmission type is reserved
    ///
    /// 241 to 251 are reserved, and for an RPDO 252 and 253, too. A device refuses such a value.
    ///
    /// # What to do
    ///
    /// Choose 0 to 240, 254 or 255; for a TPDO also 252 or 253.
    TRANSMISSION_TYPE: Warning Value, "eds/pdo/transmission-type", "CiA 301" "7.5.2.37" Cited;

    /// a TPDO communication parameter has sub-index 4
    ///
    /// It is reserved: a device answers there that there is no such sub-index.
    ///
    /// # What to do
    ///
    /// Remove the sub-index.
    RESERVED_SUB: Hint Standard, "eds/pdo/reserved-sub-index", "CiA 301" "7.5.2.37" Cited;

    /// a mapping counts an entry that has no default
    ///
    /// Sub-index 0 says how many entries are in use. One of them names no object, so the content of the PDO is unknown.
    ///
    /// # What to do
    ///
    /// Give the entry its default, or correct the count.
    ENTRY_MISSING: Error Mapping, "eds/pdo/entry-missing", "CiA 301" "7.5.2.38" Cited;

    /// a PDO maps an object that is not described
    ///
    /// A tool can't tell what the bits of the PDO are, and a device refuses the mapping with abort 0604 0041h.
    ///
    /// # What to do
    ///
    /// Correct the index and sub-index, or describe the object.
    TARGET: Error Mapping, "eds/pdo/target", "CiA 301" "7.5.2.38" Cited;

    /// a PDO maps an object with PDOMapping=0
    ///
    /// A tool that goes by PDOMapping refuses the mapping, and a device whose description is right refuses it with abort
    /// 0604 0041h.
    ///
    /// # What to do
    ///
    /// Set PDOMapping=1 for the object, or map another one.
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
    /// one direction refuses the other with abort 0604 0041h. One such entry is reported for each object.
    ///
    /// # What to do
    ///
    /// Write rwr for an entry of TPDOs only and rww for an entry of RPDOs only; in XML PDOmapping="TPDO" or "RPDO".
    /// Leave it unchanged if both can carry the entry.
    EITHER: Hint Mapping, "eds/pdo/either-direction", "CiA 306" Unknown;

    /// a BOOLEAN is mapped as a whole byte
    ///
    /// A BOOLEAN has one bit. Devices whose PDOs hold whole bytes map it with 8, and tools that believe the mapping read it
    /// rightly.
    ///
    /// # What to do
    ///
    /// Write 1 bit where the device can map single bits; else give the object a type of 8 bits.
    BOOLEAN: Warning Mapping, "eds/pdo/boolean", "CiA 301" "7.1.4.3" Cited;

    /// a PDO maps a dummy entry that is not allowed
    ///
    /// The index of a data type skips bits, in RPDOs only, where DummyUsage allows the type, and with its length.
    ///
    /// # What to do
    ///
    /// Allow the type in DummyUsage, or map another object.
    DUMMY: Error Mapping, "eds/pdo/dummy", "CiA 301" "7.4.7.1" Cited;

    /// a mapping goes against Granularity
    ///
    /// Granularity is the smallest number of bits that can be mapped: lengths are multiples of it.
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
    /// Map less, or distribute it over two PDOs.
    TOO_LONG: Error Mapping, "eds/pdo/too-long", "CiA 301" "7.5.2.38" Cited;

    /// a COB-ID is reserved by CiA 301 for another service
    ///
    /// NMT, SYNC of others, default SDOs, heartbeat and LSS have CAN-IDs that no other service may use: such a PDO commands
    /// or confuses other devices.
    ///
    /// # What to do
    ///
    /// Choose a CAN-ID from 181h to 57Fh.
    RESTRICTED: Error CobId, "eds/cob-id/restricted", "CiA 301" "7.3.5" Cited;

    /// two messages that the device sends have the same COB-ID
    ///
    /// Receivers can't tell them apart. In a DCF its node-ID counts; in an EDS a COB-ID with $NODEID and one without
    /// are not compared, as they are the same for one node-ID only.
    ///
    /// # What to do
    ///
    /// Give each a COB-ID of its own, or switch one off with bit 31.
    COB_ID_TWICE: Error CobId, "eds/cob-id/twice", "CiA 301" "7.3.5" Known;

    /// two messages, at least one of them received, have the same COB-ID
    ///
    /// An RPDO takes messages that are meant for another RPDO, or that the device itself sends.
    ///
    /// # What to do
    ///
    /// Give each a COB-ID of its own, or switch one off with bit 31. Leave it unchanged if two RPDOs are meant to take
    /// the same message.
    COB_ID_SHARED: Warning CobId, "eds/cob-id/shared", "CiA 301" "7.3.5" Known;

    /// a default COB-ID is not that of the predefined connection set
    ///
    /// By default the first four TPDOs have 180h, 280h, 380h and 480h plus the node-ID, the RPDOs 200h, 300h, 400h and
    /// 500h, and EMCY 80h; SYNC has 80h and TIME 100h. A network that relies on these defaults does not find the
    /// message.
    ///
    /// # What to do
    ///
    /// Write the formula of the predefined connection set, unless another COB-ID is intended.
    PREDEFINED: Hint CobId, "eds/cob-id/predefined", "CiA 301" "7.3.3" Cited;

    /// the first SDO server has not the COB-IDs of the predefined connection set
    ///
    /// 1200h:01 is 600h and 1200h:02 is 580h plus the node-ID, and both are fixed: every client reaches the device by
    /// them. A tool that follows the file sends its requests to another node.
    ///
    /// # What to do
    ///
    /// Write $NODEID+0x600 and $NODEID+0x580.
    FIRST_SERVER: Warning CobId, "eds/cob-id/first-sdo-server", "CiA 301" "7.5.2.33" Cited;
}
