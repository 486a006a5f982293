use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Message;
use crate::wire::flying_master::FlyingMaster;
use canvass_macros::rule;
use canvass_traces::Duration;

/// the negotiation of flying masters goes wrong
///
/// Two masters report on 071h that they are active, and no negotiation (072h, 076h) came between. Three events are an
/// information: the priority on 071h is reserved; a master answers a detection on 074h that no master has requested on 075h;
/// or no master answers a detection, and the negotiation continues nevertheless. The text of CiA 302-2 is not public, so no
/// clause is cited.
///
/// # Why
/// Two active masters command the nodes against each other. A master that is not detected does not take over.
///
/// # What to do
/// Compare 1F90h of all masters: the priorities and the times must fit each other.
#[rule(id = "bus/flying-master", severity = Warning, rank = Participants, services = [FlyingMaster])]
struct Negotiation {
    /// The request for a detection, until a master answers.
    detection: Option<Seen>,
    /// Whether a master has requested a detection.
    is_asked: bool,
    /// The master that was active last, since the last negotiation.
    active: Option<(u8, Seen)>,
    /// Whether a message of the negotiation came before.
    began: bool,
}

/// The lowest priority of a master; higher values are reserved.
const LOWEST_PRIORITY: u8 = 2;

impl Negotiation {
    fn active(&mut self, (priority, node): (u8, u8), context: &Context<'_>, sink: &mut Sink<'_>) {
        if priority > LOWEST_PRIORITY {
            let report = Report::at(context.now()).detail(1).severity(Severity::Info);
            sink.report(report.evidence(context.evidence()), || format!("the priority {priority} on 071h is reserved"));
        }
        let before = self.active.replace((node, context.seen()));
        if let Some((other, seen)) = before.filter(|(other, _)| *other != node) {
            let report = Report::at(context.now()).evidence(seen.evidence()).evidence(context.evidence());
            sink.report(report, || {
                format!("node {other} and node {node} both say on 071h that they are the active master")
            });
        }
    }

    /// Reports a detection without an answer, as the next step of the negotiation begins.
    fn goes_on(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(asked) = self.detection.take() else { return };
        let report = Report::at(asked.time()).detail(2).severity(Severity::Info);
        sink.report(report.evidence(asked.evidence()).evidence(context.evidence()), || {
            "no master answers the detection on 075h, and the negotiation continues".to_owned()
        });
    }

    fn detected(&mut self, is_early: bool, context: &Context<'_>, sink: &mut Sink<'_>) {
        self.detection = None;
        if !self.is_asked && !is_early {
            let report = Report::at(context.now()).detail(3).severity(Severity::Info);
            sink.report(report.evidence(context.evidence()), || {
                "a master answers on 074h, but no master has requested a detection on 075h".to_owned()
            });
        }
    }
}

impl Rule for Negotiation {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Message::FlyingMaster(message) = *context.message() else { return };
        let began = std::mem::replace(&mut self.began, true);
        let is_early = !began && context.now().since(context.scene.start) < Duration::from_secs(1);
        match message {
            FlyingMaster::ActiveMaster { priority, node } => self.active((priority, node), context, sink),
            FlyingMaster::MasterDetected => self.detected(is_early, context, sink),
            FlyingMaster::MasterDetectionRequest => {
                self.goes_on(context, sink);
                (self.detection, self.is_asked) = (Some(context.seen()), true);
            }
            FlyingMaster::ActiveMasterRequest => self.goes_on(context, sink),
            FlyingMaster::NegotiationRequest | FlyingMaster::ForceNegotiation => {
                self.goes_on(context, sink);
                self.active = None;
            }
        }
    }

    fn interrupted(&mut self) {
        // The request for a detection may be missing.
        (self.detection, self.is_asked, self.active) = (None, true, None);
    }
}
