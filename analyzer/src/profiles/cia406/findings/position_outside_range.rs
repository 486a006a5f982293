use super::node::{kind, operands};
use crate::findings::{Context, Report, Rule, Sink};
use crate::message::Service;
use crate::profiles::cia406::kind::Kind;
use crate::profiles::cia406::objects;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;

#[derive(Clone, Copy, Default)]
struct Scaling {
    range: Option<u64>,
    on: Option<bool>,
}

/// a position is outside its measuring range
///
/// With scaling on (6000h bit 2, or 6500h), a position (6004h) is not below the total measuring range (6002h) that the
/// capture shows; or with scaling off, the position of a rotary encoder is not below the physical range, 6501h
/// multiplied by 6502h.
///
/// # Why
/// A master that calculates with the range derives a wrong position, often wrong by a whole range.
///
/// # What to do
/// Check whether the range was written with scaling off, or after the preset. If not, the device's firmware is faulty.
#[rule(
    id = "encoder/position-outside-range",
    severity = Error,
    rank = Detail,
    services = [BootUp],
    also = ProfileValues
)]
struct PositionOutsideRange {
    nodes: PerNode<Scaling>,
}

/// Bit 2 of 6000h.
const SCALING: u64 = 1 << 2;

/// The number of positions of the sensor itself: steps of one revolution (6501h) times revolutions (6502h).
fn physical_range(context: &Context<'_>, node: NodeId) -> Option<u64> {
    // On linear devices 6501h is the length of a step.
    let known = context.scene.bus.node(node).filter(|_| kind(context, node) == Some(Kind::Rotary))?;
    let of = |index| known.certain(node, Multiplexer::new(index, 0)).map(u64::from);
    of(objects::SINGLE_TURN_RESOLUTION)?.checked_mul(of(objects::NUMBER_OF_REVOLUTIONS)?).filter(|&range| range > 0)
}

impl Rule for PositionOutsideRange {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if context.decoded.service == Service::BootUp {
            if let Some(node) = context.node() {
                self.nodes[node] = Scaling::default();
            }
            return;
        }
        for operand in operands(context) {
            let scaling = &mut self.nodes[operand.node];
            match operand.object.index.0 {
                // 6500h shows which bits of 6000h are in force.
                objects::OPERATING_PARAMETERS | objects::OPERATING_STATUS => {
                    scaling.on = Some(operand.raw & SCALING != 0);
                }
                objects::TOTAL_MEASURING_RANGE => {
                    scaling.range = Some(if operand.raw == 0 { 1 << 32 } else { operand.raw });
                }
                objects::POSITION_VALUE if !operand.written => {
                    let range = match scaling.on {
                        Some(true) => scaling.range,
                        Some(false) => physical_range(context, operand.node),
                        None => None,
                    };
                    let Some(range) = range else { continue };
                    if operand.raw >= range {
                        let report = Report::at(context.now()).node(operand.node).measure(operand.raw);
                        sink.report(report.evidence(context.evidence()), || {
                            format!("position {} in a range of {range}", operand.raw)
                        });
                    }
                }
                _ => {}
            }
        }
    }
}
