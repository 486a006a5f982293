use super::alarm::{FOLLOWS, tell_bits};
use crate::findings::{Context, Rule, Sink};
use crate::profiles::cia406::objects;
use canvass_macros::rule;

/// an encoder shows a warning
///
/// 6505h, in a PDO or read by SDO, is not 0. Each bit has its own finding.
///
/// # Why
/// The position is still valid, but a limit is exceeded: speed, light, battery, temperature, or operating time.
///
/// # What to do
/// Plan to replace the battery or the device. A speed beyond the limit is caused by the machine. Bit 2 is a watchdog
/// reset: look for boot-ups without a command.
#[rule(id = "encoder/warning", severity = Warning, rank = Detail, also = ProfileValues, follows = FOLLOWS)]
struct Warning;

impl Rule for Warning {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        tell_bits(objects::WARNINGS, "warning", context, sink);
    }
}
