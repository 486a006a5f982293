//! The objects of the encoder profile by their names (CiA 406, 6000h to 67FFh), as indexes.

/// 6000h: operating parameters.
pub const OPERATING_PARAMETERS: u16 = 0x6000;
/// 6001h: measuring units per revolution.
pub const UNITS_PER_REVOLUTION: u16 = 0x6001;
/// 6002h: total measuring range in measuring units.
pub const TOTAL_MEASURING_RANGE: u16 = 0x6002;
/// 6003h: preset value.
pub const PRESET_VALUE: u16 = 0x6003;
/// 6004h: position value.
pub const POSITION_VALUE: u16 = 0x6004;
/// 6005h: measuring steps of a linear encoder.
pub const MEASURING_STEPS: u16 = 0x6005;
/// 6008h: high precision position value.
pub const HIGH_PRECISION_POSITION: u16 = 0x6008;
/// 6009h: high precision preset value.
pub const HIGH_PRECISION_PRESET: u16 = 0x6009;
/// 600Bh: high resolution position raw value.
pub const HIGH_RESOLUTION_RAW_VALUE: u16 = 0x600B;
/// 600Ch: position raw value.
pub const POSITION_RAW_VALUE: u16 = 0x600C;
/// 6010h: preset values for multi-sensor devices.
pub(crate) const CHANNEL_PRESET_VALUES: u16 = 0x6010;
/// 6020h: position values for multi-sensor devices.
pub const CHANNEL_POSITION_VALUES: u16 = 0x6020;
/// 6030h: speed value.
pub const SPEED_VALUE: u16 = 0x6030;
/// 6031h: speed parameter.
pub const SPEED_PARAMETER: u16 = 0x6031;
/// 6040h: acceleration value.
pub const ACCELERATION_VALUE: u16 = 0x6040;
/// 6041h: acceleration parameter.
pub const ACCELERATION_PARAMETER: u16 = 0x6041;
/// 6050h: jerk value.
pub const JERK_VALUE: u16 = 0x6050;
/// 6200h: cyclic timer.
pub const CYCLIC_TIMER: u16 = 0x6200;
/// 6300h: cam state register.
pub const CAM_STATE: u16 = 0x6300;
/// 6301h: cam enable register.
pub const CAM_ENABLE: u16 = 0x6301;
/// 6302h: cam polarity register.
pub const CAM_POLARITY: u16 = 0x6302;
/// 6310h: the low limit of the first cam.
pub const CAM_LOW_LIMIT: u16 = 0x6310;
/// 6320h: the high limit of the first cam.
pub const CAM_HIGH_LIMIT: u16 = 0x6320;
/// 6330h: the hysteresis of the first cam.
pub const CAM_HYSTERESIS: u16 = 0x6330;
/// 6400h: area state register.
pub const WORK_AREA_STATE: u16 = 0x6400;
/// 6401h: work area low limit.
pub const WORK_AREA_LOW_LIMIT: u16 = 0x6401;
/// 6402h: work area high limit.
pub const WORK_AREA_HIGH_LIMIT: u16 = 0x6402;
/// 6500h: operating status.
pub const OPERATING_STATUS: u16 = 0x6500;
/// 6501h: single-turn resolution; of a linear encoder the measuring step.
pub const SINGLE_TURN_RESOLUTION: u16 = 0x6501;
/// 6502h: number of distinguishable revolutions.
pub const NUMBER_OF_REVOLUTIONS: u16 = 0x6502;
/// 6503h: alarms.
pub const ALARMS: u16 = 0x6503;
/// 6504h: supported alarms.
pub const SUPPORTED_ALARMS: u16 = 0x6504;
/// 6505h: warnings.
pub const WARNINGS: u16 = 0x6505;
/// 6506h: supported warnings.
pub const SUPPORTED_WARNINGS: u16 = 0x6506;
/// 6507h: profile and software version.
pub const PROFILE_AND_SOFTWARE_VERSION: u16 = 0x6507;
/// 6508h: operating time.
pub const OPERATING_TIME: u16 = 0x6508;
/// 6509h: offset value.
pub const OFFSET_VALUE: u16 = 0x6509;
/// 650Ah: module identification.
pub const MODULE_IDENTIFICATION: u16 = 0x650A;
/// 650Bh: serial number.
pub const SERIAL_NUMBER: u16 = 0x650B;
