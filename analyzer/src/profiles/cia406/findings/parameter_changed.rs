use super::node::operands;
use crate::findings::{Context, Report, Rule, Sink};
use crate::message::Service;
use crate::wire::error_control::State;
use canvass_macros::rule;

/// preset or scaling was written in operation
///
/// A client has written the operating parameters (6000h), the scaling (6001h, 6002h) or the preset (6003h) of an
/// operational encoder.
///
/// # Why
/// The position jumps while the machine uses it, although the shaft has not moved.
///
/// # What to do
/// If the write is intended (homing), make sure that the machine stands still and that the consumer knows of it.
/// Otherwise find out which tool or which part of the program writes the object.
#[rule(id = "encoder/parameter-changed", severity = Warning, rank = Detail, also = ProfileValues)]
struct ParameterChanged;

impl Rule for ParameterChanged {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        for operand in operands(context) {
            let state = context.scene.bus.node(operand.node).and_then(|node| node.state);
            let operational = state.is_some_and(|state| state.0 == State::OPERATIONAL);
            let moves_position = matches!(operand.object.index.0, 0x6000..=0x6003);
            let by_client = operand.written && context.decoded.service == Service::Sdo;
            if operational && by_client && moves_position {
                let report = Report::at(context.now()).node(operand.node);
                let report = report.detail(u64::from(operand.object.index.0));
                sink.report(report.evidence(context.evidence()), || {
                    format!("{} was set to {} in operational", operand.object, operand.raw)
                });
            }
        }
    }
}
