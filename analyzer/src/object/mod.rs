//! The objects of the communication profile by their names (CiA 301, 7.5.2), as indexes.

mod acting;

pub use acting::Acting;

/// 1000h: device type.
pub const DEVICE_TYPE: u16 = 0x1000;
/// 1001h: error register.
pub const ERROR_REGISTER: u16 = 0x1001;
/// 1002h: manufacturer status register.
pub const MANUFACTURER_STATUS_REGISTER: u16 = 0x1002;
/// 1003h: pre-defined error field.
pub const PREDEFINED_ERROR_FIELD: u16 = 0x1003;
/// 1004h of DS-301 V3.0: number of PDOs.
pub const NUMBER_OF_PDOS: u16 = 0x1004;
/// 1005h: COB-ID SYNC message.
pub const COB_ID_SYNC: u16 = 0x1005;
/// 1006h: communication cycle period.
pub const COMMUNICATION_CYCLE_PERIOD: u16 = 0x1006;
/// 1007h: synchronous window length.
pub const SYNCHRONOUS_WINDOW_LENGTH: u16 = 0x1007;
/// 1008h: manufacturer device name.
pub const MANUFACTURER_DEVICE_NAME: u16 = 0x1008;
/// 1009h: manufacturer hardware version.
pub const MANUFACTURER_HARDWARE_VERSION: u16 = 0x1009;
/// 100Ah: manufacturer software version.
pub const MANUFACTURER_SOFTWARE_VERSION: u16 = 0x100A;
/// 100Bh of DS-301 V3.0: node-ID.
pub const NODE_ID: u16 = 0x100B;
/// 100Ch: guard time.
pub const GUARD_TIME: u16 = 0x100C;
/// 100Dh: life time factor.
pub const LIFE_TIME_FACTOR: u16 = 0x100D;
/// 100Eh of DS-301 V3.0: COB-ID of the guarding protocol.
pub const COB_ID_GUARDING: u16 = 0x100E;
/// 1010h: store parameters.
pub const STORE_PARAMETERS: u16 = 0x1010;
/// 1011h: restore default parameters.
pub const RESTORE_DEFAULT_PARAMETERS: u16 = 0x1011;
/// 1012h: COB-ID time stamp object.
pub const COB_ID_TIME: u16 = 0x1012;
/// 1013h: high resolution time stamp.
pub const HIGH_RESOLUTION_TIME_STAMP: u16 = 0x1013;
/// 1014h: COB-ID EMCY.
pub const COB_ID_EMCY: u16 = 0x1014;
/// 1015h: inhibit time EMCY.
pub const INHIBIT_TIME_EMCY: u16 = 0x1015;
/// 1016h: consumer heartbeat time.
pub const CONSUMER_HEARTBEAT_TIME: u16 = 0x1016;
/// 1017h: producer heartbeat time.
pub const PRODUCER_HEARTBEAT_TIME: u16 = 0x1017;
/// 1018h: identity object.
pub const IDENTITY: u16 = 0x1018;
/// 1019h: synchronous counter overflow value.
pub const SYNCHRONOUS_COUNTER_OVERFLOW: u16 = 0x1019;
/// 1020h: verify configuration.
pub const VERIFY_CONFIGURATION: u16 = 0x1020;
/// 1023h: operating system command.
pub(crate) const OS_COMMAND: u16 = 0x1023;
/// 1026h: operating system prompt.
pub(crate) const OS_PROMPT: u16 = 0x1026;
/// 1028h: emergency consumer object.
pub const EMERGENCY_CONSUMER: u16 = 0x1028;
/// 1029h: error behavior object.
pub const ERROR_BEHAVIOR: u16 = 0x1029;
/// 1200h: the first of the SDO server parameters, which belongs to the default channel.
pub const SDO_SERVER_PARAMETER: u16 = 0x1200;
/// 1201h: the first of the SDO server parameters of further channels.
pub const FURTHER_SDO_SERVER_PARAMETER: u16 = 0x1201;
/// 1280h: the first of the SDO client parameters.
pub const SDO_CLIENT_PARAMETER: u16 = 0x1280;
/// 1400h: the first of the RPDO communication parameters.
pub const RPDO_COMMUNICATION_PARAMETER: u16 = 0x1400;
/// 1600h: the first of the RPDO mapping parameters.
pub const RPDO_MAPPING_PARAMETER: u16 = 0x1600;
/// 1800h: the first of the TPDO communication parameters.
pub const TPDO_COMMUNICATION_PARAMETER: u16 = 0x1800;
/// 1A00h: the first of the TPDO mapping parameters.
pub const TPDO_MAPPING_PARAMETER: u16 = 0x1A00;
/// 1C00h: the first index after the TPDO mapping parameters.
pub const AFTER_PDO_PARAMETERS: u16 = 0x1C00;
/// 1F25h: configure slave: a write lets a configuration manager download to others (CiA 302-3).
pub(crate) const CONFIGURE_SLAVE: u16 = 0x1F25;
/// 1F50h: download program data (CiA 302-3).
pub(crate) const PROGRAM_DATA: u16 = 0x1F50;
/// 1F51h: program control (CiA 302-3).
pub(crate) const PROGRAM_CONTROL: u16 = 0x1F51;
/// 1F80h: NMT startup (CiA 302-2).
pub const NMT_STARTUP: u16 = 0x1F80;
/// 1F82h: request NMT: a write commands other nodes (CiA 302-2).
pub(crate) const REQUEST_NMT: u16 = 0x1F82;
/// 1F83h: request guarding (CiA 302-2).
pub(crate) const REQUEST_GUARDING: u16 = 0x1F83;

/// Whether an index belongs to the communication parameter of an RPDO.
pub const fn is_rpdo_communication(index: u16) -> bool {
    matches!(index, RPDO_COMMUNICATION_PARAMETER..RPDO_MAPPING_PARAMETER)
}

/// Whether an index belongs to the communication parameter of a TPDO.
pub const fn is_tpdo_communication(index: u16) -> bool {
    matches!(index, TPDO_COMMUNICATION_PARAMETER..TPDO_MAPPING_PARAMETER)
}

/// Whether an index belongs to the communication parameter of a PDO.
pub const fn is_pdo_communication(index: u16) -> bool {
    is_rpdo_communication(index) || is_tpdo_communication(index)
}

/// Whether an index belongs to the mapping parameter of a PDO.
pub const fn is_pdo_mapping(index: u16) -> bool {
    matches!(index, RPDO_MAPPING_PARAMETER..TPDO_COMMUNICATION_PARAMETER | TPDO_MAPPING_PARAMETER..AFTER_PDO_PARAMETERS)
}
