//! The bits of registers. The state in the statusword and the command in the controlword have names as a whole, so that
//! their bits have none here; neither have bits of manufacturers and of single modes.

use super::objects;
use crate::identity::Index;

const STATUSWORD: &[&str] =
    &["", "", "", "", "voltage enabled", "", "", "warning", "", "remote", "target reached", "internal limit active"];

const CONTROLWORD: &[&str] = &["", "", "", "", "", "", "", "", "halt"];

const DIGITAL_INPUTS: &[&str] = &["negative limit switch", "positive limit switch", "home switch", "interlock"];

const DIGITAL_OUTPUTS: &[&str] = &["brake"];

const SUPPORTED_MODES: &[&str] = &[
    "profile position",
    "velocity",
    "profile velocity",
    "profile torque",
    "",
    "homing",
    "interpolated position",
    "cyclic synchronous position",
    "cyclic synchronous velocity",
    "cyclic synchronous torque",
];

/// The names of the bits of an object, from bit 0 on.
pub(super) const fn of(index: Index) -> &'static [&'static str] {
    match index.0 {
        objects::STATUSWORD => STATUSWORD,
        objects::CONTROLWORD => CONTROLWORD,
        objects::DIGITAL_INPUTS => DIGITAL_INPUTS,
        objects::DIGITAL_OUTPUTS => DIGITAL_OUTPUTS,
        objects::SUPPORTED_MODES => SUPPORTED_MODES,
        _ => &[],
    }
}
