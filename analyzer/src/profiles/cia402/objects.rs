//! The objects of the drive profile that code asks for, as indexes of the first axis.

/// 603Fh: error code.
pub const ERROR_CODE: u16 = 0x603F;
/// 6040h: controlword.
pub const CONTROLWORD: u16 = 0x6040;
/// 6041h: statusword.
pub const STATUSWORD: u16 = 0x6041;
/// 6060h: modes of operation.
pub const MODE: u16 = 0x6060;
/// 6061h: modes of operation display.
pub const MODE_DISPLAY: u16 = 0x6061;
/// 60FDh: digital inputs.
pub const DIGITAL_INPUTS: u16 = 0x60FD;
/// 60FEh: digital outputs.
pub const DIGITAL_OUTPUTS: u16 = 0x60FE;
/// 6502h: supported drive modes.
pub const SUPPORTED_MODES: u16 = 0x6502;
