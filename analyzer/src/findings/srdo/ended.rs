use crate::PerNode;
use crate::findings::rhythm::Rhythm;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::message::Message;
use crate::wire::srdo::Half;
use canvass_macros::rule;
use canvass_traces::Duration;

/// an SRDO does not come in its period
///
/// SRDOs come regularly, as their refresh time (1301h:2) demands. The data of an SRDO comes much later than it did
/// before, or does not come any more until the capture ends. NMT commands begin anew.
///
/// # Why
/// Its consumers go to their safe state once the refresh time is over.
///
/// # What to do
/// If the node sends other messages, see its state and its errors; else see why it fell silent.
#[rule(id = "srdo/ended", severity = Error, rank = ProcessData, services = [Srdo, Nmt])]
struct Ended {
    /// beyond this share of the period an SRDO counts as missing
    #[threshold(percent = 180)]
    percent: Percent,
    /// a smaller delay is not reported
    #[threshold(ms = 20)]
    least: Duration,
    nodes: PerNode<Rhythm>,
    latest: PerNode<Option<Seen>>,
}

impl Rule for Ended {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Message::Srdo(srdo) = context.message() else {
            if context.begins_anew() {
                self.interrupted();
            }
            return;
        };
        let Some(node) = context.node().filter(|_| srdo.half == Half::Normal) else { return };
        let interval = self.nodes[node].beat(context.now());
        let before = self.latest[node].replace(context.seen());
        let slack = self.least + context.scene.slack();
        let Some((interval, period)) = interval.and_then(|own| Some((own, own.exceeds(self.percent, slack)?))) else {
            return;
        };
        let report = Report::at(context.now()).node(node).measure(interval.length.nanos());
        let report = report.evidence(before.as_ref().map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("an SRDO after {}, but its period is {period}", interval.length));
    }

    fn interrupted(&mut self) {
        self.nodes.values_mut().for_each(Rhythm::pause);
        self.latest.reset();
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        const ENDED: Percent = Percent(500);
        for (node, latest) in self.latest.iter() {
            let (Some(latest), Some(period)) = (latest, self.nodes[node].period()) else { continue };
            let silence = scene.now.since(latest.time());
            if silence <= ENDED.of(period) + self.least + scene.slack() {
                continue;
            }
            sink.report(Report::at(latest.time()).until(scene.now).node(node).evidence(latest.evidence()), || {
                format!("no SRDO for the last {silence} of the capture, its period is {period}")
            });
        }
    }
}
