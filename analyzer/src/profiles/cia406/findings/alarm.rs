use super::node::operands;
use crate::dictionary::names::bit_name;
use crate::findings::{Context, Effect, Report, Rule, SETTLE, SOON, Sink};
use crate::profiles::cia406::NUMBER;
use crate::profiles::cia406::objects;
use canvass_macros::rule;

/// The findings from which alarms and warnings follow: an EMCY reports a condition that the encoder then shows.
pub(crate) const FOLLOWS: &[(&str, Effect)] =
    &[("emcy/raised", Effect::on(&["encoder/alarm", "encoder/warning"]).of_same_node().during(SOON, SETTLE))];

/// an encoder shows an alarm
///
/// 6503h, in a PDO or read by SDO, is not 0. Each bit has its own finding.
///
/// # Why
/// The position is no longer valid: a machine that uses it moves to wrong places.
///
/// # What to do
/// Bit 0 is a position error of the disk, magnet or sensor. The manual of the device describes bits 12 to 15. The EMCY
/// at the same time gives more details.
#[rule(id = "encoder/alarm", severity = Error, rank = DeviceError, also = ProfileValues, follows = FOLLOWS)]
struct Alarm;

/// Reports each set bit.
pub(crate) fn tell_bits(index: u16, kind: &str, context: &Context<'_>, sink: &mut Sink<'_>) {
    for operand in operands(context) {
        if operand.object.index.0 != index || operand.written {
            continue;
        }
        for bit in (0..16).filter(|bit| operand.raw >> bit & 1 != 0) {
            let report = Report::at(context.now()).node(operand.node).detail(u64::from(bit));
            sink.report(report.evidence(context.evidence()), || {
                let described = context.scene.bus.node(operand.node).and_then(|node| node.device.as_deref());
                let annotated = described.and_then(|device| device.manual.annotations.get(operand.object));
                let annotated = annotated.and_then(|annotation| annotation.bit(bit)).map(|name| name.name.to_string());
                let standard = || bit_name(operand.object.index, bit, Some(NUMBER)).map(str::to_owned);
                // A bit that the manual calls unused has an empty name.
                let name = annotated
                    .or_else(standard)
                    .filter(|name| !name.is_empty())
                    .map(|name| format!(": {}", name.escape_debug()));
                format!("{kind} bit {bit} of {}{}", operand.object, name.unwrap_or_default())
            });
        }
    }
}

impl Rule for Alarm {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        tell_bits(objects::ALARMS, "alarm", context, sink);
    }
}
