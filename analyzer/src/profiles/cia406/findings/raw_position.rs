use super::node::operands;
use crate::dictionary::Checked;
use crate::findings::{Context, Operand, Report, Rule, Sink};
use crate::message::Service;
use crate::wire::sdo::crc16;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Timestamp;

/// The values of one device that belong together.
#[derive(Clone, Copy, Default)]
struct Values {
    /// The last value, with its time.
    value: Option<(u32, Timestamp)>,
    /// The CRC that was shown after the last value.
    crc: Option<u16>,
}

/// a raw position contradicts its inverse or its checksum
///
/// The manual of the device names objects that repeat the raw position for comparison, such as 2160h with its inverse
/// 2161h and its CRC 2162h. The inverse is farther from the position than the shaft can have turned between both
/// transfers; or the position was the same before and after the CRC, and the CRC belongs to another one.
///
/// # Why
/// The objects exist so that a safe control can detect a faulty sensor or a faulty transmission. One of the values is
/// wrong.
///
/// # What to do
/// Stop relying on this device. Read the objects again at rest: if they still contradict each other, the device is
/// faulty.
#[rule(id = "encoder/raw-position", severity = Error, rank = Detail, services = [BootUp], also = ProfileValues)]
struct RawPosition {
    /// a shaft turns by at most this number of steps in a second
    #[threshold(count = 20_000_000, unit = "steps")]
    speed: u64,
    nodes: PerNode<Values>,
}

impl Rule for RawPosition {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        if context.decoded.service == Service::BootUp {
            self.nodes[node] = Values::default();
            return;
        }
        let known = context.scene.bus.node(node).and_then(|node| node.device.as_deref());
        let Some(checked) = known.and_then(|device| device.manual.checked.first()) else { return };
        for operand in operands(context).iter().filter(|operand| !operand.written) {
            self.shown(node, checked, operand, context, sink);
        }
    }
}

impl RawPosition {
    fn shown(&mut self, node: NodeId, checked: &Checked, shown: &Operand, context: &Context<'_>, sink: &mut Sink<'_>) {
        let values = &mut self.nodes[node];
        let (object, raw) = (Some(shown.object), shown.raw as u32);
        if shown.object == checked.value && shown.bits == 32 {
            let before = values.value.replace((raw, context.now()));
            let crc = values.crc.take().filter(|_| before.is_some_and(|(before, _)| before == raw));
            let expected = crc16(checked.crc_start, &raw.to_le_bytes());
            if let Some(crc) = crc.filter(|&crc| crc != expected) {
                report(node, 1, context, sink, || format!("{raw:08X}h has the CRC {expected:04X}h, found {crc:04X}h"));
            }
        } else if object == checked.crc && shown.bits == 16 {
            values.crc = Some(raw as u16);
        } else if object == checked.inverse && shown.bits == 32 {
            let Some((value, at)) = values.value.filter(|_| context.scene.has_times()) else { return };
            let elapsed = (context.now().since(at) + context.scene.slack()).nanos();
            let most = u128::from(self.speed) * u128::from(elapsed) / 1_000_000_000;
            let (turned, least) = (value.abs_diff(!raw), value.min(!raw));
            // At the end of its range the position goes on at 0.
            if u128::from(turned) > most && u128::from(least) > most {
                report(node, 0, context, sink, || {
                    format!("{value:08X}h has the inverse {:08X}h, found {raw:08X}h", !value)
                });
            }
        }
    }
}

fn report(node: NodeId, detail: u64, context: &Context<'_>, sink: &mut Sink<'_>, text: impl FnOnce() -> String) {
    sink.report(Report::at(context.now()).node(node).detail(detail).evidence(context.evidence()), text);
}
