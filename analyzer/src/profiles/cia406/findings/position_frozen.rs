use super::node::operands;
use crate::PerNode;
use crate::findings::{Context, Report, Rule, Seen, Sink};
use crate::message::Service;
use crate::profiles::cia406::objects;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// the position stands still while the speed does not
///
/// All PDOs of an encoder show the same position (6004h) for some time, while its speed (6030h) is never near 0.
///
/// # Why
/// Either the position is frozen, and the machine does not notice its movement, or the speed is wrong.
///
/// # What to do
/// A device with a frozen position and a changing speed is faulty: restart it, and compare 6004h with the raw position
/// if it has one.
#[rule(id = "encoder/position-frozen", severity = Error, rank = Detail, services = [BootUp, Nmt], also = ProfileValues)]
struct PositionFrozen {
    /// a lower value of 6030h counts as standing still
    #[threshold(count = 10)]
    speed: u64,
    /// least time of a constant position at a higher speed
    #[threshold(ms = 1000)]
    time: Duration,
    nodes: PerNode<Axis>,
}

#[derive(Default)]
struct Axis {
    /// Time of the first message with the current position, and the position.
    since: Option<(Timestamp, u64)>,
    /// The frame in which the position came first; kept only when the position has come again.
    first: Option<Seen>,
    /// Number of further PDOs with the same position while the shaft turns.
    same: u32,
    turns: bool,
}

impl Rule for PositionFrozen {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node().filter(|_| context.decoded.service == Service::Pdo) else {
            if context.decoded.service == Service::BootUp || context.begins_anew() {
                self.interrupted();
            }
            return;
        };
        let (mut position, mut speed) = (None, None);
        for operand in operands(context) {
            match (operand.object.index.0, operand.object.sub.0) {
                (objects::POSITION_VALUE, _) => position = Some(operand.raw),
                (objects::SPEED_VALUE, 1) => speed = Some(operand.signed()),
                _ => {}
            }
        }
        let axis = &mut self.nodes[node];
        if let Some(speed) = speed {
            axis.turns = speed.unsigned_abs() >= self.speed;
            if !axis.turns {
                (axis.since, axis.same) = (None, 0);
            }
        }
        let Some(position) = position.filter(|_| axis.turns) else { return };
        let Some((since, _)) = axis.since.filter(|(_, known)| *known == position) else {
            (axis.since, axis.same) = (Some((context.now(), position)), 0);
            return;
        };
        axis.same += 1;
        if axis.same == 1 {
            // Copying every frame would cost more than everything else here.
            axis.first = context.previous.cloned();
        }
        const ENOUGH: u32 = 5;
        let lasted = context.now().since(since);
        if axis.same >= ENOUGH && lasted >= self.time {
            let report = Report::at(since).node(node).measure(lasted.nanos());
            let report = report.evidence(axis.first.as_ref().map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || format!("position {position} for {lasted}, although the speed is not 0"));
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }
}
