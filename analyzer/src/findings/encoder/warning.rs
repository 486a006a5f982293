use super::alarm::tell_bits;
use crate::findings::rule::{Also, Definition, Metadata, Rule};
use crate::findings::sink::Sink;
use crate::findings::{Context, Severity};

pub const RULE: Definition =
    Definition { metadata: &METADATA, services: &[], also: Also::EncoderValues, make: Some(|_| Box::new(Warning)) };

static METADATA: Metadata = Metadata {
    id: "encoder/warning",
    severity: Severity::Warning,
    title: "an encoder shows a warning",
    what: "6505h, in a PDO or read by SDO, is not 0. Findings are told apart by bit.",
    why: "The position is still valid, but a limit is passed: speed, light, battery, temperature, or operating time.",
    advice: "Plan to replace the battery or the device; a speed beyond the limit is the machine's. Bit 2 is a watchdog \
             reset: look for boot-ups without a command.",
    thresholds: &[],
};

struct Warning;

impl Rule for Warning {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        tell_bits(0x6505, "warning", context, sink);
    }
}
