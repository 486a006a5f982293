use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use canvass_macros::rule;
use canvass_traces::Duration;

/// the event timer of a PDO is too short for the bit rate
///
/// The SDO traffic of the capture shows the event timer (180xh:5) of an event-driven TPDO, and it is shorter than the
/// device's manual allows at the bit rate of the bus. The bit rate is given by the user or inferred; if neither is
/// possible, the rule reports nothing.
///
/// # Why
/// A slow bus can't carry a PDO in each of such short cycles: other messages wait, and PDOs are lost.
///
/// # What to do
/// Lengthen the event timer, or raise the bit rate.
#[rule(id = "pdo/cycle-too-short", severity = Warning, rank = ProcessData, also = KnownTpdos)]
struct CycleTooShort;

impl Rule for CycleTooShort {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some((node, number, parameters)) = context.tpdo() else { return };
        let (Some(timer), Some(254 | 255)) = (parameters.event_timer, parameters.transmission_type) else { return };
        let known = context.scene.bus.node(node).and_then(|known| known.device.as_deref());
        let (Some(device), Some(rate)) = (known, context.scene.bit_rate) else { return };
        let Some(shortest) = device.manual.settings.shortest_cycle(rate) else { return };
        let shortest = Duration::from_millis(u64::from(shortest));
        if timer >= shortest {
            return;
        }
        let report = Report::at(context.now()).node(node).detail(u64::from(number)).evidence(context.evidence());
        sink.report(report, || {
            let kbit = f64::from(rate) / 1000.0;
            format!("TPDO {number} has the event timer {timer}, the manual allows {shortest} and more at {kbit} kbit/s")
        });
    }
}
