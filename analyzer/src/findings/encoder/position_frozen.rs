use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Service;
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Pdo, Service::BootUp, Service::Nmt],
    make: Some(|thresholds| {
        Box::new(PositionFrozen {
            speed: thresholds.get(&METADATA, "speed"),
            time: Duration::from_millis(thresholds.get(&METADATA, "time")),
            nodes: (0..128).map(|_| Axis::default()).collect(),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "encoder/position-frozen",
    severity: Severity::Error,
    title: "the position stands still while the speed does not",
    what: "For a time, all PDOs of an encoder show the same position (6004h), while its speed (6030h) is never near 0.",
    why: "Either the position is frozen, and the machine does not see that it moves, or the speed is wrong.",
    advice: "A frozen position with a live speed is a fault of the device: restart it, and compare 6004h and the raw \
             position if it has one.",
    thresholds: &[
        Threshold { name: "speed", default: 10, unit: "", meaning: "as shown in 6030h; slower is standing" },
        Threshold { name: "time", default: 1000, unit: "ms", meaning: "for so long" },
    ],
};

struct PositionFrozen {
    speed: u64,
    time: Duration,
    nodes: Vec<Axis>,
}

#[derive(Default)]
struct Axis {
    /// The frame with which the position has come first, and the position.
    since: Option<(Seen, u64)>,
    /// Further PDOs with the same position, while the shaft turns.
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
        for operand in &context.news().operands {
            match (operand.object.index.0, operand.object.sub.0) {
                (0x6004, _) => position = Some(operand.raw),
                (0x6030, 1) => speed = Some(operand.signed()),
                _ => {}
            }
        }
        let axis = &mut self.nodes[usize::from(node.raw())];
        if let Some(speed) = speed {
            axis.turns = speed.unsigned_abs() >= self.speed;
            if !axis.turns {
                (axis.since, axis.same) = (None, 0);
            }
        }
        let Some(position) = position.filter(|_| axis.turns) else { return };
        match &axis.since {
            Some((_, known)) if *known == position => axis.same += 1,
            _ => (axis.since, axis.same) = (Some((context.seen(), position)), 0),
        }
        const ENOUGH: u32 = 5;
        let Some((first, _)) = axis.since.as_ref().filter(|_| axis.same >= ENOUGH) else { return };
        let lasted = context.now().since(first.time());
        if lasted >= self.time {
            let report = Report::at(first.time()).node(node).measure(lasted.nanos());
            sink.report(report.evidence(first.evidence()).evidence(context.evidence()), || {
                format!("position {position} for {lasted}, although the speed is not 0")
            });
        }
    }

    fn interrupted(&mut self) {
        self.nodes.iter_mut().for_each(|axis| *axis = Axis::default());
    }
}
