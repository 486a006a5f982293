//! The objects of the drive profile that code asks for, as indexes of the first axis.

/// 603Fh: error code.
pub const ERROR_CODE: u16 = 0x603F;
/// 6040h: controlword.
pub const CONTROLWORD: u16 = 0x6040;
/// 6041h: statusword.
pub const STATUSWORD: u16 = 0x6041;
/// 6042h: vl target velocity.
pub const VL_TARGET_VELOCITY: u16 = 0x6042;
/// 6060h: modes of operation.
pub const MODE: u16 = 0x6060;
/// 6061h: modes of operation display.
pub const MODE_DISPLAY: u16 = 0x6061;
/// 6071h: target torque.
pub const TARGET_TORQUE: u16 = 0x6071;
/// 607Ah: target position.
pub const TARGET_POSITION: u16 = 0x607A;
/// 60B0h: position offset.
pub const POSITION_OFFSET: u16 = 0x60B0;
/// 60B2h: torque offset; 60B1h before it is the velocity offset.
pub const TORQUE_OFFSET: u16 = 0x60B2;
/// 60C1h: the set-points of the interpolated position mode.
pub const INTERPOLATION_DATA: u16 = 0x60C1;
/// 60FDh: digital inputs.
pub const DIGITAL_INPUTS: u16 = 0x60FD;
/// 60FEh: digital outputs.
pub const DIGITAL_OUTPUTS: u16 = 0x60FE;
/// 60FFh: target velocity.
pub const TARGET_VELOCITY: u16 = 0x60FF;
/// 6502h: supported drive modes.
pub const SUPPORTED_MODES: u16 = 0x6502;
